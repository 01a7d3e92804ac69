/* The block of contact between bodies: planning, laying out, reports (thrum/contact_pairs.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_pairs_private.h"

#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/def.h"
#include "core/base/finite.h"

#define PAIRS_MAGIC UINT64_C(0x7468726d70723031)
#define LINKS_MAX 1024

void thrum_contact_pairs_def_init(thrum_contact_pairs_def *def, size_t size) {
  const thrum_contact_pairs_def defaults = {.cookie = sizeof(thrum_contact_pairs_def),
                                            THRUM_PAIRS_FIELDS(THRUM_VALUE)};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

thrum_pairs_view thrum_pairs_view_of(const thrum_contact_pairs *pairs) {
  const int64_t member_max = pairs->member_max, vertex_max = pairs->vertex_max;
  const int64_t node_max = pairs->node_max, rank_max = pairs->rank_max;
  const int64_t touch_max = pairs->touch_max, link_max = pairs->link_max;
  unsigned char *at = (unsigned char *)(uintptr_t)pairs + thrum_round_up(sizeof *pairs);
  thrum_pairs_view view;
#define X(type, name, count)                                                                       \
  view.name = (type *)(void *)at;                                                                  \
  at += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_PAIRS_ARRAYS(X)
#undef X
  return view;
}

static size_t bytes_of(const thrum_contact_pairs *pairs) {
  const int64_t member_max = pairs->member_max, vertex_max = pairs->vertex_max;
  const int64_t node_max = pairs->node_max, rank_max = pairs->rank_max;
  const int64_t touch_max = pairs->touch_max, link_max = pairs->link_max;
  size_t size = thrum_round_up(sizeof *pairs);
#define X(type, name, count) size += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_PAIRS_ARRAYS(X)
#undef X
  return size;
}

static bool is_in(int64_t value, int64_t most) {
  return value >= 1 && value <= most;
}

static thrum_status check_def(const thrum_contact_pairs_def *def, thrum_error *error) {
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def of contact between bodies was not made by "
                           "thrum_default_contact_pairs_def");

  // counts beyond these would overflow the offsets of the arrays
  if (!is_in(def->member_max, INT64_C(1) << 20) || !is_in(def->vertex_max, INT64_C(1) << 31) ||
      !is_in(def->node_max, INT64_C(1) << 31) || !is_in(def->rank_max, THRUM_RANK_MAX) ||
      !is_in(def->touch_max, INT64_C(1) << 24) || !is_in(def->link_max + 1, LINKS_MAX + 1) ||
      def->sweeps_max < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "member_max must be 1 to 2^20, vertex_max and node_max 1 to 2^31, "
                           "rank_max 1 to %d, touch_max 1 to 2^24, link_max 0 to %d, sweeps_max at "
                           "least 1",
                           THRUM_RANK_MAX, LINKS_MAX);

  // written so that NaN is refused as well
  if (!(def->thickness >= 0.0 && def->thickness <= THRUM_CONTACT_STIFFNESS_MAX) ||
      !(def->friction >= 0.0 && def->friction <= THRUM_CONTACT_STIFFNESS_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thickness and friction between bodies must be 0 to 1e30");
  if (!(def->restitution >= 0.0 && def->restitution <= 1.0) ||
      !(def->tolerance > 0.0 && def->tolerance <= THRUM_TOLERANCE_MOST))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "restitution between bodies must be 0 to 1, the tolerance in (0, "
                           "1e-2]");
  return THRUM_OK;
}

/* The header that a definition leads to, with the sizes of what lies behind it. */
static thrum_contact_pairs header_of(const thrum_contact_pairs_def *def) {
  thrum_contact_pairs header = {.magic = PAIRS_MAGIC,
                                .member_max = def->member_max,
                                .vertex_max = def->vertex_max,
                                .node_max = def->node_max,
                                .rank_max = def->rank_max,
                                .touch_max = def->touch_max,
                                .link_max = def->link_max,
                                .thickness = def->thickness,
                                .friction = def->friction,
                                .restitution = def->restitution,
                                .tolerance = def->tolerance,
                                .sweeps_max = def->sweeps_max};

  // a snapshot keeps the header and the touches, no scratch
  header.bytes = bytes_of(&header);
  header.kept_bytes = thrum_round_up(sizeof header) +
                      thrum_round_up((size_t)def->touch_max * sizeof(thrum_pair_touching));
  return header;
}

