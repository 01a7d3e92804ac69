/* Results as rows, one for each run: JSON objects whose keys are the columns of the tables. Who
 * calls deletes them. A number that is not finite is null. The long lists are written at once, as
 * comma-separated values. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_TABLES_H
#define THRUM_VALIDATION_EXPERIMENTS_TABLES_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "validation/experiments/extremes.h"
#include "validation/experiments/linear_free_vibration.h"
#include "validation/experiments/long_run.h"
#include "validation/experiments/matrix.h"
#include "validation/experiments/sweep.h"

cJSON *experiment_matrix_rows(const experiment_run *runs, int64_t count);
/* The recorded rows of all runs. */
void experiment_curves_csv(FILE *stream, const experiment_run *runs, int64_t count);

/* The runs that are done; and the means of all of their windows. */
cJSON *experiment_long_rows(const experiment_long *runs);
void experiment_windows_csv(FILE *stream, const experiment_long *runs);
/* Marks the runs that the two tables of an earlier call hold to their end as done, and fills their
 * cases and results. */
void experiment_tables_read_long(const char *table, const char *windows, experiment_long *runs);

cJSON *experiment_sweep_rows(const experiment_sweep *sweep);

cJSON *experiment_extremes_rows(const experiment_extremes *extremes);
cJSON *experiment_units_rows(const experiment_extremes *extremes);

/* One row for each body; and the curves, one row for each point. */
cJSON *experiment_linear_rows(const experiment_linear *linear);
void experiment_linear_curves_csv(FILE *stream, const experiment_linear *linear);

#endif
