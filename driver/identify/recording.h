/* A recorded motion: displacements of targets over time. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_RECORDING_H
#define THRUM_DRIVER_IDENTIFY_RECORDING_H

#include "driver/spec/load_spec.h"

#define RECORDING_COLUMNS_MAX 64

typedef struct recording_column {
  load_target target;
  int axis;
  char name[LOAD_TEXT_MAX + 8]; /* as the file has it */
} recording_column;

typedef struct recording {
  recording_column columns[RECORDING_COLUMNS_MAX];
  int64_t column_count;
  int64_t rows;
  double *times;  /* rows, ascending from 0 or later [s] */
  double *values; /* rows x column_count [m] */
} recording;

/* Reads the file; failures name its line. recording_free frees, whatever came back. */
thrum_status recording_read(const char *path, recording *found, thrum_error *error);
void recording_free(recording *found);

#endif
