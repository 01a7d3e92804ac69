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

#define EXPERIMENT_LINEAR_POINTS 24
#define EXPERIMENT_LINEAR_LEVELS 2

extern const double experiment_linear_levels[EXPERIMENT_LINEAR_LEVELS]; /* 0.05, 0.2 */

/* An amplitude of the nonlinear answer, as a share of the body's length, and the error there. */
typedef struct experiment_linear_point {
  double load;      /* [N], or [N s] */
  double amplitude; /* mean displacement of the loaded group over the length; of motion its peak */
  double error;
} experiment_linear_point;

typedef struct experiment_linear_curve {
  int64_t count;
  experiment_linear_point points[EXPERIMENT_LINEAR_POINTS]; /* load ascending */
  experiment_linear_point
      at[EXPERIMENT_LINEAR_LEVELS]; /* where the levels are passed; NaN: they are not */
} experiment_linear_curve;

typedef struct experiment_linear_result {
  experiment_linear_curve statics;  /* at rest under a constant load */
  experiment_linear_curve dynamics; /* after an impulse, root mean square over a period of mode 1 */
  double force_us;                  /* R(q) and V(q), processor time */
  double step_us;                   /* of imexv at its defaults */
  double linear_us;                 /* a step of the linear modes, exact */
} experiment_linear_result;

/* The comparison for one body. */
thrum_status experiment_linear_compare(const experiment_body *body,
                                       experiment_linear_result *result, thrum_error *error);

/* The comparison for a list of bodies. The caller fills all but `results`. */
typedef struct experiment_linear {
  const experiment_body *bodies;
  int64_t body_count;
  int threads;
  bool (*progress)(void *context, double fraction); /* may be NULL; false stops */
  void *progress_context;
  experiment_linear_result *results; /* body_count; free() when done */
} experiment_linear;

thrum_status experiment_linear_run(experiment_linear *linear, thrum_error *error);

#endif
