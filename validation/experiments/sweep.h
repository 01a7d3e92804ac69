/* The sweep over time steps. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_SWEEP_H
#define THRUM_VALIDATION_EXPERIMENTS_SWEEP_H

#include <stdbool.h>

#include "validation/experiments/experiment_body.h"

typedef struct experiment_sweep_case {
  const experiment_body *body;
  experiment_integrator integrator;
  double impulse; /* [N s] at the start; no damping */
  double dt;
  int64_t steps;
} experiment_sweep_case;

typedef struct experiment_sweep_result {
  thrum_status status; /* THRUM_OK, or why it ended before its time */
  thrum_error stop;
  thrum_state_report report;
  double simulated;      /* [s] */
  double us_per_step;    /* processor time */
  double energy;         /* that the impulse gave [J] */
  double energy_error;   /* largest |E - energy| / energy */
  double energy_change;  /* mean of the last tenth of the run against energy, relative */
  double peak_amplitude; /* as a share of the body's length */
  bool lost;             /* it came to its end, with an energy that has more than doubled */
} experiment_sweep_result;

/* "done", "lost", or why it ended before its time. */
const char *experiment_sweep_status(const experiment_sweep_result *result);

/* Runs one case; looks at the energy about a thousand times. */
thrum_status experiment_sweep_run(const experiment_sweep_case *run, experiment_sweep_result *result,
                                  thrum_error *error);

#endif
