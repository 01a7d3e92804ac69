/* A run: one stepper, one loop over its steps, one record of each body.
 *
 * The loop steps until a row or a frame is due, records it, shows progress and stops when a step
 * fails or the user asks to. `thrum simulate` runs a single model by it (simulate_run.h) and a
 * scene (scene_run.h). SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_RUN_H
#define THRUM_DRIVER_RUN_RUN_H

#include "config/progress.h"
#include "driver/record/run_output.h"
#include "driver/run/run_probes.h"
#include "driver/run/simulate_measures.h"
#include "driver/run/stepper.h"

/* One body of a run: its figures and its files. The caller sets the first three. */
typedef struct driver_body {
  const char *name;         /* in messages; NULL: the run has no other body */
  bool moves;               /* as a whole, so places.npy is written */
  simulate_figures figures; /* with the request, the model and its hash */
  simulate_measures measures;
  run_probes probes;
  run_output output;
  double *q, *p, *extents; /* rank each, in one allocation at q */
  thrum_energies energies; /* of the row in the making */
} driver_body;

typedef struct driver_run {
  const char *name; /* of the model or the scene, in messages */
  driver_stepper stepper;
  driver_body *bodies; /* body_count; owned */
  int32_t body_count;
  int64_t rows, frames;
  thrum_status status; /* how the run ended */
  thrum_error stop;    /* why it ended early; an empty message: it did not */
  config_progress progress;
  double began; /* the first step, clock_seconds() */
  double seconds_step;
} driver_run;

/* Room for the bodies. driver_run_close frees the stepper and all files, whatever came back. */
thrum_status driver_run_open(driver_run *run, int32_t body_count, thrum_error *error);
void driver_run_close(driver_run *run);

/* run_record.c: the measures and the files of a body in the folder `path`; `shown` is the model
 * that measures and frames are of. */
thrum_status driver_run_open_body(driver_run *run, int32_t n, const char *path,
                                  const thrum_model *shown, thrum_error *error);
/* Records a row of each body, or with `row` false only energies, peaks and measures at the end. An
 * energy that is not finite ends the run, which is no failure. */
thrum_status driver_run_record(driver_run *run, int64_t step, bool row, thrum_error *error);
thrum_status driver_run_frame(driver_run *run, int64_t step, thrum_error *error);
/* Ends the series of all bodies, and writes what each can be continued from. */
thrum_status driver_run_end(driver_run *run, thrum_error *error);

/* The whole loop, then the figures of how it ended. A step that cannot be solved and a stop by the
 * user are in run->status and run->stop; a failure here is one of the files. */
thrum_status driver_run_steps(driver_run *run, bool quiet, thrum_error *error);

/* Steps that all bodies have made. */
int64_t driver_run_step_count(const driver_run *run);

/* Of all bodies together. */
run_outcome driver_run_outcome(const driver_run *run);

/* A line on standard error for what ended the run early, and for each body that needs one. */
void driver_run_warn(const driver_run *run);

/* All bodies of a run share the times of the first one's request. */
static inline const simulate_request *driver_run_request(const driver_run *run) {
  return run->bodies[0].figures.request;
}

#endif
