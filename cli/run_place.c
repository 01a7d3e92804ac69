/* Where a run's body stands: what run.json says under "placement", and way.npy.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/run_place.h"
#include "precompute/npz.h"
#include "scene/scene.h"

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

thrum_status cli_run_place_read(const char *name, const cJSON *object, cli_run_place *place,
                                thrum_error *error) {
  const cJSON *given = cJSON_GetObjectItemCaseSensitive(object, "placement");
  cli_run_place read = {.placed = true};
  if (given == NULL)
    return THRUM_OK;
  const cJSON *scale = cJSON_GetObjectItemCaseSensitive(given, "scale");
  double length = 0;
  bool good = cJSON_IsNumber(scale) && scale->valuedouble > 0 && isfinite(scale->valuedouble) &&
              take_numbers(given, "position_m", 3, read.position) &&
              take_numbers(given, "rotation_wxyz", 4, read.rotation);
  for (int n = 0; n < 4; n++)
    length = hypot(length, read.rotation[n]);
  if (!good || !isnormal(length))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: placement wants position_m, rotation_wxyz and scale", name);
  for (int n = 0; n < 4; n++)
    read.rotation[n] /= length;
  read.scale = scale->valuedouble;
  *place = read;
  return THRUM_OK;
}

thrum_status cli_run_way_read(const char *path, int64_t rows, double **way, thrum_error *error) {
  int64_t found = 0, columns = 0;
  double *values = NULL;
  const thrum_status status = thrum_npy_read_f8(path, &values, &found, &columns, error);
  if (status < 0)
    return status;
  bool good = found == rows && columns == 3;
  for (int64_t n = 0; good && n < 3 * rows; n++)
    good = isfinite(values[n]);
  if (!good) {
    free(values);
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.300s: not three finite numbers for each row of q.npy", path);
  }
  *way = values;
  return THRUM_OK;
}

void cli_run_place_point(const cli_run_place *place, const double *way, const double in[3],
                         double out[3]) {
  if (!place->placed) {
    memmove(out, in, 3 * sizeof *out);
    return;
  }
  // from the body to the world is what the opposite turn does from the world to the body
  const double *r = place->rotation;
  const double back[4] = {r[0], -r[1], -r[2], -r[3]};
  thrum_scene_to_body(back, in, out, NULL);
  for (int axis = 0; axis < 3; axis++)
    out[axis] = place->position[axis] + place->scale * out[axis] + (way != NULL ? way[axis] : 0);
}
