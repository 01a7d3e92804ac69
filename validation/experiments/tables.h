/* Results as comma-separated tables, one row for each run. A number that is not finite is left
 * empty. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_TABLES_H
#define THRUM_VALIDATION_EXPERIMENTS_TABLES_H

#include <stdio.h>

#include "validation/experiments/extremes.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/matrix.h"
#include "validation/experiments/sweep.h"

void experiment_matrix_csv(FILE *stream, const experiment_run *runs, int64_t count);

/* The recorded rows of all runs. */
void experiment_curves_csv(FILE *stream, const experiment_run *runs, int64_t count);

/* The runs that are done; and the means of all of their windows. */
void experiment_long_csv(FILE *stream, const experiment_long *runs);
void experiment_windows_csv(FILE *stream, const experiment_long *runs);

/* Marks the runs that the two tables of an earlier call hold to their end as done, and fills their
 * cases and results. */
void experiment_tables_read_long(const char *table, const char *windows, experiment_long *runs);

void experiment_sweep_csv(FILE *stream, const experiment_sweep *sweep);

void experiment_extremes_csv(FILE *stream, const experiment_extremes *extremes);
void experiment_units_csv(FILE *stream, const experiment_extremes *extremes);

/* One row for each body; and the curves, one row for each point. */
void experiment_linear_csv(FILE *stream, const experiment_linear *linear);
void experiment_linear_curves_csv(FILE *stream, const experiment_linear *linear);

#endif
