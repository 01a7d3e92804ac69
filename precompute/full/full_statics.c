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

#define STEPS_MAX 400
#define NEWTON_MAX 300
#define FIRST_STEP 0.25
#define SHORTEST 1e-5
#define SHIFTS 8
#define TURNING_MAX 25 /* iterations with loads that turn; a step that needs more is too long */

/* Held components on their way: straight, and as rigid groups where those turn. */
static void place_held(const full_search *s, double factor) {
  thrum_full *full = s->full;
  const thrum_fem *fem = &full->body.fem;
  const double *moves = s->loading->moves;
  if (!moves && !s->hold && s->loading->turn_count == 0)
    return;

  for (int64_t c = 0; c < 3 * fem->vertex_count; c++) {
    const double start = s->hold ? (1 - factor) * s->from[c] : 0;
    full->held[c] = fem->dof[c] < 0 ? start + (moves ? factor * moves[c] : 0) : 0;
  }
  if (s->loading->turn_count > 0)
    full_turns_place(s->loading, fem->vertices, s->from, factor, full->held);
}

/* Residual at u under factor times the load; held components as the factor has them. */
void full_statics_evaluate(full_search *s, double factor) {
  thrum_full *full = s->full;
  const thrum_fem *fem = &full->body.fem;
  place_held(s, factor);
  for (int64_t i = 0; i < fem->free_count; i++)
    full->r[i] = factor * full->f[i];
  for (int64_t i = 0; s->hold && i < fem->free_count; i++)
    full->r[i] += (1 - factor) * s->hold[i];
  full_place(full, full->u, 0, NULL, full->place);

  // loads that turn are where the body is
  if (s->loading->follower_count > 0) {
    memset(full->place_to, 0, (size_t)(3 * fem->vertex_count) * sizeof(double));
    full_followers_add(&s->solver.followers, full->place, factor, full->place_to);
    for (int64_t i = 0; i < fem->free_count; i++)
      full->r[i] += full->place_to[fem->component[i]];
  }

  s->energy = full_subtract_forces(full, full->place, full->r);
  s->merit = s->energy - factor * full_dot(full, full->f, full->u);
  if (s->hold)
    s->merit -= (1 - factor) * full_dot(full, s->hold, full->u);
}

void full_statics_visit(const full_search *s, double least, bool jumped) {
  const thrum_full_point point = {s->factor, s->energy, least, jumped};
  if (s->loading->visit)
    s->loading->visit(s->loading->visit_context, &point);
}

/* Newton's correction into delta; the slope at which the energy falls along it, NaN on failure. */
double full_statics_descend(full_search *s, thrum_error *error) {
  thrum_full *full = s->full;
  thrum_status status = THRUM_SINGULAR;

  // the matrix is shifted until it is positive definite, so that delta leads downhill; where it
  // helps GMRES to Newton's own correction, by as little as can be
  const bool follows = s->loading->follower_count > 0;

  // tangents of other laws are made positive at each point first, and then need less
  const bool projects = full->def.law != THRUM_LAW_STVK && !follows;
  const double usual = follows ? 1e-7 : projects ? 0.01 : 0.05;
  const double least = s->shift > 0 ? s->shift : usual;
  const double growth = follows || s->shift > 0 ? 10 : 4;
  double shift = 0, taken = 0;
  for (int k = 0; status == THRUM_SINGULAR && k < (s->strict ? 1 : SHIFTS); k++) {
    full->positive = projects && k > 0;
    status = full_assemble(full, full->place, 1, 0, 0, error);
    const thrum_sparse *stiffness = &full->body.stiffness;
    for (int64_t e = 0; shift > 0 && e < stiffness->begin[stiffness->size]; e++)
      full->system.value[e] += shift * stiffness->value[e];

    THRUM_THEN(status, full_linear_prepare(&full->linear, error));
    THRUM_THEN(status, full_linear_solve(&full->linear, full->r, full->delta, error));

    // the equilibrium is stable where no shift was needed
    s->found->stable = shift == 0 && status >= 0;
    taken = shift;
    shift = shift > 0 ? growth * shift : least;
  }

  full->positive = false;
  s->found->iterations++;
  if (s->shift > 0 && taken > 0)
    s->shift = taken / growth;

  // a shorter step may mend any other failure
  if (status == THRUM_OUT_OF_MEMORY)
    s->failure = status;
  return status >= 0 ? full_dot(full, full->delta, full->r) : NAN;
}

/* Along delta by 1 and then shorter, until the energy falls enough, or the residual where rounding
 * hides that. */
bool full_statics_shorten(full_search *s, double factor, double slope, double *length) {
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  const double merit = s->merit, residual = full_dot(full, full->r, full->r);
  memcpy(full->trial, full->u, (size_t)n * sizeof *full->u);

  *length = 1;
  for (int k = 0; k < 40; k++, *length *= 0.5) {
    for (int64_t i = 0; i < n; i++)
      full->u[i] = full->trial[i] + *length * full->delta[i];
    full_statics_evaluate(s, factor);

    // Armijo's rule; where the energy is flat to rounding, the residual decides
    const bool fell = s->merit < merit - 1e-4 * *length * slope ||
                      (fabs(s->merit - merit) <= 1e-12 * fabs(merit) &&
                       full_dot(full, full->r, full->r) < 0.25 * residual);
    if (isfinite(s->merit) && fell)
      return true;
  }

  // no length helps: back to where it began
  memcpy(full->u, full->trial, (size_t)n * sizeof *full->u);
  full_statics_evaluate(s, factor);
  return false;
}

