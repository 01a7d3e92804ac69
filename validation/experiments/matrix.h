/* The matrix of experiments: bodies x loads x damping x time steps x schemes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_MATRIX_H
#define THRUM_VALIDATION_EXPERIMENTS_MATRIX_H

#include "platform/thread_pool.h"
#include "validation/experiments/experiment_body.h"
#include "validation/experiments/scheme.h"

/* The loads of the thesis. X(name, shape, until [s], frequency [Hz], amplitude to reach) */
#define EXPERIMENT_LOAD_LIST(X)                                                                    \
  X(impulse, THRUM_LOAD_CONSTANT, 0.003, 0, 0.05)                                                  \
  X(square, THRUM_LOAD_CONSTANT, 0.3, 0, 0.05)                                                     \
  X(sine, THRUM_LOAD_SINE, INFINITY, 1, 0.1)

typedef enum experiment_load {
#define X(name, shape, until, frequency, amplitude) EXPERIMENT_LOAD_##name,
  EXPERIMENT_LOAD_LIST(X)
#undef X
      EXPERIMENT_LOAD_COUNT
} experiment_load;

extern const char *const experiment_load_names[EXPERIMENT_LOAD_COUNT];

#define EXPERIMENT_DAMPING_COUNT 2
extern const double experiment_dampings[EXPERIMENT_DAMPING_COUNT]; /* alpha [1/s] */

typedef struct experiment_matrix {
  const experiment_body *bodies;
  int64_t body_count;
  bool loads[EXPERIMENT_LOAD_COUNT];
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  const double *dts; /* dt_count [s]; the forces are found at the first */
  int64_t dt_count;
  int64_t damping_count; /* the first of experiment_dampings */
  int64_t row_count;     /* of a run, about, beside the dense ones */
  double time;           /* [s] */
  double dense;          /* until when rows stand EXPERIMENT_DENSE_SECONDS apart, or a step [s] */
  int threads;
  bool (*progress)(void *context, double fraction); /* may be NULL; false stops */
  void *progress_context;
} experiment_matrix;

#define EXPERIMENT_DENSE_SECONDS 0.005

/* One recorded moment. */
typedef struct experiment_row {
  double time;  /* [s] */
  double total; /* energies [J] */
  double high;  /* of the rest-state I0 */
  double explicit_modes;
  double amplitude; /* of the loaded group, as a share of the body's length */
} experiment_row;

typedef struct experiment_run {
  const experiment_body *body;
  experiment_load load;
  double force; /* [N] */
  double alpha; /* [1/s] */
  double dt;    /* [s] */
  experiment_scheme scheme;
  double energy_known; /* most that `energy` had under this force, undamped [J] */
  thrum_status status; /* THRUM_OK, or what the step said that ended it */
  bool lost;           /* ended with EXPERIMENT_LOST times that energy */
  thrum_error stop;
  thrum_state_report report;
  double simulated;       /* [s] */
  double us_per_step;     /* processor time */
  double mean_iterations; /* a step */
  double energy_peak;     /* [J], of the rows */
  double energy_end;
  double high_end;
  double energy_change;  /* undamped and after the load: mean of the last tenth of the rows against
                            the first, relative; NaN elsewhere */
  double peak_amplitude; /* of the rows */
  int64_t row_count;
  experiment_row *rows;
} experiment_run;

/* How many runs a matrix holds. */
int64_t experiment_matrix_count(const experiment_matrix *matrix);

/* Finds for each body and load the force that bends the body as far as the list of loads says (with
 * `energy`, without damping), then runs the matrix: by body, load, damping, time step, scheme, the
 * last fastest. `runs` has room for experiment_matrix_count; free it with experiment_runs_free, on
 * failure too. A run that is lost is no failure. */
thrum_status experiment_matrix_run(const experiment_matrix *matrix, experiment_run *runs,
                                   thrum_error *error);
void experiment_runs_free(experiment_run *runs, int64_t count);

/* Whether a run was lost that should not be. */
bool experiment_runs_flagged(const experiment_run *runs, int64_t count);

#endif
