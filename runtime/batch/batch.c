/* Steps of many states of one model together (thrum/batch.h).
 *
 * States that imexv is about to step in its position form, or in its thesis split, with the same
 * explicit modes, form a group. They go through the stages of that step together: the sample of the
 * stability number, force, kick, restriction, and the evaluations of quasi-Newton, while enough of
 * them still iterate. Each
 * stage that reads coefficients is one pass of runtime/batch/batch_kernel.h over all of them;
 * all else is done state by state with the code of thrum_step. The last ones to converge, and a
 * state that needs full Newton or a fallback level, go on alone.
 * Cost: that of thrum_step with each coefficient loaded once for all states of a group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "thrum/batch.h"

#include <string.h>

#include "core/base/alignment_check.h"
#include "core/step/state_private.h"
#include "runtime/batch/batch_group.h"
#include "runtime/condensed/following.h"
#include "runtime/condensed/manifold.h"
#include "thrum/polynomial.h"

#define SORTED_STATES 256    /* states that are sorted by their splits at a time */
#define PREFETCHED_VECTORS 9 /* of a state's block, before those of the past */

/* Cuts the workspace; returns its bytes. `memory` may be NULL. */
static size_t lay_out(const thrum_model *model, unsigned char *memory, thrum_batch_group *g) {
  const size_t number = THRUM_BATCH_LANES_MAX * sizeof(double), rank = (size_t)model->rank;
  const size_t restricted = (size_t)thrum_restricted_count(model->rank);

  // what a state that steps alone restricts its model to: slopes of a manifold, or points
  size_t alone = (size_t)thrum_restriction_room(model, model->rank);
  const size_t slopes = (size_t)thrum_manifold_count(model);
  alone = alone > slopes ? alone : slopes;
  const size_t sizes[] = {THRUM_BATCH_LANES_MAX * sizeof(thrum_batch_member),
                          rank * number,
                          rank * number,
                          number,
                          restricted * number,
                          rank * rank * number,
                          (size_t)thrum_batch_work(model->rank) * number,
                          (size_t)thrum_step_work_count(model) * sizeof(double),
                          alone * sizeof(double),
                          (size_t)thrum_borrowed_own(model->rank) * number};

  // one part after the other, each aligned
  enum { PARTS = sizeof sizes / sizeof sizes[0] };
  unsigned char *parts[PARTS];
  size_t size = 0;
  for (int n = 0; n < PARTS; n++) {
    parts[n] = memory ? memory + size : NULL;
    size += thrum_round_up(sizes[n]);
  }

  g->members = (thrum_batch_member *)(void *)parts[0];
  g->q = (double *)(void *)parts[1];
  g->force = (double *)(void *)parts[2];
  g->value = (double *)(void *)parts[3];
  g->restricted = (double *)(void *)parts[4];
  g->hessian = (double *)(void *)parts[5];
  g->work = (double *)(void *)parts[6];
  g->one_work = (double *)(void *)parts[7];
  g->one_restricted = (double *)(void *)parts[8];
  for (int m = 0; memory && m < THRUM_BATCH_LANES_MAX; m++)
    g->members[m].own = (double *)(void *)parts[9] + m * thrum_borrowed_own(model->rank);
  return size;
}

/* True when the step of this state can be made in a group. */
static bool fits(const thrum_model *model, const thrum_step_run *run) {
  const thrum_state *next = &run->next;
  return thrum_is_packed(model) && thrum_batch_takes(next) && !thrum_tangent_damped(next) &&
         thrum_batch_kernel_of(run->view.kernel->id) != NULL;
}

/* How the steps of a call ended. */
typedef struct outcome {
  thrum_status *statuses; /* may be NULL */
  thrum_error *error;
  thrum_status worst;
  int64_t first_failed;
} outcome;

static void note(outcome *o, int64_t index, thrum_status status, const thrum_error *why) {
  if (o->statuses)
    o->statuses[index] = status;
  if (status < 0 && (o->worst >= 0 || index < o->first_failed)) {
    o->worst = status;
    o->first_failed = index;
    thrum_error_set(o->error, status, "state %lld: %s", (long long)index, why->message);
  } else if (status > 0 && (o->worst == THRUM_OK || (o->worst > 0 && status < o->worst))) {
    o->worst = status;
  }
}

static void end(const thrum_model *model, thrum_batch_member *one, outcome *o) {
  thrum_error why = {.status = THRUM_OK};
  note(o, one->index, thrum_step_end(model, &one->run, one->status, &why), &why);
}

/* Moves a member to another place, and the workspace of that place to where it was. */
static void move(thrum_batch_member *from, thrum_batch_member *to) {
  double *unused = to->own;
  *to = *from;
  from->own = unused;
}

/* Steps those members alone whose stability monitor has chosen another kind of step, and takes them
 * out of the group. */
static void part(thrum_batch_group *g, outcome *o) {
  for (int64_t m = g->count - 1; m >= 0; m--) {
    thrum_batch_member *one = &g->members[m], *last = &g->members[g->count - 1];
    if (fits(g->model, &one->run) && one->run.next.split == g->split &&
        one->run.next.scheme == g->scheme)
      continue;
    one->status = thrum_step_attempt(g->model, &one->run);
    end(g->model, one, o);
    move(last, one);
    g->count--;
  }
}

/* Steps all members, together where that is worth it, and empties the group. */
static void advance(thrum_batch_group *g, outcome *o) {
  if (g->count > 0) {
    thrum_batch_monitor(g);
    part(g, o);
  }

  // a pass for less than half of the lanes costs more than the steps one by one
  if (g->count > 0 && 2 * g->count >= g->kernel->lanes) {
    thrum_batch_attempt(g);
  } else {
    for (int64_t m = 0; m < g->count; m++)
      g->members[m].status = thrum_step_attempt(g->model, &g->members[m].run);
  }

  for (int64_t m = 0; m < g->count; m++)
    end(g->model, &g->members[m], o);
  g->count = 0;
}

