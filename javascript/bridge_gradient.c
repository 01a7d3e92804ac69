/* The functions that JavaScript calls for gradients of runs (thrum/gradient.h); as in
 * bridge_engine.c. SPDX-License-Identifier: Apache-2.0 */
#include "javascript/bridge.h"
#include "thrum/gradient.h"

/* A tape for so many steps of a model that is stepped. */
thrum_tape *EXPORT(js_tape_create)(const thrum_model *model, double steps) {
  thrum_tape_def def = thrum_default_tape_def();
  thrum_tape *tape = NULL;
  def.steps = (int64_t)steps;
  return thrum_tape_create(model, &def, &tape, &js_failure) < 0 ? NULL : tape;
}

void EXPORT(js_tape_destroy)(thrum_tape *tape) {
  thrum_tape_destroy(tape);
}

/* Begins the tape at q and p, and makes as many steps as it has room for (steps x shown; NULL: no
 * force). */
int32_t EXPORT(js_tape_run)(const thrum_model *model, thrum_tape *tape, thrum_state *state,
                            const double *q, const double *p, const double *force, double steps) {
  THRUM_TRY(thrum_tape_start(model, tape, state, q, p, &js_failure));
  return thrum_tape_run(model, tape, state, force, (int64_t)steps, NULL, &js_failure);
}

/* q of all steps, or p. */
const double *EXPORT(js_tape_rows)(const thrum_tape *tape, int32_t momenta) {
  return momenta ? thrum_tape_p(tape) : thrum_tape_q(tape);
}

/* The gradient by q, p, damping (rank each) and force; numbers: by alpha, beta, stiffness and
 * density. */
int32_t EXPORT(js_tape_pull_back)(const thrum_model *model, thrum_tape *tape, const double *q_bar,
                                  const double *p_bar, double *q, double *p, double *damping,
                                  double *force) {
  thrum_tape_gradient gradient = {.q = q, .p = p, .damping = damping, .force = force};
  THRUM_TRY(thrum_tape_pull_back(model, tape, q_bar, p_bar, &gradient, &js_failure));
  js_number[0] = gradient.alpha;
  js_number[1] = gradient.beta;
  js_number[2] = gradient.stiffness;
  js_number[3] = gradient.density;
  return THRUM_OK;
}
