/* Solids: obstacles that are touched by their faces, edges and corners, and that may move along a
 * path (thrum/scene.h). Where one is follows from the time alone, so a snapshot holds nothing of
 * it.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_solid.h"

#include "scene/scene_fields.h"
#include "scene/scene_memory.h"
#include "scene/scene_pairs_room.h"
#include "scene/scene_solid_shape.h"

#include "core/base/def.h"
#include "core/base/intervals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"

#define REACH_MAX 1e30 /* how far it may be, as its vertices from its origin [m] */
#define ALIKE 0.9995   /* cosine of half the angle above which two rotations are mixed in a line */

/* --- where it is ------------------------------------------------------------------------------ */

/* The rotation a share of the way from a to b, both of length 1, about one axis (Shoemake 1985,
 * doi:10.1145/325165.325242). */
static void mix(const double a[4], const double b[4], double share, double out[4]) {
  double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  const double sign = cosine < 0.0 ? -1.0 : 1.0;
  double first = 1.0 - share, second = sign * share;
  cosine *= sign;
  if (cosine < ALIKE) {
    const double angle = acos(cosine), whole = sin(angle);
    first = sin((1.0 - share) * angle) / whole;
    second = sign * sin(share * angle) / whole;
  }
  for (int n = 0; n < 4; n++)
    out[n] = first * a[n] + second * b[n];
}

/* Position and rotation at a time: seven numbers. */
static void place_at(const scene_solid *solid, double time, double place[7]) {
  if (solid->path_count == 0) {
    for (int axis = 0; axis < 3; axis++)
      place[axis] = solid->position[axis] + time * solid->velocity[axis];
    memcpy(place + 3, solid->rotation, sizeof solid->rotation);
    return;
  }

  // the part of the path that holds the time; it rests before and after
  const int64_t from = thrum_interval_at(solid->times, solid->path_count, time);
  const int64_t to = from + 1 < solid->path_count ? from + 1 : from;
  const double length = solid->times[to] - solid->times[from];
  double share = length > 0.0 ? (time - solid->times[from]) / length : 0.0;
  share = fmin(fmax(share, 0.0), 1.0);
  const double *a = solid->places + 7 * from, *b = solid->places + 7 * to;
  for (int axis = 0; axis < 3; axis++)
    place[axis] = (1.0 - share) * a[axis] + share * b[axis];
  mix(a + 3, b + 3, share, place + 3);
}

static thrum_placement placement_at(const scene_solid *solid, double time) {
  double place[7];
  thrum_placement at = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  place_at(solid, time, place);
  memcpy(at.origin, place, sizeof at.origin);
  thrum_scene_axes(place + 3, at.axes, NULL);
  return at;
}

void scene_solids_move(thrum_scene *scene) {
  const double time = thrum_scene_time(scene);
  for (int32_t n = 0; n < scene->solid_count; n++) {
    scene_solid *solid = scene->solids + n;
    solid->moving = (thrum_contact_solid){.now = placement_at(solid, time),
                                          .next = placement_at(solid, time + scene->dt),
                                          .friction = solid->friction,
                                          .restitution = solid->restitution};
    const thrum_contact_member member = {.skin = solid->skin, .solid = &solid->moving};
    solid->bound = thrum_contact_member_bound(&member);
  }
}

/* --- adding ----------------------------------------------------------------------------------- */

/* Whether a place is finite, and near enough for finite distances to fourth powers. */
static bool is_near(const double place[3]) {
  return fabs(place[0]) <= REACH_MAX && fabs(place[1]) <= REACH_MAX && fabs(place[2]) <= REACH_MAX;
}

static thrum_status check_motion(const thrum_scene_solid_def *def, thrum_error *error) {
  double axes[9];
  if (!is_near(def->position) || !is_near(def->velocity))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the position or the velocity of a solid is not within 1e30 m or m/s");
  THRUM_TRY(thrum_scene_axes(def->rotation, axes, error));
  if (def->path_count < 0 || def->path_count > (INT64_C(1) << 24) ||
      (def->path_count > 0 && (def->path_times == NULL || def->path_places == NULL)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the path of a solid has 1 to 2^24 times, each with a place");

  // a path that jumps would throw what it touches
  for (int64_t n = 0; n < def->path_count; n++) {
    if (!isfinite(def->path_times[n]) || !is_near(def->path_places + 7 * n) ||
        !thrum_all_finite(def->path_places + 7 * n + 3, 4) ||
        (n > 0 && !(def->path_times[n] > def->path_times[n - 1])))
      return thrum_error_set(
          error, THRUM_BAD_VALUE,
          "place %lld of a solid's path is not within 1e30 m, or its time is not "
          "after the one before",
          (long long)n);
    THRUM_TRY(thrum_scene_axes(def->path_places + 7 * n + 3, axes, error));
  }
  return THRUM_OK;
}

static thrum_status check_def(const thrum_scene_solid_def *def, thrum_error *error) {
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_SOLID, def, error));
  if (def->friction > THRUM_CONTACT_STIFFNESS_MAX)
    return thrum_error_set_field(error, "friction", THRUM_BAD_VALUE, " is %g; it must be 0 to 1e30",
                                 def->friction);
  return check_motion(def, error);
}

