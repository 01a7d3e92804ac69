/* Planes, spheres and boxes as signed distances (thrum/contact.h, docs/contact.md).
 *
 * A distance changes by no more than the point moves, which is what the broad phase relies on. A
 * room is six walls, each a plane, so that a point in its corner touches three.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "contact/contact_private.h"
#include "contact/obstacle_private.h"
#include "core/base/finite.h"

#define NEARLY 1e-6 /* by which the axes of an obstacle may miss to be orthonormal */

thrum_obstacle thrum_default_obstacle(void) {
  const thrum_obstacle obstacle = {.cookie = sizeof(thrum_obstacle),
                                   THRUM_OBSTACLE_FIELDS(THRUM_VALUE)};
  return obstacle;
}

static thrum_status refuse(thrum_error *error, int64_t index, const char *what) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "obstacle %lld: %s", (long long)index, what);
}

static bool in_range(double value, double most) {
  return value >= 0.0 && value <= most;
}

static bool orthonormal(const double a[9]) {
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++)
      if (!(fabs(thrum_dot3(a + 3 * i, a + 3 * j) - (i == j ? 1.0 : 0.0)) <= NEARLY))
        return false;
  return true;
}

static thrum_status check_shape(const thrum_obstacle *o, int64_t index, thrum_error *error) {
  // only the fields of its own shape count
  switch (o->shape) {
  case THRUM_OBSTACLE_PLANE: {
    const double square = thrum_dot3(o->normal, o->normal);
    return square > 0.0 && isfinite(square)
               ? THRUM_OK
               : refuse(error, index, "the plane's normal has no direction");
  }

  case THRUM_OBSTACLE_SPHERE:
    return o->radius > 0.0 && o->radius <= THRUM_PLACE_MAX
               ? THRUM_OK
               : refuse(error, index, "the sphere's radius must be above 0, up to 1e30 [m]");

  // a box has sides and a frame
  case THRUM_OBSTACLE_BOX:
    for (int axis = 0; axis < 3; axis++)
      if (!(o->half[axis] > 0.0 && o->half[axis] <= THRUM_PLACE_MAX))
        return refuse(error, index, "the box's half sides must be above 0, up to 1e30 [m]");
    return orthonormal(o->rotation) ? THRUM_OK
                                    : refuse(error, index, "the box's rotation is no rotation");
  }
  return refuse(error, index, "its shape is none of plane, sphere and box");
}

thrum_status thrum_obstacle_check(const thrum_obstacle *o, int64_t index, thrum_error *error) {
  if (o->cookie != sizeof *o)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "obstacle %lld was not made by thrum_default_obstacle",
                           (long long)index);
  if (!thrum_all_within(o->centre, 3, THRUM_PLACE_MAX) ||
      !thrum_all_within(o->velocity, 3, THRUM_PLACE_MAX))
    return refuse(error, index, "its centre or velocity is not within 1e30 m or m/s");
  if (!in_range(o->stiffness, THRUM_CONTACT_STIFFNESS_MAX) ||
      !in_range(o->damping, THRUM_CONTACT_STIFFNESS_MAX))
    return refuse(error, index, "stiffness and damping must be between 0 and 1e30");
  if (!in_range(o->restitution, 1.0))
    return refuse(error, index, "the restitution must be between 0 and 1");
  if (!in_range(o->friction, THRUM_CONTACT_STIFFNESS_MAX))
    return refuse(error, index, "the friction must be between 0 and 1e30");
  return check_shape(o, index, error);
}

int32_t thrum_obstacle_faces(const thrum_obstacle *obstacle) {
  return obstacle->shape == THRUM_OBSTACLE_BOX && obstacle->inside ? 6 : 1;
}

/* normal = along / length(along), or the z axis where that vanishes; returns the length. */
static double direct(const double along[3], double normal[3]) {
  const double length = sqrt(thrum_dot3(along, along));
  for (int axis = 0; axis < 3; axis++)
    normal[axis] = length > 0.0 ? along[axis] / length : (axis == 2 ? 1.0 : 0.0);
  return length;
}

/* Gap of a solid box, from the point in the box's axes. */
static double box_gap(const double half[3], const double at[3], double normal[3]) {
  double out[3], nearest = -INFINITY;
  int face = 0;
  bool outside = false;

  // how far the point is beyond each pair of faces
  for (int axis = 0; axis < 3; axis++) {
    const double beyond = fabs(at[axis]) - half[axis];
    out[axis] = beyond > 0.0 ? copysign(beyond, at[axis]) : 0.0;
    outside = outside || beyond > 0.0;
    if (beyond > nearest) {
      nearest = beyond;
      face = axis;
    }
  }

  // outside, to the nearest point of the box; inside, through the nearest face
  if (outside)
    return direct(out, normal);
  for (int axis = 0; axis < 3; axis++)
    normal[axis] = axis == face ? copysign(1.0, at[axis]) : 0.0;
  return nearest;
}

double thrum_obstacle_face_gap(const thrum_obstacle *o, int32_t face, const double x[3],
                               double normal[3]) {
  const double from[3] = {x[0] - o->centre[0], x[1] - o->centre[1], x[2] - o->centre[2]};
  if (o->shape == THRUM_OBSTACLE_PLANE) {
    direct(o->normal, normal);
    return thrum_dot3(normal, from);
  }
  if (o->shape == THRUM_OBSTACLE_SPHERE) {
    const double length = direct(from, normal);
    for (int axis = 0; axis < 3 && o->inside; axis++)
      normal[axis] = -normal[axis];
    return o->inside ? o->radius - length : length - o->radius;
  }

  // a box is measured in its own axes
  double at[3], way[3] = {0.0, 0.0, 0.0}, gap;
  thrum_apply3_transposed(o->rotation, from, at);
  if (o->inside) {
    const int axis = face / 2;
    way[axis] = face % 2 ? -1.0 : 1.0;
    gap = o->half[axis] + way[axis] * at[axis];
  } else {
    gap = box_gap(o->half, at, way);
  }
  thrum_apply3(o->rotation, way, normal);
  return gap;
}

double thrum_obstacle_gap(const thrum_obstacle *obstacle, const double x[3], double normal[3]) {
  double least = INFINITY;
  for (int32_t face = 0; face < thrum_obstacle_faces(obstacle); face++) {
    double way[3];
    const double gap = thrum_obstacle_face_gap(obstacle, face, x, way);
    if (gap < least) {
      least = gap;
      memcpy(normal, way, sizeof way);
    }
  }
  return least;
}
