/* The sweep over time steps: how far each scheme is off, in energy and against a reference, and
 * what it costs. Three experiments are made of it: the sweep, work against precision, and steps
 * whose length varies. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_SWEEP_H
#define THRUM_VALIDATION_EXPERIMENTS_SWEEP_H

#include "platform/allocate.h"
#include "platform/thread_pool.h"
#include "validation/experiments/fine_reference.h"
#include "validation/experiments/scheme.h"

/* Every time step is a whole number of these [s]. */
#define EXPERIMENT_SWEEP_TICK 1e-4

/* How a body starts, from q = 0. X(name) */
#define EXPERIMENT_START_LIST(X)                                                                   \
  X(impulse) /* the momentum that an impulse at the loaded group leaves */                         \
  X(smooth)  /* momentum in the first basis vector alone */

typedef enum experiment_start {
#define X(name) EXPERIMENT_START_##name,
  EXPERIMENT_START_LIST(X)
#undef X
      EXPERIMENT_START_COUNT
} experiment_start;

extern const char *const experiment_start_names[EXPERIMENT_START_COUNT];

/* One length of time step. Unless the two are equal, each step is drawn between them. */
typedef struct experiment_dt {
  int64_t longest, shortest; /* in ticks */
} experiment_dt;

typedef struct experiment_sweep_case {
  const experiment_body *body;
  const experiment_reference *reference;
  experiment_start start;
  experiment_scheme scheme;
  double impulse; /* [N s] at the start; no damping */
  experiment_dt dt;
} experiment_sweep_case;

typedef struct experiment_sweep_result {
  thrum_status status; /* THRUM_OK, or what the step said that ended it */
  thrum_error stop;
  thrum_state_report report;
  double us_per_step;   /* processor time, the least of all rounds */
  double cost;          /* processor time for a simulated second [s] */
  double energy;        /* that the impulse gave [J] */
  double energy_error;  /* largest |E - energy| / energy */
  double energy_change; /* mean of the last tenth of the run against energy, relative */
  double error;         /* of q over the time of the reference; NaN for a run that was lost in it */
  double peak_amplitude; /* as a share of the body's length */
  bool lost; /* the energy grew by EXPERIMENT_LOST, or its mean has more than doubled at the end */
} experiment_sweep_result;

/* A sweep: each body and start with each scheme at each time step. The caller fills all but the
 * members after `progress_context`. */
typedef struct experiment_sweep {
  const experiment_body *bodies;
  int64_t body_count;
  bool starts[EXPERIMENT_START_COUNT];
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  const experiment_dt *dts; /* dt_count */
  int64_t dt_count;
  double amplitude;      /* to which the start makes a body swing, as a share of its length */
  double time;           /* [s] */
  double reference_time; /* over which q is compared [s] */
  int rounds; /* after the first, all runs are timed once more each over the reference's time */
  int threads;
  bool (*progress)(void *context, double fraction); /* may be NULL; false stops */
  void *progress_context;
  int64_t count, start_count;
  experiment_sweep_case *cases; /* count, by body, start, time step, scheme, the last fastest */
  experiment_sweep_result *results;
  experiment_body *smooth;          /* body_count: pushed in the first basis vector alone */
  experiment_reference *references; /* start_count */
  double *impulses;                 /* start_count */
  thrum_scope memory;               /* of these arrays */
  int round;                        /* that runs */
} experiment_sweep;

/* The time steps of the three experiments. */
extern const experiment_dt experiment_sweep_dts[];
extern const int64_t experiment_sweep_dt_count;
extern const experiment_dt
    experiment_variable_dts[]; /* a constant one, then those drawn around it */
extern const int64_t experiment_variable_dt_count;

/* Runs all cases. Free with experiment_sweep_free, on failure too. A run that is lost is no
 * failure.
 */
thrum_status experiment_sweep_run(experiment_sweep *sweep, thrum_error *error);
void experiment_sweep_free(experiment_sweep *sweep);

/* Whether a run was lost that should not be. */
bool experiment_sweep_flagged(const experiment_sweep *sweep);

#endif
