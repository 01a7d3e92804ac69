/* The stages of a step for a group of states (batch.c). Each array of a group has an entry
 * of every state, then the next entry.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/batch/batch_group.h"

#include <string.h>

#include "core/schemes/newmark.h"
#include "core/schemes/position_split.h"
#include "core/solve/implicit_solve.h"
#include "runtime/comparison/fox_goodwin.h"

/* Entries first..last-1 of the vector of one state into the group's array. */
static void put(const thrum_batch_group *g, int64_t lane, int64_t first, int64_t last,
                const double *from, double *to) {
  for (int64_t i = first; i < last; i++)
    to[i * g->kernel->lanes + lane] = from[i];
}

/* The same out of the group's array. */
static void take(const thrum_batch_group *g, int64_t lane, int64_t first, int64_t last,
                 const double *from, double *to) {
  for (int64_t i = first; i < last; i++)
    to[i] = from[i * g->kernel->lanes + lane];
}

void thrum_batch_monitor(thrum_batch_group *g) {
  const int64_t lanes = g->kernel->lanes, rank = g->model->rank;
  int64_t needed = 0;
  for (int64_t m = 0; m < g->count; m++)
    needed += g->members[m].run.samples ? 1 : 0;

  // one pass for all costs as much as for a quarter of them one by one
  const bool together = g->split > 0 && 4 * needed > lanes;
  // the directions and products are where forces and restricted polynomials will be
  double *directions = g->force, *products = g->restricted;
  if (together) {
    memset(g->q, 0, (size_t)(rank * lanes) * sizeof *g->q);
    memset(directions, 0, (size_t)(rank * lanes) * sizeof *directions);
    for (int64_t m = 0; m < g->count; m++) {
      const thrum_step_run *run = &g->members[m].run;
      if (!run->samples)
        continue;
      put(g, m, 0, rank, run->view.q, g->q);
      put(g, m, 0, g->split, run->view.direction, directions);
    }
    g->kernel->tangent_vector_part(g->model, g->split, g->q, directions, products, g->work);
  }

  // each monitor goes on from its product
  for (int64_t m = 0; m < g->count; m++) {
    thrum_step_run *run = &g->members[m].run;
    if (together && run->samples)
      take(g, m, 0, g->split, products, run->view.product);
    thrum_step_sample(g->model, run, together);
  }
}

/* Drift of all members in the position form. */
static void drift(thrum_batch_group *g) {
  memset(g->q, 0, (size_t)(g->model->rank * g->kernel->lanes) * sizeof *g->q);
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    thrum_step_run *run = &one->run;
    one->solver = thrum_position_drift(g->model, &run->next, &run->view, &run->report);
    one->status = THRUM_OK;
    one->solving = one->solver.n > 0;
    put(g, m, 0, g->split, run->view.middle, g->q);
  }
}

/* Kick of all members in the position form whose solve has found an increment. */
static void kick_position(thrum_batch_group *g) {
  // what the passes read of members that have none is zero
  const int64_t rank = g->model->rank;
  memset(g->q, 0, (size_t)(rank * g->kernel->lanes) * sizeof *g->q);
  for (int64_t m = 0; m < g->count; m++)
    if (g->members[m].status == THRUM_OK)
      put(g, m, 0, rank, g->members[m].run.view.middle, g->q);
  g->kernel->force_part(g->model, g->split, g->q, g->force, g->value, g->work);

  // each member takes its own column
  for (int64_t m = 0; m < g->count; m++) {
    thrum_step_run *run = &g->members[m].run;
    if (g->members[m].status != THRUM_OK)
      continue;
    take(g, m, 0, g->split, g->force, run->view.force);
    run->report.potential = g->value[m];
    thrum_position_kick(&g->members[m].solver);
  }
}

/* Kick and drift of all members in the thesis split. */
static void kick_thesis(thrum_batch_group *g) {
  const int64_t lanes = g->kernel->lanes, rank = g->model->rank;
  memset(g->q, 0, (size_t)(rank * lanes) * sizeof *g->q);
  for (int64_t m = 0; m < g->count; m++)
    put(g, m, 0, rank, g->members[m].run.view.q, g->q);
  g->kernel->force_part(g->model, g->split, g->q, g->force, g->value, g->work);

  // q then holds the explicit modes at their midpoint
  memset(g->q, 0, (size_t)(rank * lanes) * sizeof *g->q);
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    thrum_step_run *run = &one->run;
    take(g, m, 0, g->split, g->force, run->view.force);
    one->solver = thrum_imexv_solver(g->model, &run->next, &run->view, &run->report);
    one->status = thrum_imexv_drift(&one->solver, g->value[m]);
    one->solving = one->status == THRUM_OK && one->solver.n > 0;
    put(g, m, 0, g->split, run->view.middle, g->q);
  }
}

/* Marks the member's restricted polynomial as not fetched: another member's may be there. */
static void unfetch(const thrum_batch_group *g, int64_t lane) {
  g->members[lane].run.view.restricted_from = g->restricted + lane;
  g->members[lane].run.view.restricted_stride = g->kernel->lanes;
}

