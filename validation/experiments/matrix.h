/* The matrix of experiments: bodies x loads x damping x integrators.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_MATRIX_H
#define THRUM_VALIDATION_EXPERIMENTS_MATRIX_H

#include "validation/experiments/experiment_body.h"
#include "platform/thread_pool.h"

/* The loads of the thesis. X(name, shape, until [s], frequency [Hz], amplitude to reach) */
#define STUDY_LOAD_LIST(X)                                                                         \
  X(impulse, THRUM_LOAD_CONSTANT, 0.003, 0, 0.05)                                                  \
  X(square, THRUM_LOAD_CONSTANT, 0.3, 0, 0.05)                                                     \
  X(sine, THRUM_LOAD_SINE, INFINITY, 1, 0.1)

typedef enum study_load {
#define X(name, shape, until, frequency, amplitude) STUDY_LOAD_##name,
  STUDY_LOAD_LIST(X)
#undef X
      STUDY_LOAD_COUNT
} study_load;

extern const char *const study_load_names[STUDY_LOAD_COUNT];

#define STUDY_DAMPING_COUNT 2
extern const double study_dampings[STUDY_DAMPING_COUNT]; /* alpha [1/s] */

typedef struct study_matrix {
  const study_body *bodies;
  int64_t body_count;
  bool loads[STUDY_LOAD_COUNT];
  bool integrators[STUDY_INTEGRATOR_COUNT];
  double dt;
  int64_t steps;
  int threads;
  bool (*progress)(void *context, double fraction); /* may be NULL; false stops */
  void *progress_context;
} study_matrix;

/* One recorded moment. */
typedef struct study_row {
  double time;  /* [s] */
  double total; /* energies [J] */
  double high;  /* of the rest-state I0 */
  double explicit_modes;
  double amplitude; /* of the loaded group, as a share of the body's length */
} study_row;

typedef struct study_run {
  const study_body *body;
  study_load load;
  double force; /* [N] */
  double alpha; /* [1/s] */
  study_integrator integrator;
  thrum_status status; /* THRUM_OK, or why it ended before its time */
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
  study_row *rows;
} study_run;

/* How many runs a matrix holds. */
int64_t study_matrix_count(const study_matrix *matrix);

/* Finds for each body and load the force that bends the body as far as the list of loads says (with
 * `energy`, without damping), then runs the matrix: by body, load, damping, integrator, the last
 * fastest. `runs` has room for study_matrix_count; free it with study_runs_free, on failure too.
 * A run that ends early is no failure. */
thrum_status study_matrix_run(const study_matrix *matrix, study_run *runs, thrum_error *error);
void study_runs_free(study_run *runs, int64_t count);

#endif
