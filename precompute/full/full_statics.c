/* The equilibrium of the full-order body under a load (design 13): R(u) = factor f, and held
 * components at factor times where they are to go. The load grows in steps; each is Newton on the
 * total energy V - factor f u with a line search, its matrix shifted by a multiple of the stiffness
 * at rest where it is not positive definite, so that every direction leads downhill and what is
 * found is stable, but for saddles that nothing pushes the body off.
 *
 * A path that starts at a displaced body begins under the forces that hold it there: the load is
 * (1 - factor) R(start) + factor f. Loads that turn with their group have no energy: full steps of
 * Newton are then taken (full_follower_solve.c), and shorter load steps where those do not
 * converge.
 *
 * Cost: an assembly and a factorisation an iteration.
 * Source: Nocedal & Wright 2006, Numerical Optimization, doi:10.1007/978-0-387-40065-5, chapter 3.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/full/full_statics.h"

/* Where the path starts, and where that is displaced what holds it there. */
static thrum_status begin_at(full_search *s, thrum_error *error) {
  thrum_full *full = s->full;
  const thrum_fem *fem = &full->body.fem;
  const int64_t n = fem->free_count, all = 3 * fem->vertex_count;
  THRUM_TRY(thrum_reserve(&s->from, all + n, sizeof *s->from, "the start", error));
  double *from = s->from;
  full_place(full, full->u, 0, NULL, from);

  // turned groups count from here, at rest too
  bool displaced = false;
  for (int64_t c = 0; c < all; c++)
    displaced = displaced || from[c] != 0;
  if (!displaced)
    return THRUM_OK;

  double *hold = from + all;
  memset(full->r, 0, (size_t)n * sizeof *hold);
  full_subtract_forces(full, from, full->r);
  for (int64_t i = 0; i < n; i++)
    hold[i] = -full->r[i];
  s->hold = hold;
  return THRUM_OK;
}

/* Says how far the load came, and that the body lost its stability there, if it did. */
static thrum_status refuse(const full_search *s, thrum_error *error) {
  const thrum_full_equilibrium *made = s->found;
  if (made->instability == THRUM_INSTABILITY_NONE)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "full order: no equilibrium was found beyond %.6g of the load (%d "
                           "steps, %d iterations)",
                           s->factor, (int)made->load_steps, (int)made->iterations);
  return thrum_error_set(
      error, THRUM_NOT_CONVERGED,
      "full order: the body %s at %.6g of the load, and no equilibrium was found beyond %.6g of "
      "it (%d steps, %d iterations): take less of the load, or add a small one that leads it to a "
      "side",
      made->instability == THRUM_INSTABILITY_LIMIT ? "snaps through" : "buckles", made->critical,
      s->factor, (int)made->load_steps, (int)made->iterations);
}

thrum_status thrum_full_rest(thrum_full *full, const double *forces, const double *moves,
                             thrum_full_equilibrium *found, thrum_error *error) {
  const thrum_full_loading loading = {.forces = forces, .moves = moves};
  return thrum_full_rest_under(full, &loading, found, error);
}

