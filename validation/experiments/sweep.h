/* The sweep over time steps. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_SWEEP_H
#define THRUM_VALIDATION_EXPERIMENTS_SWEEP_H

#include <stdbool.h>

#include "platform/thread_pool.h"
#include "validation/experiments/experiment_body.h"

#define EXPERIMENT_SWEEP_SHORTEST 1e-4 /* shortest time step [s] */

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

/* A sweep: each body with each integrator at each time step. The caller fills all but the last
 * three. */
typedef struct experiment_sweep {
  const experiment_body *bodies;
  int64_t body_count;
  bool integrators[EXPERIMENT_INTEGRATOR_COUNT];
  double amplitude; /* to which the impulse makes a body swing, as a share of its length */
  double time;      /* [s] */
  int threads;
  bool (*progress)(void *context, double fraction); /* may be NULL; false stops */
  void *progress_context;
  int64_t count;
  experiment_sweep_case *cases; /* count, by body, time step, integrator, the last fastest */
  experiment_sweep_result *results;
} experiment_sweep;

/* Runs all cases; each looks at the energy about a thousand times. Free with experiment_sweep_free,
 * on failure too. A run that ends early is no failure. */
thrum_status experiment_sweep_run(experiment_sweep *sweep, thrum_error *error);
void experiment_sweep_free(experiment_sweep *sweep);

/* Whether a run failed that should not: newmark may lose its energy, since it does not conserve it.
 */
bool experiment_sweep_flagged(const experiment_sweep *sweep);

#endif
