/* Linear against nonlinear: how far a body may be bent before linear modal analysis is wrong by so
 * much, and what the cubic and quartic terms cost.
 *
 * Reference is the same reduced model with its cubic and quartic terms; the linear one is that
 * model without them, so that what is compared is the nonlinearity alone and not the basis. Error
 * is |q_lin - q|/|q|, the displacement over the whole body in the norm of the mass.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_LINEAR_FREE_VIBRATION_H
#define THRUM_VALIDATION_EXPERIMENTS_LINEAR_FREE_VIBRATION_H

#include <stdbool.h>

#include "validation/experiments/experiment_body.h"

#define STUDY_LINEAR_POINTS 24
#define STUDY_LINEAR_LEVELS 2

extern const double study_linear_levels[STUDY_LINEAR_LEVELS]; /* 0.05, 0.2 */

/* An amplitude of the nonlinear answer, as a share of the body's length, and the error there. */
typedef struct study_linear_point {
  double load;      /* [N], or [N s] */
  double amplitude; /* mean displacement of the loaded group over the length; of motion its peak */
  double error;
} study_linear_point;

typedef struct study_linear_curve {
  int64_t count;
  study_linear_point points[STUDY_LINEAR_POINTS]; /* load ascending */
  study_linear_point at[STUDY_LINEAR_LEVELS]; /* where the levels are passed; NaN: they are not */
} study_linear_curve;

typedef struct study_linear_result {
  study_linear_curve statics;  /* at rest under a constant load */
  study_linear_curve dynamics; /* after an impulse, root mean square over a period of mode 1 */
  double force_us;             /* R(q) and V(q), processor time */
  double step_us;              /* of imexv at its defaults */
  double linear_us;            /* a step of the linear modes, exact */
} study_linear_result;

thrum_status study_linear_run(const study_body *body, study_linear_result *result,
                              thrum_error *error);

#endif