thrum_status thrum_full_rest_under(thrum_full *full, const thrum_full_loading *loading,
                                   thrum_full_equilibrium *found, thrum_error *error) {
  const int64_t n = full->body.fem.free_count, all = 3 * full->body.fem.vertex_count;

  // a free body has no equilibrium, unless its motion is given
  if (full->model->rigid != NULL && loading->moves == NULL && loading->turn_count == 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "full order: nothing holds the body, so it has no equilibrium");

  // the state from which the search begins is kept for a failure
  double *memory = NULL;
  THRUM_TRY(thrum_reserve(&memory, 4 * n + all, sizeof *memory, "the equilibrium", error));
  thrum_full_equilibrium made = {.least = NAN,
                                 .least_start = NAN,
                                 .softest = NAN,
                                 .softest_factor = NAN,
                                 .critical = NAN,
                                 .critical_from = NAN,
                                 .critical_to = NAN,
                                 .critical_least = NAN,
                                 .lost_at = NAN};
  full_search s = {.full = full, .loading = loading, .found = &made};
  double *start = memory, *force = memory + 3 * n, *held = memory + 4 * n;
  s.before = start + n;
  s.kept = s.before + n;
  memcpy(start, full->u, (size_t)n * sizeof *start);
  memcpy(force, full->f, (size_t)n * sizeof *force);
  memcpy(held, full->held, (size_t)all * sizeof *held);

  // the load grows in steps, each of which Newton's method solves
  thrum_status status = begin_at(&s, error);
  if (status >= 0 && loading->follower_count > 0)
    status = full_follower_solver_make(full, loading, &s.solver, error);
  THRUM_THEN(status, thrum_full_set_force(full, loading->forces, error));
  if (status >= 0 &&
      !(loading->watch && loading->follower_count == 0 ? full_statics_watch(&s, error)
                                                       : full_statics_steps(&s, error)))
    status = s.failure < 0 ? s.failure : refuse(&s, error);
  if (status == THRUM_NOT_CONVERGED)
    *found = made;

  // the tangent is another one now
  full->linear.ready = false;
  full->fresh = true;

  // at the equilibrium the body is at rest; without one it is as it was
  full_statics_act(full, 1);
  if (status >= 0) {
    memset(full->v, 0, (size_t)n * sizeof *full->v);
    made.energy = s.energy - thrum_full_acting_energy(full);
    made.load_energy = loading->follower_count > 0 ? NAN : s.merit - made.energy;
    *found = made;
  } else {
    memcpy(full->u, start, (size_t)n * sizeof *start);
    memcpy(full->f, force, (size_t)n * sizeof *force);
    memcpy(full->held, held, (size_t)all * sizeof *held);
  }

  full_follower_solver_free(&s.solver);
  free(s.from);
  free(memory);
  return status;
}

/* One search from the displacement in full->u under the whole loading: its energy with that of the
 * load, or infinity where it ends nowhere. */
static double settle(full_search *s, thrum_error *error) {
  s->largest = 0;
  return full_statics_newton(s, 1, error) ? s->merit : INFINITY;
}

thrum_status thrum_full_lower(thrum_full *full, const thrum_full_loading *loading,
                              const double *kicks, int64_t kick_count, double *lower,
                              thrum_error *error) {
  const thrum_fem *fem = &full->body.fem;
  const int64_t n = fem->free_count, all = 3 * fem->vertex_count;
  double *memory = NULL;
  THRUM_TRY(thrum_reserve(&memory, n + all, sizeof *memory, "the equilibrium", error));
  thrum_full_equilibrium made = {0};
  full_search s = {.full = full, .loading = loading, .found = &made};
  double *start = memory, *held = memory + n, best = INFINITY;
  memcpy(start, full->u, (size_t)n * sizeof *start);
  memcpy(held, full->held, (size_t)all * sizeof *held);

  // turned groups are where they are to be, so that nothing moves them further
  const thrum_full_loading still = {.forces = loading->forces, .moves = held};
  s.loading = &still;

  // both ways along each kick
  for (int64_t k = 0; k < 2 * kick_count && s.failure >= 0; k++) {
    const double *kick = kicks + k / 2 * all, way = k % 2 ? -1 : 1;
    for (int64_t i = 0; i < n; i++)
      full->u[i] = start[i] + way * kick[fem->component[i]];
    best = fmin(best, settle(&s, error));
  }

  memcpy(full->u, start, (size_t)n * sizeof *start);
  memcpy(full->held, held, (size_t)all * sizeof *held);
  full->linear.ready = false;
  full->fresh = true;
  free(memory);
  if (s.failure < 0)
    return s.failure;
  *lower = best;
  return THRUM_OK;
}

thrum_status thrum_full_correct(thrum_full *full, const double *forces, int32_t most,
                                thrum_full_equilibrium *found, bool *ended, thrum_error *error) {
  const thrum_full_loading loading = {.forces = forces};
  thrum_full_equilibrium made = {0};
  full_search s = {.full = full, .loading = &loading, .most = most, .found = &made};
  THRUM_TRY(thrum_full_set_force(full, forces, error));
  const bool there = full_statics_newton(&s, 1, error);
  full->linear.ready = false;
  full->fresh = true;
  if (s.failure < 0)
    return s.failure;
  made.energy = s.energy;
  made.load_energy = s.merit - s.energy;
  *found = made;
  *ended = there;
  return THRUM_OK;
}
