/* The equation of a step in words and numbers (thrum/step_equation.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/step_equation.h"

#include "core/schemes/schemes.h"
#include "core/step/state_private.h"

const char *thrum_step_form_name(thrum_step_form form) {
  switch (form) {
#define X(name, value, text)                                                                       \
  case THRUM_STEP_##name:                                                                          \
    return text;
    THRUM_STEP_FORM_LIST(X)
#undef X
  }
  return NULL;
}

/* The form of the scheme of a state; -1: none of the list. */
static int form_of(const thrum_state *state) {
  switch (state->def.integrator) {
  case THRUM_INTEGRATOR_ENERGY:
    return state->past_discrete || state->report.steps == 0 ? THRUM_STEP_TRAPEZOID
                                                            : THRUM_STEP_AVERAGE;
  case THRUM_INTEGRATOR_MIDPOINT:
    return THRUM_STEP_MIDPOINT;
  case THRUM_INTEGRATOR_NEWMARK:
    return THRUM_STEP_NEWMARK;
  case THRUM_INTEGRATOR_VERLET:
    return THRUM_STEP_VERLET;
  default:
    return -1;
  }
}

static thrum_status refuse(const thrum_state *state, thrum_error *error) {
  if (form_of(state) < 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "steps of %s have no equation here: take energy, newmark, midpoint or "
                           "verlet",
                           thrum_integrator_name(state->def.integrator));
  if (thrum_tangent_damped(state))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "damping in tangent form has no equation here: take that of rest");
  if (thrum_can_flow(state))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a material that may flow has no equation here: its strain depends on "
                           "the steps before");
  return THRUM_OK;
}

thrum_status thrum_step_equation_get(const thrum_model *model, const thrum_state *state,
                                     thrum_step_equation *equation, double *kappa, double *nu,
                                     double *damping, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!equation)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the equation is NULL");
  THRUM_TRY(refuse(state, error));

  const thrum_state_def *def = &state->def;
  const thrum_state_view view = thrum_state_view_of((thrum_state *)(uintptr_t)state);
  *equation = (thrum_step_equation){.form = (thrum_step_form)form_of(state),
                                    .dt = def->dt,
                                    .damping_alpha = def->damping_alpha,
                                    .damping_beta = def->damping_beta,
                                    .newmark_beta = def->newmark_beta,
                                    .newmark_gamma = def->newmark_gamma,
                                    .q = view.q,
                                    .p = view.p};
  if (!kappa && !nu && !damping)
    return THRUM_OK;

  // only steps of energy have modes with a time step of their own
  const bool matches = def->integrator == THRUM_INTEGRATOR_ENERGY && thrum_schemes.mode_steps;
  const int32_t matched = matches ? thrum_schemes.mode_steps->count(model, state) : 0;
  for (int32_t i = 0; i < state->rank; i++) {
    thrum_matched_step by = {1.0, 1.0, 1.0};
    if (i < matched)
      by = thrum_schemes.mode_steps->of(model, state, i);
    if (kappa)
      kappa[i] = by.inverse;
    if (nu)
      nu[i] = by.speed;
    if (damping)
      damping[i] = thrum_rest_damping(model, state, i);
  }
  return THRUM_OK;
}
