/* Where the arrays of a state lie in its block (state_layout.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/state/state_layout.h"

#include <string.h>

#include "core/base/alignment_check.h"
#include "core/linear_algebra/secant.h"

/* Doubles of each kind of array, rounded up to whole alignments. */
typedef struct sizes {
  uint64_t vector, past, pairs, work, restricted, inverse, inverses, next, tangent, plastic, shares,
      shapes, levels, ahead;
} sizes;

static uint64_t round_up(uint64_t doubles) {
  const uint64_t lane = THRUM_ALIGNMENT / sizeof(double);
  return (doubles + lane - 1) / lane * lane;
}

static sizes sizes_of(const thrum_state *state) {
  const uint64_t vector = round_up((uint64_t)state->rank);
  const uint64_t inverse = round_up((uint64_t)state->kept_count);

  // every array begins at a multiple of the alignment
  const sizes s = {
      .vector = vector,
      .past = THRUM_PAST_SOLVES * vector,
      .pairs = 2 * THRUM_SECANT_PAIRS * vector,
      .work = round_up((uint64_t)state->work_count),
      .restricted = round_up((uint64_t)state->restricted_count),
      .inverse = inverse,
      .inverses = THRUM_INVERSES * inverse,
      .next = round_up((uint64_t)state->next_count),
      .tangent = round_up((uint64_t)state->tangent_count),
      .plastic = round_up((uint64_t)state->plastic_count),
      .shares = round_up((uint64_t)state->shares_count),
      .shapes = round_up((uint64_t)state->shapes_count),
      .levels = round_up((uint64_t)state->levels_count),
      .ahead = round_up((uint64_t)state->ahead_count),
  };
  return s;
}

static uint64_t header_doubles(void) {
  return round_up((sizeof(thrum_state) + sizeof(double) - 1) / sizeof(double));
}

uint64_t thrum_state_layout_scratch(const thrum_state *state) {
  const sizes s = sizes_of(state);
  uint64_t doubles = 0;
#define X(name, size) doubles += s.size;
  THRUM_STATE_SCRATCH(X)
#undef X
  return doubles * sizeof(double);
}

static uint64_t fixed_bytes(const thrum_state *state) {
  const sizes s = sizes_of(state);
  uint64_t doubles = 0;
#define X(name, size) doubles += s.size;
  THRUM_STATE_FIXED(X)
#undef X
  return doubles * sizeof(double);
}

uint64_t thrum_state_layout_bytes(const thrum_state *state) {
  const uint64_t behind =
      state->def.borrows_scratch ? (uint64_t)THRUM_ALIGNMENT : thrum_state_layout_scratch(state);
  return (uint64_t)thrum_state_kept_bytes(state) + behind + fixed_bytes(state);
}

/* The pointer to lent scratch is not one of the bytes that persist, so that snapshots and states of
 * equal histories are equal. */
void *thrum_state_lent(const thrum_state *state) {
  void *scratch;
  memcpy(&scratch, (const unsigned char *)state + thrum_state_kept_bytes(state), sizeof scratch);
  return scratch;
}

void thrum_state_set_lent(thrum_state *state, void *scratch) {
  memcpy((unsigned char *)state + thrum_state_kept_bytes(state), &scratch, sizeof scratch);
}

size_t thrum_state_kept_bytes(const thrum_state *state) {
  if (!state)
    return 0;
  const sizes s = sizes_of(state);
  uint64_t doubles = header_doubles();
#define X(name, size) doubles += s.size;
  THRUM_STATE_ARRAYS(X)
#undef X
  return (size_t)(doubles * sizeof(double));
}

void thrum_state_view_fill(thrum_state *state, thrum_state_view *view) {
  const sizes s = sizes_of(state);

  // the arrays follow the header in the order of their lists
  double *at = (double *)(void *)state + header_doubles();
#define X(name, size)                                                                              \
  view->name = at;                                                                                 \
  at += s.size;
  THRUM_STATE_ARRAYS(X)
#undef X
  view->kept_end = at;

  // scratch is behind them, or where it has been lent; NULL while it has not
  if (state->def.borrows_scratch)
    at = thrum_state_lent(state);
#define X(name, size)                                                                              \
  view->name = at;                                                                                 \
  at = at ? at + s.size : NULL;
  THRUM_STATE_SCRATCH(X)
#undef X

  // what follows from the model is last
  at = (double *)(void *)((unsigned char *)state + state->bytes - fixed_bytes(state));
#define X(name, size)                                                                              \
  view->name = at;                                                                                 \
  at += s.size;
  THRUM_STATE_FIXED(X)
#undef X

  // the inverses are a ring, and a newer one takes the place of the oldest
  for (int j = 0; j < THRUM_INVERSES; j++) {
    const int place = (state->inverse_place + THRUM_INVERSES - j) % THRUM_INVERSES;
    view->inverse[j] = view->inverses + (size_t)place * s.inverse;
  }

  view->stride = (int64_t)s.vector;
  view->kernel = thrum_kernel_get(state->def.kernel);
  view->restricted_from = NULL;
  view->restricted_stride = 0;
  view->power_sampled = false;
}

thrum_state_view thrum_state_view_of(thrum_state *state) {
  thrum_state_view view;
  thrum_state_view_fill(state, &view);
  return view;
}

/* Doubles of each kind of array that `own` of a borrowed workspace holds. */
#define BORROWED_vector(stride, square) (stride)
#define BORROWED_pairs(stride, square) (2 * THRUM_SECANT_PAIRS * (stride))
#define BORROWED_work(stride, square) 0
#define BORROWED_restricted(stride, square) 0
#define BORROWED_next(stride, square) (square)
#define BORROWED_tangent(stride, square) (square)

int64_t thrum_borrowed_own(int64_t rank) {
  const int64_t stride = (int64_t)round_up((uint64_t)rank);
  const int64_t square = (int64_t)round_up((uint64_t)(rank * rank));
  int64_t count = 0;
#define X(name, size) count += BORROWED_##size(stride, square);
  THRUM_STATE_SCRATCH(X)
#undef X
  return count;
}

void thrum_state_view_borrow(thrum_state_view *view, int64_t rank,
                             const thrum_borrowed_workspace *borrowed) {
  const int64_t stride = view->stride, square = (int64_t)round_up((uint64_t)(rank * rank));
  view->work = borrowed->work;
  view->restricted = borrowed->restricted;

  // the others in the order of their list
  double *at = borrowed->own;
#define X(name, size)                                                                              \
  if (BORROWED_##size(stride, square) > 0) {                                                       \
    view->name = at;                                                                               \
    at += BORROWED_##size(stride, square);                                                         \
  }
  THRUM_STATE_SCRATCH(X)
#undef X
}
