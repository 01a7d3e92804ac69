/* Where a run's body stands: what run.json says under "placement", and places.npy.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_placement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/npy_file.h"
#include "thrum/scene.h"

static bool take_numbers(const cJSON *object, const char *key, int count, double *numbers) {
  const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, key);
  if (cJSON_GetArraySize(list) != count)
    return false;
  for (int n = 0; n < count; n++) {
    const cJSON *item = cJSON_GetArrayItem(list, n);
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
      return false;
    numbers[n] = item->valuedouble;
  }
  return true;
}

thrum_status run_placement_read(const char *name, const cJSON *object, run_placement *place,
                                thrum_error *error) {
  const cJSON *given = cJSON_GetObjectItemCaseSensitive(object, "placement");
  if (given == NULL)
    return THRUM_OK;
  run_placement read = *place;
  read.placed = true;

  // a scale of zero or a quaternion of no length would place nothing
  const cJSON *scale = cJSON_GetObjectItemCaseSensitive(given, "scale");
  double length = 0;
  bool good = cJSON_IsNumber(scale) && scale->valuedouble > 0 && isfinite(scale->valuedouble) &&
              take_numbers(given, "position_m", 3, read.position) &&
              take_numbers(given, "rotation_wxyz", 4, read.rotation);

  // runs of earlier versions have no colour
  if (cJSON_HasObjectItem(given, "colour"))
    good = good && take_numbers(given, "colour", 3, read.colour);

  for (int n = 0; n < 4; n++)
    length = hypot(length, read.rotation[n]);

  // the quaternion is made of unit length
  if (!good || !isnormal(length))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: placement wants position_m, rotation_wxyz, scale and, where it "
                           "has one, colour as three numbers",
                           name);
  for (int n = 0; n < 4; n++)
    read.rotation[n] /= length;
  read.scale = scale->valuedouble;

  *place = read;
  return THRUM_OK;
}

void run_placement_of(const double matrix[16], double row[RUN_PLACEMENT_COLUMNS]) {
  double r[3][3], scale = 0;

  // the columns of the matrix have the scale as their length
  for (int axis = 0; axis < 3; axis++)
    scale = hypot(scale, matrix[axis]);
  for (int n = 0; n < 9; n++)
    r[n % 3][n / 3] = matrix[4 * (n / 3) + n % 3] / scale;

  // 4 q q^T of the quaternion q; the column of its largest component is the one to trust
  const double four[4][4] = {
      {1 + r[0][0] + r[1][1] + r[2][2], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]},
      {r[2][1] - r[1][2], 1 + r[0][0] - r[1][1] - r[2][2], r[1][0] + r[0][1], r[0][2] + r[2][0]},
      {r[0][2] - r[2][0], r[1][0] + r[0][1], 1 - r[0][0] + r[1][1] - r[2][2], r[2][1] + r[1][2]},
      {r[1][0] - r[0][1], r[0][2] + r[2][0], r[2][1] + r[1][2], 1 - r[0][0] - r[1][1] + r[2][2]}};

  int most = 0;
  for (int n = 1; n < 4; n++)
    most = four[n][n] > four[most][most] ? n : most;

  // position first, then the quaternion
  memcpy(row, matrix + 12, 3 * sizeof *row);
  for (int n = 0; n < 4; n++)
    row[3 + n] = four[most][n] / (2 * sqrt(four[most][most]));
}

/* Is the row one, its rotation of length 1? */
static bool is_place(const double *row) {
  double length = 0;
  for (int n = 0; n < 3; n++)
    length += 0 * row[n];
  for (int n = 3; n < RUN_PLACEMENT_COLUMNS; n++)
    length = hypot(length, row[n]);
  return fabs(length - 1) < 1e-6;
}

thrum_status run_placements_read(const char *path, int64_t rows, double **places,
                                 thrum_error *error) {
  int64_t found = 0, columns = 0;
  double *values = NULL;
  THRUM_TRY(thrum_npy_read_f8(path, &values, &found, &columns, error));

  // each row is a place, and the quaternion turns the short way from the row before
  bool good = found == rows && columns == RUN_PLACEMENT_COLUMNS;
  for (int64_t row = 0; good && row < rows; row++) {
    double *now = values + RUN_PLACEMENT_COLUMNS * row, along = 0;
    good = is_place(now);
    for (int n = 3; row > 0 && n < RUN_PLACEMENT_COLUMNS; n++)
      along += now[n] * now[n - RUN_PLACEMENT_COLUMNS];
    for (int n = 3; along < 0 && n < RUN_PLACEMENT_COLUMNS; n++)
      now[n] = -now[n];
  }

  if (!good) {
    free(values);
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.300s: not a position and a rotation for each row of q.npy", path);
  }
  *places = values;
  return THRUM_OK;
}

void run_placement_matrix(const run_placement *place, const double *row, double matrix[16]) {
  static const double unit[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  memcpy(matrix, unit, sizeof unit);
  if (!place->placed)
    return;
  double axes[9];
  thrum_scene_axes(row != NULL ? row + 3 : place->rotation, axes, NULL);
  for (int n = 0; n < 9; n++)
    matrix[4 * (n % 3) + n / 3] = place->scale * axes[n];
  memcpy(matrix + 12, row != NULL ? row : place->position, 3 * sizeof *matrix);
}

void run_placement_point(const double matrix[16], const double in[3], double out[3]) {
  const double x = in[0], y = in[1], z = in[2];
  for (int axis = 0; axis < 3; axis++)
    out[axis] = matrix[axis] * x + matrix[4 + axis] * y + matrix[8 + axis] * z + matrix[12 + axis];
}
