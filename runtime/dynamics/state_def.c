/* The definition of a state: its defaults and its checks (thrum/state.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/dynamics/state_def.h"

#include <math.h>

#include "runtime/dynamics/state_layout.h"
#include "runtime/material/material_law.h"
#include "runtime/polynomial/points.h"
#include "thrum/condensed_model.h"

#define DEF_COOKIE UINT32_C(0x7468726d)

thrum_state_def thrum_default_state_def(void) {
  const thrum_state_def def = {
      .cookie = DEF_COOKIE,
      .integrator = THRUM_INTEGRATOR_ENERGY,
      .dt = 0.003,
      .damping_alpha = 0.0,
      .damping_beta = 0.0,
      .damping_form = THRUM_DAMPING_REST,

      .split_rule = THRUM_SPLIT_CFL,
      .split_safety = 0.5,
      .explicit_count = 0,

      // the solve, and what follows where it fails
      .newmark_beta = 0.25,
      .newmark_gamma = 0.5,
      .tolerance = 0.0,
      .plastic = {INFINITY, INFINITY, INFINITY},
      .iterations_max = 50,
      .kernel = THRUM_KERNEL_BEST,
      .split_form = THRUM_FORM_POSITION,
      .adaptive = 1,
      .fallback = 1,
      .solver = THRUM_SOLVER_QUASI_NEWTON,
      .frequency_matched = 1,
  };
  return def;
}

thrum_status thrum_state_check_model(const thrum_model *model, thrum_error *error) {
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");

  // sizes and arrays
  if (model->rank < 1 || model->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model's rank is %lld, not 1 to %d",
                           (long long)model->rank, THRUM_RANK_MAX);
  if (thrum_model_masters(model) > 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model was precomputed condensed: what is stepped of it comes from "
                           "thrum_model_condense");
  if (!thrum_has_energy(model))
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no omega2, or neither c3 and c4 nor cubature points");

  // the split of the modes needs them in ascending order
  for (int64_t i = 0; i < model->rank; i++) {
    const double low = i > 0 ? model->omega2[i - 1] : 0.0;
    if (!isfinite(model->omega2[i]) || model->omega2[i] < low)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "omega2 of the model: entry %lld is not finite, negative or smaller "
                             "than the one before",
                             (long long)i);
  }
  return THRUM_OK;
}

static thrum_status refuse(thrum_error *error, const char *name, double value, const char *range) {
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "%s of the state's def is %g; it must be %s", name, value, range);
}

static bool non_negative(double value) {
  return isfinite(value) && value >= 0.0;
}

static thrum_status check_choices(const thrum_model *model, const thrum_state_def *def,
                                  thrum_error *error) {
  const int integrator = (int)def->integrator, form = (int)def->damping_form;
  const int rule = (int)def->split_rule, split_form = (int)def->split_form;

  // compared as int: the value may be none of its enum
  if (integrator < THRUM_INTEGRATOR_IMEXV || integrator > THRUM_INTEGRATOR_MANIFOLD)
    return refuse(error, "integrator", integrator, "one of thrum_integrator");
  if (form < THRUM_DAMPING_REST || form > THRUM_DAMPING_TANGENT)
    return refuse(error, "damping_form", form, "one of thrum_damping_form");
  if (rule < THRUM_SPLIT_CFL || rule > THRUM_SPLIT_COUNT)
    return refuse(error, "split_rule", rule, "one of thrum_split_rule");

  // split
  if (split_form < THRUM_FORM_THESIS || split_form > THRUM_FORM_POSITION)
    return refuse(error, "split_form", split_form, "one of thrum_split_form");
  if (def->explicit_count < 0 || def->explicit_count > model->rank)
    return refuse(error, "explicit_count", def->explicit_count, "0 to the model's rank");

  // switches and the solve
  if (def->adaptive != 0 && def->adaptive != 1)
    return refuse(error, "adaptive", def->adaptive, "0 or 1");
  if (def->fallback != 0 && def->fallback != 1)
    return refuse(error, "fallback", def->fallback, "0 or 1");
  const int solver = (int)def->solver;
  if (solver < THRUM_SOLVER_QUASI_NEWTON || solver > THRUM_SOLVER_NEWTON)
    return refuse(error, "solver", solver, "one of thrum_implicit_solver");
  if (def->borrows_scratch != 0 && def->borrows_scratch != 1)
    return refuse(error, "borrows_scratch", def->borrows_scratch, "0 or 1");
  if (def->untrained_flow != 0 && def->untrained_flow != 1)
    return refuse(error, "untrained_flow", def->untrained_flow, "0 or 1");
  if (def->frequency_matched != 0 && def->frequency_matched != 1)
    return refuse(error, "frequency_matched", def->frequency_matched, "0 or 1");
  if (!thrum_kernel_name(def->kernel))
    return refuse(error, "kernel", (double)def->kernel, "one of thrum_kernel_id");
  if (def->iterations_max < 1)
    return refuse(error, "iterations_max", def->iterations_max, "at least 1");
  return THRUM_OK;
}

/* Whether the law of some point is one that flows. */
static bool can_flow(const thrum_model *model) {
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
static thrum_status check_plastic(const thrum_model *model, const thrum_state_def *def,
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
  if (!own && !can_flow(model))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "plastic.yield of the state's def is %g, and this model cannot flow: "
                           "cubature points of the law corotational or neo-hookean do",
                           plastic->yield);
  if (own && def->integrator != THRUM_INTEGRATOR_ENERGY)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a region of this model has a yield of its own, and the integrator %s "
                           "does not step plastic flow: energy does",
                           thrum_integrator_name(def->integrator));
  if (def->integrator != THRUM_INTEGRATOR_ENERGY)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "plastic.yield of the state's def is %g, and the integrator %s does not "
                           "step plastic flow: energy does",
                           plastic->yield, thrum_integrator_name(def->integrator));
  return check_training(model, def, error);
}

thrum_status thrum_state_def_check(const thrum_model *model, const thrum_state_def *def,
                                   thrum_error *error) {
  THRUM_TRY(thrum_state_check_model(model, error));
  if (!def || def->cookie != DEF_COOKIE)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the state's def was not made by thrum_default_state_def");

  // numbers, each with its range
  if (!isfinite(def->dt) || !(def->dt > 0.0))
    return refuse(error, "dt", def->dt, "finite and > 0 [s]");
  if (!non_negative(def->damping_alpha))
    return refuse(error, "damping_alpha", def->damping_alpha, "finite and >= 0 [1/s]");
  if (!non_negative(def->damping_beta))
    return refuse(error, "damping_beta", def->damping_beta, "finite and >= 0 [s]");
  if (!(def->split_safety > 0.0) || !(def->split_safety <= 1.0))
    return refuse(error, "split_safety", def->split_safety, "in (0, 1]");
  if (!non_negative(def->newmark_beta))
    return refuse(error, "newmark_beta", def->newmark_beta, "finite and >= 0");
  if (!(def->newmark_gamma >= 0.0) || !(def->newmark_gamma <= 1.0))
    return refuse(error, "newmark_gamma", def->newmark_gamma, "in [0, 1]");
  if (!(def->tolerance >= 0.0) || !(def->tolerance <= 1e-2))
    return refuse(error, "tolerance", def->tolerance, "in [0, 1e-2]");
  THRUM_TRY(check_choices(model, def, error));
  return check_plastic(model, def, error);
}
