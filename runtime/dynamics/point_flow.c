/* Plastic flow at cubature points (design 19), after each step and at the q that it has reached. A
 * step itself is elastic, so the strain energy that the flow takes away is all that is lost, and
 * the account of the energies has it as dissipation.
 *
 * What the step has left for the next one is of the material before the flow: R and V are evaluated
 * again, and a correction that would have been carried is dropped, so that the next step starts
 * from q and p. Inverses and past solves stay, as any of them serves a solve.
 * Cost: the gradients of all points and a bound of their strains; the principal axes of those that
 * are near the yield. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/dynamics/point_flow.h"

#include <math.h>
#include <string.h>

#include "runtime/base/finite.h"
#include "runtime/dynamics/energy_correction.h"
#include "runtime/material/plastic_flow.h"
#include "runtime/polynomial/point_law.h"
#include "runtime/polynomial/polynomial_private.h"

const thrum_model *thrum_flowed_model(const thrum_model *model, thrum_state *state,
                                      thrum_model *copy) {
  if (!thrum_can_flow(&state->def))
    return model;
  *copy = *model;
  copy->point_plastic = thrum_state_view_of(state).plastic;
  return copy;
}

/* A point at its gradient. */
typedef struct cubature_point {
  thrum_law law;
  double lambda, mu; /* times its weight [J] */
  double gradient[3][3];
} cubature_point;

static double energy_at(const void *context, double plastic[3][3]) {
  const cubature_point *at = context;
  double gradient[3][3], elastic[3][3], stress[3][3];
  memcpy(gradient, at->gradient, sizeof gradient);
  thrum_elastic_gradient(gradient, plastic, elastic);
  return thrum_law_stress(at->law, at->lambda, at->mu, elastic, stress);
}

/* Point p with its gradient out of a restriction that holds all coordinates. */
static cubature_point point_of(const thrum_model *model, const double *restricted, int64_t p) {
  const double weight = model->point_weights[p];
  cubature_point at = {.law = thrum_law_of_model(model),
                       .lambda = weight * model->point_moduli[p],
                       .mu = weight * model->point_moduli[model->point_count + p]};
  const double *lanes = restricted + THRUM_POINT_BLOCK * (p / 8) + p % 8;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    at.gradient[c / 3][c % 3] = lanes[8 * c];
  return at;
}

/* Lets one point flow; whether it did. */
static bool flow_at(const thrum_state *state, cubature_point *at, double *place, double *taken) {
  const thrum_plastic_point point = {&state->def.plastic, state->def.dt, energy_at, at};
  double plastic[3][3], elastic[3][3], work = 0;
  memcpy(plastic, place, sizeof plastic);
  thrum_elastic_gradient(at->gradient, plastic, elastic);
  if (!thrum_plastic_settle(&point, elastic, plastic, &work) || !isfinite(work) ||
      !thrum_all_finite(plastic[0], 9))
    return false;
  memcpy(place, plastic, sizeof plastic);
  *taken += work;
  return true;
}

void thrum_forget_forces(thrum_state *state) {
  state->potential_step = -1;
  state->potential = state->potential_end = 0.0;
  state->carried = 0;
}

void thrum_point_flow(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view) {
  if (!thrum_can_flow(&state->def))
    return;

  // with all coordinates held a restriction has the gradients of all points
  thrum_polynomial_restrict(view->kernel, flowed, state->rank, view->q, view->restricted,
                            view->work);
  double taken = 0.0;
  bool any = false;
  for (int64_t p = 0; p < flowed->point_count; p++) {
    cubature_point at = point_of(flowed, view->restricted, p);
    any = flow_at(state, &at, view->plastic + THRUM_POINT_ROWS * p, &taken) || any;
  }
  if (!any)
    return;
  thrum_forget_forces(state);
  thrum_energy_correction_take(state, taken);
  state->report.plastic_work += taken;
  state->report.dissipated += taken;
}
