/* The long run: millions of undamped steps after an impulse, and what becomes of the energy.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_LONG_RUN_H
#define THRUM_VALIDATION_EXPERIMENTS_LONG_RUN_H

#include <stdatomic.h>

#include "platform/thread_pool.h"
#include "validation/experiments/experiment_body.h"
#include "validation/experiments/scheme.h"

#define EXPERIMENT_WINDOW_SECONDS 35.0

typedef struct experiment_long_case {
  const experiment_body *body;
  experiment_scheme scheme;
  double amplitude; /* of the swing, as a share of the body's length */
  double impulse;   /* [N s], of experiment_impulse */
  double reached;
  double dt;
  int64_t steps;
} experiment_long_case;

typedef struct experiment_long_result {
  thrum_status status; /* THRUM_OK, or what the step said that ended it */
  bool lost;           /* ended with EXPERIMENT_LOST times the energy that the impulse gave */
  thrum_error stop;
  thrum_state_report report;
  double energy;        /* that the impulse gave [J] */
  double us_per_step;   /* processor time, energies left out */
  int64_t window_count; /* whole windows of 35 s */
  double *total;        /* window_count: mean energies [J] */
  double *high;
  double total_change; /* last window against the first, relative; NaN with fewer than two */
  double high_change;
  double total_worst;      /* the window furthest from the first */
  double high_slope;       /* least squares over the windows, relative to their mean [1/s] */
  double high_slope_error; /* its standard error, if the windows were independent */
  double high_slope_error_correlated; /* and as they follow each other */
} experiment_long_result;

/* Frees `total` and `high`. */
void experiment_long_result_free(experiment_long_result *result);

/* The long runs: each body with each scheme at each amplitude. */
typedef struct experiment_long {
  const experiment_body *bodies;
  int64_t body_count;
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  const double *amplitudes; /* of the swing, as shares of the body's length */
  int64_t amplitude_count;
  double dt; /* [s] */
  int64_t steps;
  int threads;

  /* Called after each run, when its result is there; may be NULL; false stops. */
  bool (*progress)(void *context, double fraction);
  void *progress_context;

  /* Filled by experiment_long_plan. */
  int64_t count;
  experiment_long_case *cases; /* count, by body, amplitude, scheme, the last fastest */
  experiment_long_result *results;
  atomic_bool *done; /* whether the result is there; what is done already is not run */
} experiment_long;

/* Makes the cases from the members above them, none of them done. Free with experiment_long_free,
 * on failure too. */
thrum_status experiment_long_plan(experiment_long *runs, thrum_error *error);

/* Runs the cases that are not done. A step that cannot be solved is in the status of its result and
 * is no failure. */
thrum_status experiment_long_run(experiment_long *runs, thrum_error *error);
void experiment_long_free(experiment_long *runs);

/* Whether a run was lost that should not be. */
bool experiment_long_flagged(const experiment_long *runs);

/* Whether the trend of the high modes is within two standard errors of none, correlated ones: the
 * modes trade energy for thousands of seconds, so neighbouring windows are far from independent. */
bool experiment_long_steady(const experiment_long_result *result);

/* A least-squares slope and its standard error. */
typedef struct experiment_trend {
  double slope;
  double error;            /* from residuals that are taken as independent */
  double error_correlated; /* from residuals of which each follows the one before with the measured
                              correlation rho: n (1 - rho)/(1 + rho) count instead of n; infinite
                              where that leaves two or fewer (Santer et al. 2000,
                              doi:10.1029/1999JD901105) */
} experiment_trend;

/* The trend of `count` values at 0, spacing, 2 spacing and so on; NaN below three values. */
experiment_trend experiment_slope(const double *values, int64_t count, double spacing);

#endif
