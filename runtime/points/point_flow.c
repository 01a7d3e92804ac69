/* Plastic flow at cubature points (design 19), after each step and at the q that it has reached. A
 * step itself is elastic, so the strain energy that the flow takes away is all that is lost, and
 * the account of the energies has it as dissipation.
 *
 * The step leaves values for the next one that belong to the material before the flow. So R and V
 * are evaluated again, and a correction that would have been carried is dropped: the next step
 * starts from q and p. Inverses and past solves stay, as any of them serves a solve.
 * Cost: the gradients of all points and a bound of their strains; the principal axes of those that
 * are near the yield. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/points/point_flow.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "runtime/guard/energy_correction.h"
#include "runtime/material/plastic_flow.h"
#include "runtime/points/point_law.h"
#include "runtime/points/point_rest.h"

/* --- a state ---------------------------------------------------------------------------------- */

static thrum_status refuse(thrum_error *error, const char *name, double value, const char *range) {
  return thrum_error_set_field(error, name, THRUM_INVALID_ARGUMENT, " is %g; it must be %s", value,
                               range);
}

/* Whether the law of some point is one that flows. */
static bool some_law_flows(const thrum_model *model) {
  for (int64_t i = 0; i < model->law_count; i++)
    if (model->region_law[i] != THRUM_LAW_STVK)
      return true;
  return !model->region_law && thrum_law_of_model(model) != THRUM_LAW_STVK;
}

/* Points know what flow does where they were chosen by states that had flowed: that happens at
 * places of the body, so not where gradients were learned, and no lower yield does where nothing
 * did. */
static thrum_status check_training(const thrum_model *model, const thrum_state_def *def,
                                   thrum_error *error) {
  const double *training = model->point_training;
  if (!training || def->untrained_flow == 1)
    return THRUM_OK;
  if (training[THRUM_TRAINING_LEARNED] > 0.0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the gradients of the model's cubature points were learned, so that "
                           "what flows is the strain of no place of the body: precompute it "
                           "without --cubature-refine and with --yield, or set untrained_flow "
                           "(--untrained-flow on)");

  // a region's own yield is one of those of the training
  const double yield = training[THRUM_TRAINING_YIELD];
  const bool flowed = training[THRUM_TRAINING_PLASTIC] > 0.0;
  if (yield > 0.0 && (flowed || def->plastic.yield >= yield))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the model's cubature points were not trained on plastic flow%s: strain "
                         "and work of what flows may be several times too small; precompute it "
                         "with --yield, or set untrained_flow (--untrained-flow on)",
                         yield > 0.0 ? " beyond so small a yield" : "");
}

/* Flow is there where the points answer by a law of F, and for the integrator whose step is elastic
 * and ends at q and p of one time. */
thrum_status thrum_point_flow_check(const thrum_model *model, const thrum_state_def *def,
                                    thrum_error *error) {
  const thrum_plastic *plastic = &def->plastic;
  if (!(plastic->yield > 0.0))
    return refuse(error, "plastic.yield", plastic->yield, "> 0; infinite: nothing flows");
  if (!(plastic->creep > 0.0))
    return refuse(error, "plastic.creep", plastic->creep, "> 0 [1/s]; infinite: at once");
  if (!(plastic->largest > 0.0))
    return refuse(error, "plastic.largest", plastic->largest, "> 0; infinite: no bound");
  const bool own = thrum_law_has_yield(model);
  if (!own && plastic->yield == INFINITY)
    return THRUM_OK;

  // what flows
  if (!own && !some_law_flows(model))
    return thrum_error_set_field(error, "plastic.yield", THRUM_UNSUPPORTED,
                                 " is %g, and this model cannot flow: cubature points of the law "
                                 "corotational or neo-hookean do",
                                 plastic->yield);
  if (own && def->integrator != THRUM_INTEGRATOR_ENERGY)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a region of this model has a yield of its own, and the integrator %s "
                           "does not step plastic flow: energy does",
                           thrum_integrator_name(def->integrator));
  if (def->integrator != THRUM_INTEGRATOR_ENERGY)
    return thrum_error_set_field(error, "plastic.yield", THRUM_UNSUPPORTED,
                                 " is %g, and the integrator %s does not step plastic flow: energy "
                                 "does",
                                 plastic->yield, thrum_integrator_name(def->integrator));
  return check_training(model, def, error);
}

void thrum_point_flow_plan(const thrum_model *model, thrum_state *state) {
  const int64_t r = model->rank;
  if (!(state->def.plastic.yield < INFINITY) && !thrum_law_has_yield(model))
    return;

  // with all coordinates held, a restriction has the gradients of all points
  state->restricted_count = thrum_restriction_count(model, r);
  state->plastic_count = thrum_points_plastic_count(model);
  state->shares_count = r;
  state->shapes_count = r * r;
}

void thrum_point_flow_prepare(const thrum_model *model, thrum_state *state) {
  if (!thrum_can_flow(state))
    return;

  // an inverse that there is not yet lends its room
  const thrum_state_view view = thrum_state_view_of(state);
  thrum_rest_shares(model, view.shapes, view.shares, view.inverses);
  thrum_rest_prepare(model, view.shapes, view.shares, view.plastic);
  memset(view.inverses, 0, (size_t)state->kept_count * sizeof *view.inverses);
}

