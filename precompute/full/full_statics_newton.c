/* Newton on the energy of the full-order body under a load, step by step (full_statics.c says by
 * what rule): what both searches, the plain one and the one that watches its stability, are made
 * of. SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/full/full_statics.h"

#define STEPS_MAX 400
#define NEWTON_MAX 300
#define FIRST_STEP 0.25
#define SHORTEST 1e-5
#define SHIFTS 8
#define TURNING_MAX 25

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

/* Levels of actuators grow with the load. */
void full_statics_act(thrum_full *full, double factor) {
  struct thrum_fem_acting *acting = full->body.acting;
  for (int64_t k = 0; acting && k < acting->count; k++)
    acting->levels[k] = factor * full->levels[k];
}

/* Residual at u under factor times the load; held components as the factor has them. */
void full_statics_evaluate(full_search *s, double factor) {
  thrum_full *full = s->full;
  const thrum_fem *fem = &full->body.fem;
  place_held(s, factor);
  full_statics_act(full, factor);
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

/* iterations with loads that turn; a step that needs more is too long */

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
