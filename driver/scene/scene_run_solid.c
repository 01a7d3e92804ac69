/* Obstacles of a scene file that are touched by their faces: their surfaces, places and paths.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_solid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "driver/scene/scene_run_refuse.h"
#include "mesh/formats/surface_read.h"
#include "platform/allocate.h"

#define SHORT_TURN 120.0 /* degrees of a part of a path: below 180 the direction is clear */
#define PARALLEL 1e-9    /* sine of the angle up to which two axes are one */
#define PARTS_MAX 1e6    /* of a path */

/* The data that a solid's def points to while it is added. */
typedef struct solid_parts {
  thrum_surface_mesh surface;
  double *heights, *times, *places;
} solid_parts;

static void free_parts(solid_parts *parts) {
  thrum_surface_mesh_free(&parts->surface);
  free(parts->heights);
  free(parts->times);
  free(parts->places);
}

/* Rows of numbers into the def; all rows are as long as the first. */
static thrum_status read_heights(const scene_run *run, const scene_obstacle_spec *spec,
                                 solid_parts *parts, thrum_scene_solid_def *def,
                                 thrum_error *error) {
  const json_node *nodes = run->spec.file.document.nodes;
  int64_t count = 0;
  for (int64_t row = spec->heights->first; row >= 0; row = nodes[row].next)
    for (int64_t at = nodes[row].first; nodes[row].type == JSON_ARRAY && at >= 0;
         at = nodes[at].next)
      count++;
  THRUM_TRY(thrum_reserve(&parts->heights, count + 1, sizeof *parts->heights, "the scene", error));

  count = 0;
  for (int64_t row = spec->heights->first; row >= 0; row = nodes[row].next, def->rows++) {
    int64_t columns = 0;
    for (int64_t at = nodes[row].type == JSON_ARRAY ? nodes[row].first : -1; at >= 0;
         at = nodes[at].next, columns++) {
      if (nodes[at].type != JSON_NUMBER)
        return config_record_refuse(&run->spec.file, &spec->at, "heights", THRUM_BAD_VALUE,
                                    "holds something that is no number");
      parts->heights[count++] = strtod(nodes[at].text, NULL);
    }
    if (def->rows > 0 && columns != def->columns)
      return config_record_refuse(&run->spec.file, &spec->at, "heights", THRUM_BAD_VALUE,
                                  "row %lld has %lld numbers, the first %lld",
                                  (long long)def->rows + 1, (long long)columns,
                                  (long long)def->columns);
    def->columns = columns;
  }
  def->heights = parts->heights;
  return THRUM_OK;
}

static thrum_status read_surface(const scene_run *run, const scene_obstacle_spec *spec,
                                 solid_parts *parts, thrum_scene_solid_def *def) {
  thrum_error detail = {0};
  const thrum_status status =
      thrum_surface_mesh_read(spec->path, spec->scale, &parts->surface, &detail);
  THRUM_TRY(scene_run_pass(run, &spec->at, "file", status, &detail));
  def->vertices = parts->surface.vertices;
  def->vertex_count = parts->surface.vertex_count;
  def->triangles = parts->surface.triangles;
  def->triangle_count = parts->surface.triangle_count;
  return THRUM_OK;
}

/* The angle from one waypoint to the next about one axis [degrees], which `axis` gets, with `from`
 * the angle that it starts at; 0 where their rotations have no axis in common. */
static double turn_between(const scene_waypoint_spec *a, const scene_waypoint_spec *b,
                           double axis[3], double *from) {
  const bool turns = b->angle != 0.0;
  memcpy(axis, turns ? b->axis : a->axis, sizeof a->axis);
  *from = a->angle;
  if (isnan(a->angle) || isnan(b->angle) || a->angle == 0.0 || !turns)
    return isnan(a->angle) || isnan(b->angle) ? 0.0 : b->angle - a->angle;

  // two rotations about one axis, which may be named from either end
  double across[3];
  thrum_cross3(a->axis, b->axis, across);
  const double size = thrum_dot3(a->axis, a->axis) * thrum_dot3(b->axis, b->axis);
  if (thrum_dot3(across, across) > PARALLEL * PARALLEL * size)
    return 0.0;
  *from = thrum_dot3(a->axis, b->axis) < 0.0 ? -a->angle : a->angle;
  return b->angle - *from;
}

/* Parts of the way from a waypoint to the next: more than one where it turns so far that the short
 * way between its ends would be another one. */
static double parts_between(const scene_waypoint_spec *a, const scene_waypoint_spec *b) {
  double axis[3], from;
  return fmax(ceil(fabs(turn_between(a, b, axis, &from)) / SHORT_TURN), 1.0);
}

/* The time and the place a share of the way from waypoint a to b. */
static void fill_between(const scene_waypoint_spec *a, const scene_waypoint_spec *b, double share,
                         double *time, double place[7]) {
  double axis[3], from;
  const double turn = turn_between(a, b, axis, &from);
  *time = a->time + share * (b->time - a->time);
  for (int n = 0; n < 3; n++)
    place[n] = a->centre[n] + share * (b->centre[n] - a->centre[n]);
  scene_axis_angle(axis, from + share * turn, place + 3);
}