/* Ends the solve of one member, where a pass for the group is no longer worth it. */
static void go_on_alone(const thrum_batch_group *g, int64_t lane, thrum_quasi_next next) {
  thrum_batch_member *one = &g->members[lane];
  const thrum_solver *s = &one->solver;
  unfetch(g, lane);

  // from here on the solve goes on alone, as in thrum_solve_increment
  while (next == THRUM_QUASI_EVALUATE) {
    thrum_quasi_evaluate(s, &one->quasi);
    next = thrum_quasi_take(s, &one->quasi);
  }
  const bool solved = next == THRUM_QUASI_DONE || thrum_solve_newton(s);
  one->status = thrum_imexv_finish(s, solved);
  one->solving = false;
}

/* True when the next evaluation needs the stiffness too. */
static bool needs_stiffness(const thrum_batch_member *one) {
  return one->solving && one->quasi.ahead && one->quasi.done == 0;
}

/* Evaluates the stiffness of all members that need it, where that is worth a pass. */
static void stiffen(thrum_batch_group *g) {
  const int64_t lanes = g->kernel->lanes, n = g->model->rank - g->split;
  int64_t needed = 0;
  for (int64_t m = 0; m < g->count; m++)
    needed += needs_stiffness(&g->members[m]) ? 1 : 0;
  if (4 * needed <= lanes)
    return;

  // T of the implicit modes, into the Jacobians to come
  g->kernel->restricted_hessian(g->model, g->split, g->restricted, g->q + g->split * lanes,
                                g->hessian, g->work);
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!needs_stiffness(one))
      continue;
    take(g, m, 0, n * n, g->hessian, one->run.view.jacobian_next);
    thrum_problem_weigh(&one->solver, one->run.view.jacobian_next);
    one->quasi.assembled = true;
  }
}

/* One evaluation of quasi-Newton for all members that still iterate; returns how many are left. */
static int64_t iterate(thrum_batch_group *g) {
  const int64_t lanes = g->kernel->lanes, rank = g->model->rank;
  int64_t left = 0;

  // R of all, and the stiffness where it is needed
  for (int64_t m = 0; m < g->count; m++)
    if (g->members[m].solving)
      put(g, m, g->split, rank, g->members[m].run.view.middle, g->q);
  g->kernel->restricted_gradient(g->model, g->split, g->restricted, g->q + g->split * lanes,
                                 g->force + g->split * lanes, g->value, g->work);
  stiffen(g);

  // each solve takes its own
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!one->solving)
      continue;
    const thrum_solver *s = &one->solver;
    take(g, m, g->split, rank, g->force, one->run.view.force);
    unfetch(g, m);
    const thrum_quasi_next next = thrum_quasi_take(s, &one->quasi);
    if (next == THRUM_QUASI_EVALUATE)
      left++;
    else
      go_on_alone(g, m, next);
  }
  return left;
}

/* Prefetches what a solve begins with: it arrives while the first pass runs. */
static void prefetch(const thrum_batch_group *g) {
  const int64_t n = g->model->rank - g->split;
  for (int64_t m = 0; m < g->count; m++) {
    const thrum_state_view *view = &g->members[m].run.view;
    g->kernel->ask_for(view->past_q, (size_t)(view->force_now - view->past_q) * sizeof(double));
    g->kernel->ask_for(view->inverse[0], (size_t)(n * n) * sizeof(double));
  }
}

/* --- steps without explicit modes ------------------------------------------------------------- */

/* Begins the step of one member; what is not solved here is done. */
static void begin_whole(const thrum_batch_group *g, thrum_batch_member *one) {
  thrum_step_run *run = &one->run;
  one->solving = true;

  // the scheme states its equation
  switch ((thrum_scheme)g->scheme) {
  case THRUM_SCHEME_ENERGY:
    one->solving = thrum_energy_begin(g->model, &run->next, &run->view, &run->report, &one->solver,
                                      &one->from);
    break;
  case THRUM_SCHEME_NEWMARK:
    one->solver = thrum_newmark_begin(g->model, &run->next, &run->view, &run->report);
    break;
  case THRUM_SCHEME_FOX_GOODWIN:
    one->solver = thrum_fox_goodwin_begin(g->model, &run->next, &run->view, &run->report);
    break;
  default:
    one->solver = thrum_imexv_solver(g->model, &run->next, &run->view, &run->report);
    break;
  }

  // what needs no solve is a step of its own
  if (one->solving)
    thrum_quasi_begin(&one->solver, &one->quasi);
  else
    one->status = thrum_step_attempt(g->model, run);
}

static thrum_quasi_next take_whole(const thrum_batch_group *g, thrum_batch_member *one) {
  return g->scheme == THRUM_SCHEME_ENERGY ? thrum_energy_take(&one->solver, &one->from, &one->quasi)
                                          : thrum_quasi_take(&one->solver, &one->quasi);
}

