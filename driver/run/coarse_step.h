/* A time step that is coarse against a mode that moves, said before a run.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_COARSE_STEP_H
#define THRUM_DRIVER_RUN_COARSE_STEP_H

#include "driver/run/simulate_options.h"

/* What moves a body: the loads of its request at full strength (load_count x rank of the model, one
 * after the other), and its start (rank each; NULL: at rest). */
typedef struct coarse_step_motion {
  const simulate_request *request;
  const thrum_model *model; /* at its rank, whose */
  double pace;              /* times frequencies are those of the body */
  const double *directions, *q, *p;
  bool base; /* its base moves */
} coarse_step_motion;

/* Warns where the step has fewer than 8 steps (for integrators that are right up to longer steps,
 * fewer) in a period of a mode that holds a notable share of the motion: of the one that holds
 * most, with the step that would do. Where that is the first mode, of 2 steps or more. `who` begins
 * the line: "" or a body. */
void coarse_step_warn(const coarse_step_motion *motion, const char *who);

/* Warns where a step is longer than half a period of the slowest mode, of which it then shows
 * nothing. */
void coarse_step_warn_slowest(const thrum_model *model, double pace, double dt);

#endif