thrum_status scene_run_way(const scene_run *run, const scene_obstacle_spec *spec, double **times,
                           double **places, int64_t *count, thrum_error *error) {
  const scene_waypoint_spec *way = spec->way.items;
  double sum = 1.0, *at = NULL, *where = NULL;
  int64_t made = 0;

  // a waypoint for each part
  for (int64_t n = 1; n < spec->way.count; n++)
    sum += parts_between(way + n - 1, way + n);
  if (!(sum <= PARTS_MAX))
    return config_record_refuse(&run->spec.file, &spec->at, "path", THRUM_BAD_VALUE,
                                "turns too often: it would have %.3g parts, of at most %g", sum,
                                PARTS_MAX);
  THRUM_TRY(thrum_reserve(&at, (int64_t)sum, sizeof *at, "the scene", error));
  const thrum_status status =
      thrum_reserve(&where, 7 * (int64_t)sum, sizeof *where, "the scene", error);
  if (status < 0) {
    free(at);
    return status;
  }

  // each waypoint as it is, and before it what lies on the way to it
  for (int64_t n = 0; n < spec->way.count; n++) {
    const double pieces = n > 0 ? parts_between(way + n - 1, way + n) : 1.0;
    for (double k = 1.0; k < pieces; k++, made++)
      fill_between(way + n - 1, way + n, k / pieces, at + made, where + 7 * made);
    at[made] = way[n].time;
    memcpy(where + 7 * made, way[n].centre, sizeof way[n].centre);
    memcpy(where + 7 * made + 3, way[n].rotation, sizeof way[n].rotation);
    made++;
  }
  *times = at;
  *places = where;
  *count = made;
  return THRUM_OK;
}

static thrum_status read_path(const scene_run *run, const scene_obstacle_spec *spec,
                              solid_parts *parts, thrum_scene_solid_def *def, thrum_error *error) {
  if (spec->way.count == 0)
    return THRUM_OK;
  THRUM_TRY(scene_run_way(run, spec, &parts->times, &parts->places, &def->path_count, error));
  def->path_times = parts->times;
  def->path_places = parts->places;
  return THRUM_OK;
}

/* The def of an obstacle, but for what it points to. */
static void fill_def(const scene_obstacle_spec *spec, thrum_scene_solid_def *def) {
  static const thrum_solid_shape shapes[] = {
      [SCENE_BOX] = THRUM_SOLID_BOX,         [SCENE_CYLINDER] = THRUM_SOLID_CYLINDER,
      [SCENE_CAPSULE] = THRUM_SOLID_CAPSULE, [SCENE_HEIGHT_FIELD] = THRUM_SOLID_HEIGHT_FIELD,
      [SCENE_MESH] = THRUM_SOLID_MESH,
  };

  // each shape reads its own sizes and leaves the others alone
  *def = thrum_default_scene_solid_def();
  def->shape = shapes[spec->shape];
  def->radius = spec->radius;
  if (spec->shape == SCENE_CYLINDER || spec->shape == SCENE_CAPSULE)
    def->height = spec->height;
  if (spec->shape == SCENE_HEIGHT_FIELD)
    def->spacing[0] = def->spacing[1] = spec->spacing;
  THRUM_TOUCH_FIELDS(SCENE_COPY)

  // the def has half the sizes
  for (int axis = 0; axis < 3; axis++) {
    if (spec->shape == SCENE_BOX)
      def->half[axis] = 0.5 * spec->size[axis];
    def->position[axis] = spec->centre[axis];
    def->velocity[axis] = spec->velocity[axis];
  }
  memcpy(def->rotation, spec->rotation, sizeof def->rotation);
}

thrum_status scene_run_add_solid(const scene_run *run, const scene_obstacle_spec *spec,
                                 thrum_scene *scene) {
  thrum_scene_solid_def def;
  solid_parts parts = {0};
  thrum_error detail = {0};
  thrum_status status = THRUM_OK;
  fill_def(spec, &def);
  if (spec->shape == SCENE_HEIGHT_FIELD)
    status = read_heights(run, spec, &parts, &def, run->spec.file.error);
  if (spec->shape == SCENE_MESH)
    status = read_surface(run, spec, &parts, &def);
  THRUM_THEN(status, read_path(run, spec, &parts, &def, run->spec.file.error));
  if (status >= 0) {
    status = thrum_scene_add_solid(scene, &def, NULL, &detail);
    status = scene_run_pass(run, &spec->at, NULL, status, &detail);
  }
  free_parts(&parts);
  return status;
}

int32_t scene_run_obstacle_index(const scene_run *run, bool solid, int32_t number) {
  for (int32_t n = 0; n < run->spec.obstacles.count; n++)
    if (scene_obstacle_is_solid(&scene_obstacles(&run->spec)[n]) == solid && number-- == 0)
      return n;
  return -1;
}
