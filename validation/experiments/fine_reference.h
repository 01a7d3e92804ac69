/* A fine run that others are compared with, and how far it is off itself.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_FINE_REFERENCE_H
#define THRUM_VALIDATION_EXPERIMENTS_FINE_REFERENCE_H

#include "validation/experiments/experiment_body.h"

/* q after an impulse, stepped by `energy` without damping, at whole multiples of `spacing`. */
typedef struct experiment_reference {
  double spacing; /* [s] */
  int64_t count;  /* moments, the one at 0 included */
  double *q;      /* count x rank */
  double error;   /* its own: a third of what twice the step differs by, as errors below */
} experiment_reference;

/* Makes it with EXPERIMENT_REFERENCE_FINER steps in each spacing. Free with
 * experiment_reference_free, on failure too. */
#define EXPERIMENT_REFERENCE_FINER 32
thrum_status experiment_reference_make(const experiment_body *body, double impulse, double spacing,
                                       int64_t count, experiment_reference *reference,
                                       thrum_error *error);
void experiment_reference_free(experiment_reference *reference);

/* Sums for the error of a run: the root mean square of q - q_ref over that of q_ref, in the norm of
 * the mass. Zero to begin with. */
typedef struct experiment_deviation {
  double difference, size;
} experiment_deviation;

/* Adds the moment with this index, which the reference has. */
void experiment_deviation_add(experiment_deviation *sums, const experiment_reference *reference,
                              int64_t rank, int64_t index, const double *q);
double experiment_deviation_value(const experiment_deviation *sums);

#endif
