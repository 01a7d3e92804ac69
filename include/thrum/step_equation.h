/* The equation that a step solves, for those who differentiate it (thrum/gradient.h).
 *
 * With d = q' - q, D diagonal, and two numbers of each mode, kappa = 1/lambda and nu (design 7;
 * both 1 but for the slow modes of `energy`):
 *
 *   trapezoid, average, midpoint   0 = kappa^2 d - h kappa p + h^2/2 [M(q, q') + nu^2 D d/h - f],
 *                                  p' = 2 kappa d/h - p
 *     M = 1/2 [R(q) + R(q')] + sigma d     trapezoidal discrete gradient
 *     M = [R(q) + 4 R(q + d/2) + R(q')]/6  average vector field
 *     M = R(q + d/2)                       midpoint rule
 *   newmark    q' = q + h p + h^2 [(1/2 - beta) a + beta a'],  p' = p + h [(1 - gamma) a + gamma
 * a'], a = f - R(q) - D p,  a' = f - R(q') - D p' verlet     p+ = (1 - h D/2) p - h/2 R(q) + h/2
 * [f_before + (f - f_before)/(1 + h D/2)], q' = q + h p+,  (1 + h D/2) p' = p+ - h/2 [R(q') - f]
 *
 * R is that of the levels that a body which acts has in the step (thrum/actuation.h). p of the time
 * of q throughout; f is the mean load of the step, f_before that of the step before.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STEP_EQUATION_H
#define THRUM_STEP_EQUATION_H

#include "thrum/api.h"
#include "thrum/model.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, value, text) */
#define THRUM_STEP_FORM_LIST(X)                                                                    \
  X(TRAPEZOID, 0, "trapezoidal discrete gradient")                                                 \
  X(AVERAGE, 1, "average vector field")                                                            \
  X(MIDPOINT, 2, "midpoint rule")                                                                  \
  X(NEWMARK, 3, "newmark")                                                                         \
  X(VERLET, 4, "verlet")

typedef enum thrum_step_form {
#define X(name, value, text) THRUM_STEP_##name = value,
  THRUM_STEP_FORM_LIST(X)
#undef X
} thrum_step_form;

/* Name of a form; NULL for a number that names none. Static storage. Any thread. */
THRUM_API const char *thrum_step_form_name(thrum_step_form form);

typedef struct thrum_step_equation {
  thrum_step_form form;               /* of the last step; `energy` chooses anew in each */
  double dt;                          /* h [s] */
  double damping_alpha, damping_beta; /* D = alpha + beta omega^2 of a mode [1/s], [s] */
  double newmark_beta, newmark_gamma;

  /* Where the state is, as it keeps it (rank each): q, and p, that of verlet of half a step before.
   * They lie in the state, and change with it. */
  const double *q, *p;
} thrum_step_equation;

/* The equation of the last step of a state, or, before its first, of the steps to come. kappa, nu
 * and damping (rank each; any may be NULL) get 1/lambda, nu and D [1/s] of each mode.
 * THRUM_UNSUPPORTED with the reason for a step that has another one: another integrator, damping in
 * tangent form, a material that may flow. It does not tell a step that a
 * fallback level has divided: the report counts those. Failures as thrum_step. Any thread that only
 * reads the state. */
THRUM_API thrum_status thrum_step_equation_get(const thrum_model *model, const thrum_state *state,
                                               thrum_step_equation *equation, double *kappa,
                                               double *nu, double *damping, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