/* Makes the part of the energy that the plastic strains of a state have released. */
static void release(const thrum_model *model, thrum_state *state, const thrum_state_view *view) {
  thrum_rest_release(model, view->shapes, view->shares, view->plastic);
  state->release_due = 0;
}

const thrum_model *thrum_flowed_model(const thrum_model *model, thrum_state *state,
                                      thrum_model *copy) {
  if (!thrum_can_flow(state))
    return model;
  const thrum_state_view view = thrum_state_view_of(state);
  if (state->release_due)
    release(model, state, &view);
  *copy = *model;
  copy->point_plastic = view.plastic;
  return copy;
}

enum { HALVINGS_MAX = 12 }; // of what flows in a step, until it takes energy

/* A point at its gradient. */
typedef struct cubature_point {
  thrum_law law;
  thrum_plastic material;
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
static cubature_point point_of(const thrum_model *model, const thrum_plastic *material,
                               const double *restricted, int64_t p) {
  const double weight = model->point_weights[p];
  const int64_t region = model->point_region ? model->point_region[p] : 0;
  cubature_point at = {.law = thrum_law_of_region(model, region),
                       .material = *material,
                       .lambda = weight * model->point_moduli[p],
                       .mu = weight * model->point_moduli[model->point_count + p]};
  at.material.yield = thrum_law_yield(model, region, material->yield);
  const double *lanes = restricted + THRUM_POINT_BLOCK * (p / 8) + p % 8;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    at.gradient[c / 3][c % 3] = lanes[8 * c];
  return at;
}

/* Lets one point flow by a share of what the rule asks for, and saves its plastic strain before
 * that in the lanes of its gradient. Returns whether it flowed. */
static bool flow_at(const thrum_state *state, cubature_point *at, double share, double *place,
                    double *lanes, double *taken) {
  const thrum_plastic_point point = {&at->material, state->def.dt, share, energy_at, at};
  double plastic[3][3], elastic[3][3], work = 0;
  for (int c = 0; c < THRUM_POINT_ROWS; c++)
    lanes[8 * c] = place[c];
  memcpy(plastic, place, sizeof plastic);
  thrum_elastic_gradient(at->gradient, plastic, elastic);
  if (!thrum_plastic_settle(&point, elastic, plastic, &work) || !isfinite(work) ||
      !thrum_all_finite(plastic[0], 9))
    return false;
  memcpy(place, plastic, sizeof plastic);
  *taken += work;
  return true;
}

static double *lanes_of(double *restricted, int64_t p) {
  return restricted + THRUM_POINT_BLOCK * (p / 8) + p % 8;
}

/* Lets all points flow by such a share. Returns whether one did, and gives the strain energy that
 * the flow took, which may be negative. */
static bool flow_by(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view,
                    double share, double *taken) {
  // with all coordinates held a restriction has the gradients of all points
  double seen[THRUM_RANK_MAX];
  thrum_points_see(flowed, view->q, seen);
  thrum_polynomial_restrict(view->kernel, flowed, state->rank, seen, view->restricted, view->work);
  bool any = false;
  double sum = 0;
  for (int64_t p = 0; p < flowed->point_count; p++) {
    cubature_point at = point_of(flowed, &state->def.plastic, view->restricted, p);
    any = flow_at(state, &at, share, view->plastic + THRUM_POINT_ROWS * p,
                  lanes_of(view->restricted, p), &sum) ||
          any;
  }
  if (!any)
    return false;
  sum += thrum_released_energy(flowed, view->q);
  release(flowed, state, view);
  *taken = sum - thrum_released_energy(flowed, view->q);
  return true;
}

/* Takes the last flow back. */
static void flow_back(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view) {
  for (int64_t p = 0; p < flowed->point_count; p++)
    for (int c = 0; c < THRUM_POINT_ROWS; c++)
      view->plastic[THRUM_POINT_ROWS * p + c] = lanes_of(view->restricted, p)[8 * c];
  release(flowed, state, view);
}

void thrum_forget_forces(thrum_state *state) {
  state->potential_step = -1;
  state->potential = state->potential_end = 0.0;
  state->carried = 0;
}

/* Flows as far as lowers the strain energy, that of the stiffness without points too; whether
 * anything has flowed, and what of the energy that took. */
static bool flow_within(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view,
                        double *taken) {
  double share = 1;
  for (int k = 0; k < HALVINGS_MAX; k++, share *= 0.5) {
    if (!flow_by(flowed, state, view, share, taken))
      return false;
    if (*taken >= 0 && isfinite(*taken))
      return true;
    flow_back(flowed, state, view);
  }
  return false;
}

void thrum_point_flow(const thrum_model *flowed, thrum_state *state, const thrum_state_view *view) {
  double taken = 0.0;
  if (!thrum_can_flow(state) || !flow_within(flowed, state, view, &taken))
    return;
  thrum_forget_forces(state);
  thrum_energy_correction_take(state, taken);
  state->report.plastic_work += taken;
  state->report.dissipated += taken;
}