/* Rotations of length 1. */
static void normalise(double rotation[4]) {
  double largest = 0.0, square = 0.0;
  for (int n = 0; n < 4; n++)
    largest = fmax(largest, fabs(rotation[n]));
  for (int n = 0; n < 4; n++) {
    rotation[n] /= largest;
    square += rotation[n] * rotation[n];
  }
  for (int n = 0; n < 4; n++)
    rotation[n] /= sqrt(square);
}

static thrum_status take_motion(const thrum_scene_solid_def *def, scene_solid *solid,
                                thrum_error *error) {
  memcpy(solid->position, def->position, sizeof solid->position);
  memcpy(solid->rotation, def->rotation, sizeof solid->rotation);
  memcpy(solid->velocity, def->velocity, sizeof solid->velocity);
  normalise(solid->rotation);
  solid->friction = def->friction;
  solid->restitution = def->restitution;
  solid->open = def->shape == THRUM_SOLID_HEIGHT_FIELD;
  if (def->path_count == 0)
    return THRUM_OK;
  const size_t count = (size_t)def->path_count;
  solid->times = malloc(count * sizeof *solid->times);
  solid->places = malloc(7 * count * sizeof *solid->places);
  if (solid->times == NULL || solid->places == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the path of a solid");
  memcpy(solid->times, def->path_times, count * sizeof *solid->times);
  memcpy(solid->places, def->path_places, 7 * count * sizeof *solid->places);
  for (size_t n = 0; n < count; n++)
    normalise(solid->places + 7 * n + 3);
  solid->path_count = def->path_count;
  return THRUM_OK;
}

static thrum_status make_skin(scene_solid *solid, thrum_error *error) {
  size_t size = 0;
  THRUM_TRY(thrum_skin_solid_size(solid->vertices, solid->vertex_count, solid->triangles,
                                  solid->triangle_count, &size, error));
  solid->memory = scene_aligned(size);
  if (solid->memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a solid of %zu bytes", size);
  return thrum_skin_solid_init(solid->memory, size, solid->vertices, solid->vertex_count,
                               solid->triangles, solid->triangle_count, &solid->skin, error);
}

static void free_solid(scene_solid *solid) {
  free(solid->vertices);
  free(solid->triangles);
  free(solid->times);
  free(solid->places);
  free(solid->memory);
}

thrum_status thrum_scene_add_solid(thrum_scene *scene, const thrum_scene_solid_def *def,
                                   int32_t *number, thrum_error *error) {
  thrum_scene_solid_def whole = thrum_default_scene_solid_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  scene_solid made = {0};
  THRUM_TRY(check_def(def, error));
  if (!scene_grow(&scene->solids, scene->solid_count + 1, sizeof *scene->solids))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a solid");
  thrum_status status = scene_solid_surface(def, &made, error);
  THRUM_THEN(status, take_motion(def, &made, error));
  THRUM_THEN(status, make_skin(&made, error));
  if (status < 0) {
    free_solid(&made);
    return status;
  }

  // bodies that could touch nothing before need a skin and a contact now
  scene->solids[scene->solid_count++] = made;
  status = scene_pairs_equip(scene, error);
  if (status < 0) {
    scene->solid_count--;
    free_solid(&made);
    scene_pairs_equip(scene, NULL);
    return status;
  }
  scene_solids_move(scene);
  scene->revision++;
  if (number != NULL)
    *number = scene->solid_count - 1;
  return THRUM_OK;
}

void scene_solids_free(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->solid_count; n++)
    free_solid(scene->solids + n);
  free(scene->solids);
}

int32_t thrum_scene_solid_count(const thrum_scene *scene) {
  return scene->solid_count;
}

thrum_status thrum_scene_solid_get(const thrum_scene *scene, int32_t number,
                                   thrum_scene_solid *solid, thrum_error *error) {
  if (number < 0 || number >= scene->solid_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no solid %d: the scene has %d",
                           (int)number, (int)scene->solid_count);
  const scene_solid *of = scene->solids + number;
  *solid = (thrum_scene_solid){.vertices = of->vertices,
                               .vertex_count = of->vertex_count,
                               .triangles = of->triangles,
                               .triangle_count = of->triangle_count,
                               .now = placement_at(of, thrum_scene_time(scene))};
  return THRUM_OK;
}
