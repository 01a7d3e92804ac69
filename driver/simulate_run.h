/* One run: its state, its files, and the loop over the steps.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SIMULATE_RUN_H
#define THRUM_DRIVER_SIMULATE_RUN_H

#include <stdbool.h>

#include "config/progress.h"
#include "driver/run_output.h"
#include "driver/simulate_measures.h"
#include "driver/simulate_options.h"
#include "driver/simulate_report.h"
#include "thrum/thrum.h"

typedef struct simulate_full simulate_full;

/* One run in the making. All arrays lie in `memory`. */
typedef struct simulation {
  const simulate_request *request;
  const thrum_model *model; /* that is stepped: `loaded`, or its lowest coordinates */
  const thrum_model *loaded;
  void *lower_memory; /* of the latter */
  double *memory;
  double *q, *p, *force, *extents;  /* rank each */
  double *inertia, *before, *after; /* rank each: load of the base, q of a step and of the next */
  double *directions;               /* load_count x rank */
  thrum_load *courses;              /* load_count */
  thrum_state *state;               /* NULL: a run of --full, and */
  simulate_full *full;              /* NULL: one of the model */
  cli_run_output output;
  config_progress progress;
  simulate_figures figures;
  simulate_measures measures;
  double began; /* the steps [s] */
} simulation;

#define SIMULATE_BATCH_STEPS 1024   /* between two looks at the clock and the progress */
#define SIMULATE_PROGRESS_AFTER 0.5 /* shorter runs show no progress [s] */

/* From now on Ctrl-C and the like end the loop after the present step; a second one ends the
 * program as usual. */
void simulate_watch_signals(void);
/* Has somebody asked for that? */
bool simulate_stop_requested(void);

/* The whole run: rows and frames where they are due, steps between. A step that cannot be solved
 * and a stop by the user are in run->figures; a failure here is one of the output. */
thrum_status simulate_run_steps(simulation *run, thrum_error *error);

/* Completes the figures after the loop, and says why a run ended before its time. */
void simulate_note_end(simulation *run);

#endif