thrum_status thrum_contact_pairs_size(const thrum_contact_pairs_def *def, size_t *size,
                                      thrum_error *error) {
  thrum_contact_pairs_def whole = thrum_default_contact_pairs_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(check_def(def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  *size = (size_t)header_of(def).bytes;
  return THRUM_OK;
}

thrum_status thrum_contact_pairs_init(void *memory, size_t memory_size,
                                      const thrum_contact_pairs_def *def,
                                      thrum_contact_pairs **pairs, thrum_error *error) {
  thrum_contact_pairs_def whole = thrum_default_contact_pairs_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  size_t size;
  THRUM_TRY(thrum_contact_pairs_size(def, &size, error));
  if (!memory || !pairs)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or pairs is NULL");
  THRUM_TRY(thrum_alignment_check("contact between bodies", memory, memory_size, size, error));

  // the rest is scratch, which each step fills before it reads it
  const thrum_contact_pairs header = header_of(def);
  memset(memory, 0, (size_t)header.kept_bytes);
  *pairs = memory;
  **pairs = header;

  // but for what later steps find again
  memset(thrum_pairs_view_of(*pairs).lists, 0, sizeof(thrum_pair_lists));
  return THRUM_OK;
}

int thrum_pair_compare(const thrum_pair_key *a, const thrum_pair_key *b) {
  if (a->bodies[0] != b->bodies[0])
    return a->bodies[0] < b->bodies[0] ? -1 : 1;
  if (a->bodies[1] != b->bodies[1])
    return a->bodies[1] < b->bodies[1] ? -1 : 1;
  if (a->kind != b->kind)
    return a->kind < b->kind ? -1 : 1;
  if (a->first != b->first)
    return a->first < b->first ? -1 : 1;
  return (a->second > b->second) - (a->second < b->second);
}

int64_t thrum_pairs_find_before(const thrum_pairs_run *run, const thrum_pair_key *key) {
  int64_t from = 0, to = run->history->before_count;
  while (from < to) {
    const int64_t middle = from + (to - from) / 2;
    if (thrum_pair_compare(&run->view.before[middle].key, key) < 0)
      from = middle + 1;
    else
      to = middle;
  }
  return from;
}

double thrum_pairs_thickness(const thrum_contact_pairs *pairs, const thrum_skin *a,
                             const thrum_skin *b) {
  return pairs->thickness > 0.0 ? pairs->thickness
                                : THRUM_PAIRS_THICKNESS * fmin(a->diagonal, b->diagonal);
}

void thrum_contact_pairs_reset(thrum_contact_pairs *pairs) {
  if (pairs)
    pairs->history = (thrum_pairs_history){0};
}

void thrum_contact_pairs_continue(thrum_contact_pairs *pairs, const thrum_contact_pairs *from) {
  if (!pairs || !from)
    return;

  // of the touches that the next step starts from, those that there is room for
  pairs->history = from->history;
  if (pairs->history.touch_count > pairs->touch_max) {
    pairs->history.dropped += pairs->history.touch_count - pairs->touch_max;
    pairs->history.touch_count = pairs->touch_max;
  }
  pairs->history.before_count = pairs->history.struck = 0;
  memcpy(thrum_pairs_view_of(pairs).touches, thrum_pairs_view_of(from).touches,
         (size_t)pairs->history.touch_count * sizeof(thrum_pair_touching));
}

thrum_contact_pairs_report thrum_pairs_report_of(const thrum_pairs_history *history) {
  return (thrum_contact_pairs_report){

      // counters of all steps
      .steps = history->steps,
      .redone = history->redone,
      .declined = history->declined,
      .dropped = history->dropped,
      .sweeps = history->sweeps,
      .impacts = history->impacts,

      // the last step, and energies since init
      .touching = history->touch_count,
      .struck = history->struck,
      .distance = history->distance,
      .depth = history->depth,
      .deepest = history->deepest,
      .deepest_share = history->deepest_share,
      .normal = history->normal,
      .stored = history->stored + history->owed,
      .lost = history->lost,
      .driven = history->driven,
  };
}

thrum_contact_pairs_report thrum_contact_pairs_report_get(const thrum_contact_pairs *pairs) {
  return pairs ? thrum_pairs_report_of(&pairs->history) : (thrum_contact_pairs_report){0};
}

thrum_status thrum_contact_pairs_touch_get(const thrum_contact_pairs *pairs, int64_t index,
                                           thrum_pair_touch *touch, thrum_error *error) {
  if (!pairs || !touch || index < 0 || index >= pairs->history.touch_count + pairs->history.struck)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no touch %lld of two bodies",
                           (long long)index);

  // forces are on the side that is named first, which is the second body's where its vertex touches
  const thrum_pairs_view view = thrum_pairs_view_of(pairs);
  const int64_t impact = index - pairs->history.touch_count;
  const thrum_pair_touching *found =
      impact < 0 ? view.touches + index : thrum_pairs_impact_at(pairs, &view, impact);
  const double sign = found->key.kind == THRUM_PAIR_REVERSE ? -1.0 : 1.0;
  *touch = (thrum_pair_touch){.distance = found->distance};
  for (int side = 0; side < 2; side++)
    touch->bodies[side] = found->key.bodies[side];

  // a touch has a force, an impact an impulse
  double *acts = impact < 0 ? touch->force : touch->impulse;
  for (int axis = 0; axis < 3; axis++) {
    touch->position[axis] = found->position[axis];
    touch->normal[axis] = sign * found->normal[axis];
    acts[axis] = sign * (found->force * found->normal[axis] + found->friction[axis]);
  }
  return THRUM_OK;
}

size_t thrum_contact_pairs_kept_bytes(const thrum_contact_pairs *pairs) {
  return pairs ? (size_t)pairs->kept_bytes : 0;
}

bool thrum_pairs_is_same_def(const thrum_contact_pairs *a, const thrum_contact_pairs *b) {
  // everything that init sets and no step changes
  return a->magic == b->magic && a->bytes == b->bytes && a->kept_bytes == b->kept_bytes &&
         a->member_max == b->member_max && a->vertex_max == b->vertex_max &&
         a->node_max == b->node_max && a->rank_max == b->rank_max && a->touch_max == b->touch_max &&
         a->link_max == b->link_max && a->thickness == b->thickness && a->friction == b->friction &&
         a->restitution == b->restitution && a->tolerance == b->tolerance &&
         a->sweeps_max == b->sweeps_max;
}

static bool is_count(int64_t count, int64_t most) {
  return count >= 0 && count <= most;
}

thrum_status thrum_contact_pairs_copy_check(const thrum_contact_pairs *pairs, const void *copy,
                                            thrum_error *error) {
  if (!pairs || !copy)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the pairs or the copy of them is NULL");
  thrum_contact_pairs header;
  memcpy(&header, copy, sizeof header);
  if (!thrum_pairs_is_same_def(&header, pairs))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the snapshot is of contact between bodies of another def");

  // what persists from step to step
  const double values[] = {
      header.history.stored,   header.history.lost,   header.history.flow,
      header.history.budget,   header.history.depth,  header.history.deepest,
      header.history.distance, header.history.normal, header.history.deepest_share,
      header.history.driven,   header.history.owed};
  bool right = is_count(header.history.touch_count, header.touch_max) &&
               is_count(header.history.before_count, header.touch_max) &&
               is_count(header.history.steps, THRUM_COUNT_MAX) &&
               is_count(header.history.redone, THRUM_COUNT_MAX) &&
               is_count(header.history.declined, THRUM_COUNT_MAX) &&
               is_count(header.history.dropped, THRUM_COUNT_MAX) &&
               is_count(header.history.sweeps, THRUM_COUNT_MAX) &&
               is_count(header.history.impacts, THRUM_COUNT_MAX) &&
               is_count(header.history.struck, header.touch_max - header.history.touch_count) &&
               header.filled == 0 && header.listed == 0 &&
               thrum_all_finite(values, sizeof values / sizeof values[0]);
  for (int64_t n = 0; right && n < header.touch_max; n++) {
    if (n >= header.history.touch_count && n < header.touch_max - header.history.struck)
      continue;
    thrum_pair_touching touch;
    memcpy(&touch,
           (const unsigned char *)copy + thrum_round_up(sizeof header) + (size_t)n * sizeof touch,
           sizeof touch);
    right = is_count(touch.towards, 1) && is_count(touch.key.kind, THRUM_PAIR_EDGES) &&
            touch.key.bodies[0] >= 0 &&
            touch.key.bodies[1] >= touch.key.bodies[0] + (touch.key.kind == THRUM_PAIR_REVERSE) &&
            thrum_all_finite(touch.normal, 3) && thrum_all_finite(touch.friction, 3) &&
            thrum_all_finite(touch.position, 3) && isfinite(touch.force) &&
            isfinite(touch.approach) && isfinite(touch.stored) && isfinite(touch.distance) &&
            isfinite(touch.thickness);
  }
  return right ? THRUM_OK
               : thrum_error_set(error, THRUM_BAD_VALUE,
                                 "the snapshot holds a number of contact between bodies that is "
                                 "out of its range");
}
