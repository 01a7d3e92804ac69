/* The target energy (design 7, 8): the energy that the exact balance demands, and the scaling of
 * the momentum that leads to it.
 *
 * The step of design 7 changes 1/2 |p|^2 + V by the work of the load less the dissipation, up to
 * the tolerance of its solve and rounding. Both are small, but add up over millions of steps. So
 * the sum of work and dissipation is kept as a target, and every COMPARE_STEPS steps the momentum
 * is scaled by the few ulps that lead to it: errors do not accumulate. The same scaling removes the
 * drift of imexv when the energy integrator takes over, over as many steps as it needs, and the
 * slow drift of imexv itself (design 4).
 *
 *   s = sqrt(1 + e/K),  p' = s p,  K = 1/2 |p|^2,  e the energy error
 *
 * A new target is set when so much energy has gone in and out that its own rounding would count.
 * Cost: 2 r operations a step, and an evaluation of V where the solve does not know it.
 * Source of the projection: Hairer, Lubich & Wanner 2006, Geometric Numerical Integration, IV.4,
 * doi:10.1007/3-540-30666-8.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/energy_correction.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/lane_sums.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/staggered_momentum.h"

#define COMPARE_STEPS 8        /* between two comparisons; one while an error is outstanding */
#define ERROR_ROUNDING 0x1p-50 /* of the energy: an error this small is none */
#define TURNOVER 1000.0        /* times the energy in and out after which a new target is set */
#define STRETCH_MOST 0.01      /* largest change of a momentum in one step, a share of it */
#define STRETCH_OWED 0.4       /* of it: an error that needs more is outstanding */

/* s - 1 of a momentum with the energy `kinetic` that gains `energy_error`; within STRETCH_MOST. */
static double stretch(double energy_error, double kinetic) {
  const double share = energy_error / kinetic;
  if (!(share > -STRETCH_MOST))
    return -STRETCH_MOST;
  return share < STRETCH_MOST ? share / (1.0 + sqrt(1.0 + share)) : STRETCH_MOST;
}

static double kinetic_of(const double *p, int32_t n) {
  return 0.5 * thrum_sum_of(n, p, p, NULL);
}

void thrum_energy_correction_open(thrum_state *state, double energy) {
  const thrum_energy_target target = {
      .energy = energy, .status = THRUM_ENERGY_CORRECTION_PENDING, .begin = state->report.steps};
  state->target = target;
}

void thrum_energy_correction_close(thrum_state *state) {
  const thrum_energy_target none = {.status = THRUM_ENERGY_CORRECTION_CLOSED};
  state->target = none;
}

/* Adds with the rounding of the sum carried along (Neumaier). */
static void add(thrum_energy_target *target, double amount) {
  const double sum = target->energy + amount;
  target->carry += fabs(target->energy) >= fabs(amount) ? (target->energy - sum) + amount
                                                        : (amount - sum) + target->energy;
  target->energy = sum;
}

void thrum_energy_correction_take(thrum_state *state, double amount) {
  if (state->target.status == THRUM_ENERGY_CORRECTION_CLOSED)
    return;
  add(&state->target, -amount);
  state->target.moved += fabs(amount);
}

/* Adds work and dissipation of the step to the target. */
static void enter_step(thrum_state *state, const thrum_state_view *view,
                       const thrum_solve_report *report) {
  const double work = thrum_sum_less(state->rank, view->q_next, view->q, view->load);
  add(&state->target, work - report->dissipation);
  state->target.moved += fabs(work) + fabs(report->dissipation);
}

/* Compares the energy at the end of the step with the target, and scales view->p_next. */
static void compare(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                    const thrum_solve_report *report) {
  thrum_energy_target *target = &state->target;
  const double kinetic = kinetic_of(view->p_next, state->rank);
  const double potential =
      report->potential_known
          ? report->potential
          : thrum_strain_energy_by(view->kernel, model, view->q_next, view->work);
  const double energy = kinetic + potential;
  const double energy_error = target->energy - energy + target->carry;
  if (!isfinite(energy) || !isfinite(energy_error)) {
    thrum_energy_correction_close(state);
    return;
  }

  // without a target, or with one whose rounding counts, this energy is the next target
  if (target->status == THRUM_ENERGY_CORRECTION_CLOSED ||
      !(target->moved <= TURNOVER * fabs(energy))) {
    thrum_energy_correction_open(state, energy);
    target->begin++;
    target->status = THRUM_ENERGY_CORRECTION_BALANCED;
    return;
  }

  // rounding is not corrected by rounding
  target->status = THRUM_ENERGY_CORRECTION_BALANCED;
  if (fabs(energy_error) <= ERROR_ROUNDING * fabs(energy))
    return;

  // a stretch near its limit may not have been all of it: near standstill it takes several steps
  const double by = stretch(energy_error, kinetic);
  for (int32_t i = 0; i < state->rank; i++)
    view->p_next[i] += by * view->p_next[i];
  for (int32_t i = 0; report->carries && i < state->rank; i++)
    view->p_corrected_next[i] += by * view->p_corrected_next[i];
  target->status = fabs(by) < STRETCH_OWED * STRETCH_MOST ? THRUM_ENERGY_CORRECTION_BALANCED
                                                          : THRUM_ENERGY_CORRECTION_PENDING;
}

void thrum_energy_correction_after(const thrum_model *model, thrum_state *state,
                                   thrum_state_view *view, const thrum_solve_report *report) {
  if (state->scheme != THRUM_SCHEME_ENERGY)
    return;

  if (state->target.status != THRUM_ENERGY_CORRECTION_CLOSED)
    enter_step(state, view, report);

  // on target, a comparison now and then is enough
  const int64_t since = state->report.steps + 1 - state->target.begin;
  if (state->target.status != THRUM_ENERGY_CORRECTION_BALANCED || since % COMPARE_STEPS == 0)
    compare(model, state, view, report);
}

thrum_status thrum_energy_correction_apply(const thrum_model *model, thrum_state *state,
                                           thrum_state_view *view, double least,
                                           double *energy_error) {
  THRUM_TRY(thrum_staggered_synchronise(model, state, view, NULL));
  const size_t vector = (size_t)state->rank * sizeof *view->p_start;
  const double kinetic = kinetic_of(view->p_next, state->rank);
  if (!(kinetic >= least))
    return THRUM_OK;

  // the synchronised momentum is scaled, and then stored half a step back again
  const double by = stretch(*energy_error, kinetic);
  memcpy(view->p_start, view->p_next, vector);
  for (int32_t i = 0; i < state->rank; i++)
    view->p_start[i] += by * view->p_start[i];
  THRUM_TRY(
      thrum_staggered_unsynchronise(model, state, view, view->q, view->load_before, view->p_start));
  if (!thrum_all_finite(view->p_start, state->rank))
    return THRUM_NOT_FINITE;

  view->p = view->p_start;
  *energy_error = 0.0;
  return THRUM_OK;
}
