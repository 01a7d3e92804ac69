/* The account of the energy (design 7, 8): what it is to be, and the momentum that makes it so.
 *
 * The step of design 7 changes 1/2 |p|^2 + V by the work of the load less the dissipation, up to
 * what its solve leaves and rounding. Both are small, but add up over millions of steps. So the sum
 * of what should have happened is kept, and each LOOK steps the momentum is scaled by the few ulps
 * that lead back to it: errors do not accumulate. The same takes out what imexv had drifted by when
 * design 7 took over, over as many steps as it needs; and imexv's own slow drift, design 4.
 *
 *   s = sqrt(1 + e/K),  p' = s p,  K = 1/2 |p|^2,  e the energy that is energy_error
 *
 * The account is opened anew when so much has gone in and out that its own rounding would count.
 * Cost: 2 r operations a step, and an evaluation of V where the solve does not know it.
 * Source of the projection: Hairer, Lubich & Wanner 2006, Geometric Numerical Integration, IV.4,
 * doi:10.1007/3-540-30666-8.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/base/lane_sums.h"
#include "runtime/dynamics/state_private.h"
#include "runtime/polynomial/polynomial_private.h"

#define LOOK 8             /* steps between two looks, one step while energy is energy_error */
#define ROUNDING 0x1p-50   /* of the energy: is as good as nothing */
#define WAITS 1e-12        /* of the energy: is looked at again in the next step */
#define TURNOVER 1000.0    /* times the energy in and out, and the account is opened anew */
#define STRETCH 0.01       /* the largest change of a momentum in one step, a share of it */
#define KINETIC_LEAST 0.05 /* of the energy: with less the momentum is not the place */

/* s - 1 of the momentum that gains `energy_error` where it has `kinetic`; within +-STRETCH. */
static double stretch(double energy_error, double kinetic) {
  const double share = energy_error / kinetic;
  if (!(share > -STRETCH))
    return -STRETCH;
  return share < STRETCH ? share / (1.0 + sqrt(1.0 + share)) : STRETCH;
}

static double kinetic_of(const double *p, int32_t n) {
  return 0.5 * thrum_sum_of(n, p, p, NULL);
}

void thrum_energy_correction_open(thrum_state *state, double energy) {
  state->energy_correction = THRUM_ENERGY_CORRECTION_PENDING;
  state->target_energy = energy;
  state->energy_correction_begin = state->steps;
  state->energy_correction_carry = state->energy_correction_moved = 0.0;
}

void thrum_energy_correction_close(thrum_state *state) {
  state->energy_correction = THRUM_ENERGY_CORRECTION_CLOSED;
  state->energy_correction_begin = 0;
  state->target_energy = state->energy_correction_carry = state->energy_correction_moved = 0.0;
}

/* Adds with the rounding of the sum carried along (Neumaier). */
static void add(thrum_state *state, double amount) {
  const double sum = state->target_energy + amount;
  state->energy_correction_carry += fabs(state->target_energy) >= fabs(amount)
                                        ? (state->target_energy - sum) + amount
                                        : (amount - sum) + state->target_energy;
  state->target_energy = sum;
}

/* Work and dissipation of the step. */
static void enter(const thrum_model *model, thrum_state *state, const thrum_state_view *view,
                  bool damped) {
  const double work = thrum_sum_less(state->rank, view->q_next, view->q, view->load);
  double dissipated = 0.0;
  for (int32_t i = 0; damped && i < state->rank; i++) {
    const double d = view->q_next[i] - view->q[i];
    dissipated += d * d * thrum_rest_damping(model, state, i);
  }
  dissipated /= state->dt;
  add(state, work - dissipated);
  state->energy_correction_moved += fabs(work) + dissipated;
}

void thrum_energy_correction_after(const thrum_model *model, thrum_state *state,
                                   thrum_state_view *view, const thrum_solve_report *report) {
  if (state->scheme != THRUM_SCHEME_ENERGY || thrum_tangent_damped(state))
    return;
  // shorter steps dissipate by their own increments, which are not known here
  const bool damped = state->damping_alpha > 0.0 || state->damping_beta > 0.0;
  if (damped && report->fallback_level == THRUM_FALLBACK_SUBSTEPS)
    thrum_energy_correction_close(state);
  if (state->energy_correction != THRUM_ENERGY_CORRECTION_CLOSED)
    enter(model, state, view, damped);
  if (state->energy_correction == THRUM_ENERGY_CORRECTION_BALANCED &&
      (state->steps + 1 - state->energy_correction_begin) % LOOK != 0)
    return;
  const double kinetic = kinetic_of(view->p_next, state->rank);
  const double potential =
      report->potential_known
          ? report->potential
          : thrum_strain_energy_by(view->kernel, model, view->q_next, view->work);
  const double energy = kinetic + potential;
  const double energy_error = state->target_energy - energy + state->energy_correction_carry;
  if (!isfinite(energy) || !isfinite(energy_error)) {
    thrum_energy_correction_close(state);
    return;
  }
  if (state->energy_correction == THRUM_ENERGY_CORRECTION_CLOSED ||
      !(state->energy_correction_moved <= TURNOVER * fabs(energy))) {
    thrum_energy_correction_open(state, energy);
    state->energy_correction_begin++;
    state->energy_correction = THRUM_ENERGY_CORRECTION_BALANCED;
    return;
  }
  state->energy_correction = fabs(energy_error) > WAITS * fabs(energy)
                                 ? THRUM_ENERGY_CORRECTION_PENDING
                                 : THRUM_ENERGY_CORRECTION_BALANCED;
  if (fabs(energy_error) <= ROUNDING * fabs(energy) || !(kinetic >= KINETIC_LEAST * fabs(energy)))
    return;
  const double by = stretch(energy_error, kinetic);
  for (int32_t i = 0; i < state->rank; i++)
    view->p_next[i] += by * view->p_next[i];
  state->energy_correction =
      fabs(by) < 0.4 * STRETCH ? THRUM_ENERGY_CORRECTION_BALANCED : THRUM_ENERGY_CORRECTION_PENDING;
}

thrum_status thrum_energy_correction_apply(const thrum_model *model, thrum_state *state,
                                           thrum_state_view *view, double least,
                                           double *energy_error) {
  const thrum_status status = thrum_stagger_synchronise(model, state, view, NULL);
  if (status != THRUM_OK)
    return status;
  const size_t vector = (size_t)state->rank * sizeof *view->p_start;
  const double kinetic = kinetic_of(view->p_next, state->rank);
  if (!(kinetic >= least))
    return THRUM_OK;
  const double by = stretch(*energy_error, kinetic);
  memcpy(view->p_start, view->p_next, vector);
  for (int32_t i = 0; i < state->rank; i++)
    view->p_start[i] += by * view->p_start[i];
  thrum_stagger_delay(model, state, view, view->q, view->load_before, view->p_start);
  if (!thrum_all_finite(view->p_start, state->rank))
    return THRUM_NOT_FINITE;
  view->p = view->p_start;
  *energy_error = 0.0;
  return THRUM_OK;
}
