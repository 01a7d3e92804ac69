/* The definition of a state: its defaults and its checks (thrum/state.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/step/state_def.h"

#include <math.h>

#include "core/base/def.h"
#include "core/polynomial/points.h"
#include "core/schemes/schemes.h"

#define TOLERANCE_MOST 1e-2 /* that a definition may ask for */

void thrum_state_def_init(thrum_state_def *def, size_t size) {
  const thrum_state_def defaults = {
      .cookie = sizeof(thrum_state_def),
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
  thrum_def_fill(def, size, &defaults, sizeof defaults);
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
  return thrum_error_set_field(error, name, THRUM_INVALID_ARGUMENT, " is %g; it must be %s", value,
                               range);
}

static bool non_negative(double value) {
  return isfinite(value) && value >= 0.0;
}

static thrum_status check_choices(const thrum_model *model, const thrum_state_def *def,
                                  thrum_error *error) {
  const int integrator = (int)def->integrator, form = (int)def->damping_form;
  const int rule = (int)def->split_rule, split_form = (int)def->split_form;

  // compared as int: the value may be none of its enum
  if (!thrum_integrator_name(def->integrator))
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

/* The member of the def that asks for what this library lacks; NULL: there is none. */
static const char *lacking(const thrum_state_def *def) {
  if (thrum_first_scheme(def) < 0)
    return "integrator";
  if (def->adaptive && thrum_adapts(def->integrator) && !thrum_schemes.adapts)
    return "adaptive";
  if (def->fallback && !thrum_schemes.falls_back)
    return "fallback";
  return def->frequency_matched && !thrum_schemes.mode_steps ? "frequency_matched" : NULL;
}

/* The core alone steps by its own schemes and without guards. */
static thrum_status check_parts(const thrum_state_def *def, thrum_error *error) {
  const char *name = lacking(def);
  if (!name)
    return THRUM_OK;
  return thrum_error_set_field(error, name, THRUM_UNSUPPORTED,
                               " asks for what this library, the core alone, does not have: set it "
                               "to %s",
                               thrum_first_scheme(def) < 0 ? "imexv, newmark or energy" : "0");
}

thrum_status thrum_state_def_check(const thrum_model *model, const thrum_state_def *def,
                                   thrum_error *error) {
  THRUM_TRY(thrum_state_check_model(model, error));
  if (!def)
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
  if (!(def->tolerance >= 0.0) || !(def->tolerance <= TOLERANCE_MOST))
    return refuse(error, "tolerance", def->tolerance, "in [0, 1e-2]");
  THRUM_TRY(check_choices(model, def, error));
  THRUM_TRY(check_parts(def, error));
  for (const thrum_on_check *hook = thrum_schemes.check; hook && *hook; hook++)
    THRUM_TRY((*hook)(model, def, error));
  return THRUM_OK;
}
