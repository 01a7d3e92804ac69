/* Trial runs for the keys "error" and "budget": one body of the scene file in a scene of its own,
 * with all coordinates and then condensed (design 16), over the first seconds.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_TRIAL_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_TRIAL_H

#include "driver/scene/scene_run_parts.h"

/* One body in a scene of its own, with all that acts on it but other bodies. Its
 * hash is that of all that its motion depends on. scene_trial_close frees, whatever came back. */
typedef struct scene_trial {
  const scene_run *run;
  int32_t number; /* of the body */
  thrum_scene *scene;
  int64_t steps;
  double *rows; /* shapes with all coordinates; owned */
  double size;  /* sum of their squares; 0: it stays at rest, or its run fails */
} scene_trial;

thrum_status scene_trial_open(const scene_run *run, int32_t number, scene_trial *trial,
                              thrum_error *error);
void scene_trial_close(scene_trial *trial);
uint64_t scene_trial_hash(const scene_run *run, int32_t number);

/* The time that a trial simulates [s]: the first seconds of the scene, or all of it. */
double scene_trial_seconds(const scene_run *run);

/* The error of the shape with so many masters, over the first seconds; INFINITY where the run fails
 * or errs by more than `most`, which ends it. */
thrum_status scene_trial_run(scene_trial *trial, int64_t masters, double most, double *found,
                             thrum_error *error);

#endif