/* True when this state has begun its step already. */
static bool is_member(const thrum_batch_group *g, const thrum_state *state) {
  for (int64_t m = 0; m < g->count; m++)
    if (g->members[m].run.state == state)
      return true;
  return false;
}

/* Begins the step of one state and puts it in the group, or steps it alone. */
static void add(thrum_batch_group *g, thrum_state *state, int64_t index, outcome *o) {
  thrum_error why = {.status = THRUM_OK};

  // listed twice, it steps twice
  if (is_member(g, state))
    advance(g, o);

  thrum_batch_member *one = &g->members[g->count];
  one->index = index;
  const thrum_borrowed_workspace borrowed = {g->one_work, g->one_restricted, one->own};

  // no pass takes cubature points of many states, nor what acts on each
  if (thrum_has_points(g->model) || g->model->actuator_kind) {
    const thrum_status alone = thrum_step_alone(g->model, state, &borrowed, &why);
    note(o, index, alone, &why);
    return;
  }
  const thrum_status status = thrum_step_begin(g->model, state, &borrowed, &one->run, &why);
  if (status < 0) {
    note(o, index, status, &why);
    return;
  }

  // a step of another kind is made alone
  if (!fits(g->model, &one->run)) {
    thrum_step_sample(g->model, &one->run, false);
    one->status = thrum_step_attempt(g->model, &one->run);
    end(g->model, one, o);
    return;
  }

  // one of another split lets the group go first, and starts the next
  const thrum_batch_kernel *kernel = thrum_batch_kernel_of(one->run.view.kernel->id);
  const thrum_state *next = &one->run.next;
  if (g->count > 0 &&
      (g->split != next->split || g->scheme != next->scheme || g->kernel != kernel)) {
    advance(g, o);
    move(one, g->members);
  }
  g->split = g->members[0].run.next.split;
  g->scheme = g->members[0].run.next.scheme;
  g->kernel = kernel;
  g->count++;
  if (g->count == kernel->lanes)
    advance(g, o);
}

/* A number of the scheme and the explicit modes. */
static int32_t kind_by(int32_t scheme, int32_t split) {
  return scheme * (THRUM_RANK_MAX + 1) + split;
}

/* The number by which a state finds its group; -1: it is probably stepped alone. The stability
 * monitor may still change that. */
static int32_t kind_of(const thrum_model *model, const thrum_state *state) {
  if (thrum_state_check(model, state, NULL) < 0 || !thrum_batch_takes(state))
    return -1;
  return kind_by(state->scheme, state->split);
}

/* Prefetches the part of a state that a step begins with. */
static void prefetch_state(const thrum_batch_group *g, const thrum_state *state) {
  if (!state)
    return;
  const size_t vectors = PREFETCHED_VECTORS * (size_t)g->model->rank * sizeof(double);
  g->kernel->ask_for((const double *)(const void *)state, sizeof *state + vectors);
}

/* Steps up to SORTED_STATES states, those of a split one after the other, beginning with the split
 * of the group that is open. */
static void add_sorted(thrum_batch_group *g, thrum_state *const *states, int64_t begin,
                       int64_t count, outcome *o) {
  int32_t kinds[SORTED_STATES];
  bool added[SORTED_STATES] = {false};
  for (int64_t n = 0; n < count; n++)
    kinds[n] = kind_of(g->model, states[begin + n]);

  // one round for each split that occurs
  int32_t kind = kind_by(g->scheme, g->split);
  for (int64_t first = 0; first < count;) {
    for (int64_t n = first; n < count; n++)
      if (!added[n] && kinds[n] == kind) {
        added[n] = true;
        if (g->kernel && n + g->kernel->lanes < count)
          prefetch_state(g, states[begin + n + g->kernel->lanes]);
        add(g, states[begin + n], begin + n, o);
      }
    while (first < count && added[first])
      first++;
    kind = first < count ? kinds[first] : kind;
  }
}

thrum_status thrum_batch_size(const thrum_model *model, size_t *size, thrum_error *error) {
  thrum_batch_group g;
  if (!model || !size || model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model or size is NULL, or the model has no rank in 1..%d",
                           THRUM_RANK_MAX);
  *size = lay_out(model, NULL, &g);
  return THRUM_OK;
}

thrum_status thrum_batch_step(const thrum_model *model, thrum_state *const *states, int64_t count,
                              thrum_status *statuses, void *workspace, size_t workspace_size,
                              thrum_error *error) {
  size_t size;
  THRUM_TRY(thrum_batch_size(model, &size, error));
  if (count < 0 || (count > 0 && !states) || !workspace)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "states or workspace is NULL, or count is negative");
  if ((uintptr_t)workspace % THRUM_ALIGNMENT != 0)
    return thrum_error_set(error, THRUM_MISALIGNED, "the workspace is not aligned to %u bytes",
                           THRUM_ALIGNMENT);
  if (workspace_size < size)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the workspace has %zu bytes, this model needs %zu", workspace_size,
                           size);

  // groups form and go as the states come; the last one goes at the end
  thrum_batch_group g;
  memset(&g, 0, sizeof g);
  lay_out(model, workspace, &g);
  g.model = model;
  outcome o = {statuses, error, THRUM_OK, 0};
  for (int64_t n = 0; n < count; n += SORTED_STATES)
    add_sorted(&g, states, n, count - n < SORTED_STATES ? count - n : SORTED_STATES, &o);
  advance(&g, &o);
  return o.worst;
}