/* Full steps of Newton with loads that turn; sizes are in the energy norm at rest. */
static bool newton_turning(full_search *s, double factor, thrum_error *error) {
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  for (int k = 0; k < TURNING_MAX; k++) {
    full_statics_evaluate(s, factor);
    const double slope = full_statics_descend(s, error);
    if (isnan(slope) || (slope == 0 && full_dot(full, full->r, full->r) > 0))
      return false;
    const thrum_status solved = full_follower_solve(full, &s->solver, factor, error);
    if (solved == THRUM_OUT_OF_MEMORY)
      s->failure = solved;
    if (solved < 0)
      return false;

    thrum_sparse_product(&full->body.stiffness, full->delta, 1, full->product);
    const double size = sqrt(fmax(full_dot(full, full->delta, full->product), 0));
    if (!isfinite(size))
      return false;
    for (int64_t i = 0; i < n; i++)
      full->u[i] += full->delta[i];

    // an end that is not that of a positive definite tangent is no end of Newton's own method
    s->largest = fmax(s->largest, size);
    s->found->residual = s->largest > 0 ? size / s->largest : 0;
    if (size <= fmax(full->def.tolerance, 64 * DBL_EPSILON) * s->largest) {
      full_statics_evaluate(s, factor);
      return true;
    }
  }
  return false;
}

bool full_statics_newton(full_search *s, double factor, thrum_error *error) {
  thrum_full *full = s->full;
  if (s->loading->follower_count > 0)
    return newton_turning(s, factor, error);
  full_statics_evaluate(s, factor);
  for (int k = 0; k < (s->most > 0 ? s->most : NEWTON_MAX); k++) {
    const double slope = full_statics_descend(s, error);
    if (!(slope >= 0) || !isfinite(slope) || !isfinite(s->merit))
      return false;

    // delta^T K delta is the slope, so its root is the correction in the energy norm
    const double size = sqrt(slope);
    s->largest = fmax(s->largest, size);
    s->found->residual = s->largest > 0 ? size / s->largest : 0;
    if (size <= fmax(full->def.tolerance, 64 * DBL_EPSILON) * s->largest)
      return true;

    // full steps bring a slender body round its bends, where shorter ones go downhill for long
    if (s->strict) {
      for (int64_t i = 0; i < full->body.fem.free_count; i++)
        full->u[i] += full->delta[i];
      full_statics_evaluate(s, factor);
      continue;
    }

    // rounding may stop it first
    double length = 0;
    if (!full_statics_shorten(s, factor, slope, &length))
      return size <= 1e-7 * s->largest;
  }

  return false;
}

bool full_statics_steps(full_search *s, thrum_error *error) {
  thrum_full *full = s->full;
  const int64_t n = full->body.fem.free_count;
  const size_t vector = (size_t)n * sizeof(double);
  double step = FIRST_STEP, last = 0;

  // the start, where the watched branch has not shown it
  if (s->factor == 0 && s->found->load_steps == 0 && !isfinite(s->found->least_start)) {
    full_statics_evaluate(s, 0);
    full_statics_visit(s, NAN, false);
  }
  for (int k = 0; s->factor < 1; k++) {
    if (k == STEPS_MAX || step < SHORTEST)
      return false;

    const double factor = s->factor + step < 1 ? s->factor + step : 1;
    memcpy(s->kept, full->u, vector);

    // straight on from the step before
    for (int64_t i = 0; last > 0 && i < n; i++)
      full->u[i] += (factor - s->factor) / last * (s->kept[i] - s->before[i]);

    // a step that fails is tried again with a quarter of the load
    const int32_t iterations = s->found->iterations;
    if (!full_statics_newton(s, factor, error)) {
      memcpy(full->u, s->kept, vector);
      if (s->failure < 0)
        return false;
      s->found->cut_steps++;
      step *= 0.25;
      continue;
    }

    // a step that took few iterations lets the next one be longer
    memcpy(s->before, s->kept, vector);
    last = factor - s->factor;
    s->factor = factor;
    s->found->load_steps++;
    full_statics_visit(s, NAN, false);
    step *= s->found->iterations - iterations <= 8 ? 2 : 1;
  }

  return true;
}

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
    status = s.failure < 0 ? s.failure
                           : thrum_error_set(error, THRUM_NOT_CONVERGED,
                                             "full order: no equilibrium was found beyond %.6g of "
                                             "the load (%d steps, %d iterations)",
                                             s.factor, (int)made.load_steps, (int)made.iterations);

  // the tangent is another one now
  full->linear.ready = false;
  full->fresh = true;

  // at the equilibrium the body is at rest; without one it is as it was
  if (status >= 0) {
    memset(full->v, 0, (size_t)n * sizeof *full->v);
    made.energy = s.energy;
    made.load_energy = loading->follower_count > 0 ? NAN : s.merit - s.energy;
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