/* Ends the solve and the step of one member, as alone from here on. */
static void finish_whole(const thrum_batch_group *g, thrum_batch_member *one,
                         thrum_quasi_next next) {
  const thrum_solver *s = &one->solver;
  while (next == THRUM_QUASI_EVALUATE) {
    thrum_quasi_evaluate(s, &one->quasi);
    next = take_whole(g, one);
  }
  one->solving = false;
  const bool solved = next == THRUM_QUASI_DONE;
  if (g->scheme == THRUM_SCHEME_ENERGY)
    one->status = thrum_energy_finish(s, &one->from, solved);
  else if (g->scheme == THRUM_SCHEME_NEWMARK)
    one->status = thrum_newmark_finish(s, solved || thrum_solve_newton(s));
  else if (g->scheme == THRUM_SCHEME_FOX_GOODWIN)
    one->status = thrum_fox_goodwin_finish(s, solved || thrum_solve_newton(s));
  else
    one->status = thrum_imexv_finish(s, solved || thrum_solve_newton(s));
}

/* R at the middle of one member out of the group's arrays. */
static void accept(const thrum_batch_group *g, int64_t lane) {
  const thrum_solver *s = &g->members[lane].solver;
  take(g, lane, 0, g->model->rank, g->force, s->evaluated);
  if (s->accept)
    s->accept(s, g->value[lane]);
}

/* One pass for the members that need the stiffness, or each alone. Where it is by pairs, R comes
 * with the same bits only so. */
static void stiffen_whole(thrum_batch_group *g, int64_t needed) {
  const int64_t rank = g->model->rank;

  // for a few members a pass over all lanes costs more than it saves
  const bool together = thrum_pairs_count(rank) > 0 && 4 * needed > g->kernel->lanes;
  if (together)
    g->kernel->tangent_pairs(g->model, g->q, g->force, g->value, g->hessian, g->work);

  // each takes its column, or evaluates alone
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!needs_stiffness(one))
      continue;
    if (!together) {
      thrum_quasi_evaluate(&one->solver, &one->quasi);
      continue;
    }
    double *matrix = one->run.view.jacobian_next;
    accept(g, m);
    take(g, m, 0, rank * rank, g->hessian, matrix);
    one->solver.weigh(&one->solver, matrix);
    one->quasi.assembled = true;
  }
}

/* One evaluation of quasi-Newton for all members that still iterate; returns how many are left. */
static int64_t iterate_whole(thrum_batch_group *g) {
  int64_t stiff = 0, plain = 0, left = 0;

  // all points of evaluation go into the lanes of one pass
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!one->solving)
      continue;
    put(g, m, 0, g->model->rank, one->run.view.middle, g->q);
    if (needs_stiffness(one))
      stiff++;
    else
      plain++;
  }

  // what needs the stiffness has R from its pass
  if (stiff > 0)
    stiffen_whole(g, stiff);
  if (plain > 0)
    g->kernel->force(g->model, g->q, g->force, g->value, g->work);

  // each member takes its R, and goes on or ends
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!one->solving)
      continue;
    if (!needs_stiffness(one)) {
      accept(g, m);
      one->quasi.assembled = false;
    }
    const thrum_quasi_next next = take_whole(g, one);
    if (next == THRUM_QUASI_EVALUATE)
      left++;
    else
      finish_whole(g, one, next);
  }
  return left;
}

static void attempt_whole(thrum_batch_group *g) {
  memset(g->q, 0, (size_t)(g->model->rank * g->kernel->lanes) * sizeof *g->q);
  int64_t left = 0;
  for (int64_t m = 0; m < g->count; m++) {
    begin_whole(g, &g->members[m]);
    left += g->members[m].solving ? 1 : 0;
  }

  // a pass costs the same for one state as for all, so the last ones go on alone
  while (4 * left > g->kernel->lanes)
    left = iterate_whole(g);
  for (int64_t m = 0; m < g->count; m++)
    if (g->members[m].solving)
      finish_whole(g, &g->members[m], THRUM_QUASI_EVALUATE);
}

/* --- all steps -------------------------------------------------------------------------------- */

void thrum_batch_attempt(thrum_batch_group *g) {
  prefetch(g);
  if (g->split == 0) {
    attempt_whole(g);
    return;
  }
  if (g->scheme == THRUM_SCHEME_POSITION)
    drift(g);
  else
    kick_thesis(g);

  // V restricted to the implicit modes, at the midpoint of the explicit ones
  int64_t left = 0;
  for (int64_t m = 0; m < g->count; m++)
    left += g->members[m].solving ? 1 : 0;
  if (left > 0)
    g->kernel->restrict_to(g->model, g->split, g->q, g->restricted, g->work);

  // first guesses
  for (int64_t m = 0; m < g->count; m++) {
    thrum_batch_member *one = &g->members[m];
    if (!one->solving)
      continue;
    unfetch(g, m);
    thrum_quasi_begin(&one->solver, &one->quasi);
  }

  // a pass costs the same for one state as for all, so the last ones go on alone
  while (4 * left > g->kernel->lanes)
    left = iterate(g);
  for (int64_t m = 0; m < g->count; m++) {
    if (g->members[m].solving)
      go_on_alone(g, m, THRUM_QUASI_EVALUATE);
    g->members[m].run.view.restricted_from = NULL;
  }
  if (g->scheme == THRUM_SCHEME_POSITION)
    kick_position(g);
}
