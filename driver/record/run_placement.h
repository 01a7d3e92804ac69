/* Where the body of a run stands in its scene. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_PLACEMENT_H
#define THRUM_DRIVER_RECORD_RUN_PLACEMENT_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "thrum/status.h"

#define RUN_PLACEMENT_COLUMNS 7 /* position [m] and rotation w, x, y, z of a row */

/* x = position + R scale (X + U q), R of the rotation. */
typedef struct run_placement {
  bool placed; /* false: a run of one model, x = X + U q */
  double position[3];
  double rotation[4]; /* w, x, y, z, of length 1 */
  double scale;
  double colour[3]; /* red, green, blue, 0 to 1, as of sRGB */
} run_placement;

/* Reads the placement from a run.json (`name`: in messages); untouched where it has none, its
 * colour where it says none. */
thrum_status run_placement_read(const char *name, const cJSON *object, run_placement *place,
                                thrum_error *error);

/* The place of a row, from a turn, a scale and a shift as column-major 4 x 4. */
void run_placement_of(const double matrix[16], double row[RUN_PLACEMENT_COLUMNS]);

/* rows x RUN_PLACEMENT_COLUMNS, malloc, the caller frees; of rotations q and -q those that are
 * nearer to the row before. */
thrum_status run_placements_read(const char *path, int64_t rows, double **places,
                                 thrum_error *error);

/* The matrix, in the same form, from X + U q to the world, with the body where it is in a row;
 * NULL: where it stands at first. */
void run_placement_matrix(const run_placement *place, const double *row, double matrix[16]);

/* out = the matrix times a point, in place if the two are one. */
void run_placement_point(const double matrix[16], const double in[3], double out[3]);

#endif
