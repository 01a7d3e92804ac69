/* Placement of a body in the world, and vectors between world and body axes.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_placement.h"

#include "core/base/finite.h"

#include <math.h>
#include <string.h>

thrum_status thrum_scene_axes(const double rotation[4], double axes[9], thrum_error *error) {
  double square = 0;
  for (int n = 0; n < 4; n++)
    square += rotation[n] * rotation[n];
  if (!isnormal(square))
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "a rotation must be four finite numbers w, x, y, z that are not all zero");

  // the length is divided out, so any multiple of a quaternion is the same rotation
  const double length = sqrt(square);
  const double w = rotation[0] / length, x = rotation[1] / length, y = rotation[2] / length,
               z = rotation[3] / length;

  // columns are the axes of the body in the world
  const double turn[9] = {
      1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
      2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
      2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  memcpy(axes, turn, sizeof turn);
  return THRUM_OK;
}

thrum_status scene_placement_make(const double position[3], const double rotation[4],
                                  thrum_placement *placement, thrum_error *error) {
  if (!thrum_all_within(position, 3, THRUM_PLACE_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE, "a position is not within 1e30 m");
  THRUM_TRY(thrum_scene_axes(rotation, placement->axes, error));
  memcpy(placement->origin, position, sizeof placement->origin);
  return THRUM_OK;
}

void scene_to_world(const thrum_placement *placement, const double in_body[3], double out[3]) {
  const double *r = placement->axes;
  for (int n = 0; n < 3; n++)
    out[n] = r[3 * n] * in_body[0] + r[3 * n + 1] * in_body[1] + r[3 * n + 2] * in_body[2];
}

void scene_to_body(const thrum_placement *placement, const double in_world[3], double out[3]) {
  const double *r = placement->axes;
  for (int n = 0; n < 3; n++)
    out[n] = r[n] * in_world[0] + r[3 + n] * in_world[1] + r[6 + n] * in_world[2];
}

thrum_status thrum_scene_to_body(const double rotation[4], const double in_world[3],
                                 double in_body[3], thrum_error *error) {
  const double vector[3] = {in_world[0], in_world[1], in_world[2]};
  thrum_placement placement;
  THRUM_TRY(thrum_scene_axes(rotation, placement.axes, error));
  scene_to_body(&placement, vector, in_body);
  return THRUM_OK;
}
