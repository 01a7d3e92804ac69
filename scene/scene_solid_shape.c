/* Surfaces of solids: boxes, cylinders, capsules and height fields as triangles, counter-clockwise
 * from outside. The ranges of their numbers are those of the fields (scene_fields.c), which are
 * checked before. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_solid_shape.h"

#include "core/base/pi.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRID_MAX (1 << 15)
#define SEGMENTS_MAX 1024

static thrum_status refuse(thrum_error *error, const char *what) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "a solid's %s", what);
}

/* Room for the surface. */
static thrum_status make_room(scene_solid *solid, int64_t vertices, int64_t triangles,
                              thrum_error *error) {
  solid->vertices = malloc(3 * (size_t)vertices * sizeof *solid->vertices);
  solid->triangles = malloc(3 * (size_t)triangles * sizeof *solid->triangles);
  if (solid->vertices == NULL || solid->triangles == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface of a solid");
  solid->vertex_count = vertices;
  solid->triangle_count = triangles;
  return THRUM_OK;
}

static void put_triangle(scene_solid *solid, int64_t at, int64_t a, int64_t b, int64_t c) {
  solid->triangles[3 * at] = (int32_t)a;
  solid->triangles[3 * at + 1] = (int32_t)b;
  solid->triangles[3 * at + 2] = (int32_t)c;
}

static void put_vertex(scene_solid *solid, int64_t at, double x, double y, double z) {
  solid->vertices[3 * at] = x;
  solid->vertices[3 * at + 1] = y;
  solid->vertices[3 * at + 2] = z;
}

static thrum_status copy_mesh(const thrum_scene_solid_def *def, scene_solid *solid,
                              thrum_error *error) {
  if (def->vertices == NULL || def->triangles == NULL || def->vertex_count < 3 ||
      def->vertex_count > INT32_MAX || def->triangle_count < 1 || def->triangle_count > INT32_MAX)
    return refuse(error, "mesh needs 3 vertices and a triangle at least");
  THRUM_TRY(make_room(solid, def->vertex_count, def->triangle_count, error));
  memcpy(solid->vertices, def->vertices, 3 * (size_t)def->vertex_count * sizeof *def->vertices);
  memcpy(solid->triangles, def->triangles,
         3 * (size_t)def->triangle_count * sizeof *def->triangles);
  return THRUM_OK;
}

/* Corner n has the upper side of axis a where bit a of n is set. */
static thrum_status make_box(const thrum_scene_solid_def *def, scene_solid *solid,
                             thrum_error *error) {
  static const int32_t faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6},
                                       {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                       {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  THRUM_TRY(make_room(solid, 8, 12, error));
  for (int n = 0; n < 8; n++)
    put_vertex(solid, n, n & 1 ? def->half[0] : -def->half[0], n & 2 ? def->half[1] : -def->half[1],
               n & 4 ? def->half[2] : -def->half[2]);
  memcpy(solid->triangles, faces, sizeof faces);
  return THRUM_OK;
}

/* Rings around the z axis, each of `segments` vertices, from the lowest to the highest, between two
 * poles. */
static thrum_status make_rings(const double *radii, const double *heights, int64_t rings,
                               const double poles[2], int64_t segments, scene_solid *solid,
                               thrum_error *error) {
  const int64_t low = rings * segments, high = low + 1;
  THRUM_TRY(make_room(solid, high + 1, 2 * rings * segments, error));
  put_vertex(solid, low, 0, 0, poles[0]);
  put_vertex(solid, high, 0, 0, poles[1]);
  int64_t at = 0;
  for (int64_t ring = 0; ring < rings; ring++)
    for (int64_t n = 0; n < segments; n++) {
      const double angle = 2 * THRUM_PI * (double)n / (double)segments;
      const int64_t here = ring * segments + n, next = ring * segments + (n + 1) % segments;
      put_vertex(solid, here, radii[ring] * cos(angle), radii[ring] * sin(angle), heights[ring]);

      // the ends are fans, the bands between are two triangles a segment
      if (ring == 0)
        put_triangle(solid, at++, low, next, here);
      if (ring == rings - 1)
        put_triangle(solid, at++, high, here, next);
      if (ring < rings - 1) {
        put_triangle(solid, at++, here, next, next + segments);
        put_triangle(solid, at++, here, next + segments, here + segments);
      }
    }
  return THRUM_OK;
}

static thrum_status make_cylinder(const thrum_scene_solid_def *def, scene_solid *solid,
                                  thrum_error *error) {
  if (def->height <= 0.0)
    return refuse(error, "height must be above 0 [m] (0 for a capsule)");
  const double radii[2] = {def->radius, def->radius};
  const double heights[2] = {-0.5 * def->height, 0.5 * def->height};
  return make_rings(radii, heights, 2, heights, def->segments, solid, error);
}

/* Two half spheres, each of a quarter as many rings as there are segments. */
static thrum_status make_capsule(const thrum_scene_solid_def *def, scene_solid *solid,
                                 thrum_error *error) {
  double radii[SEGMENTS_MAX], heights[SEGMENTS_MAX];
  const int64_t half = def->segments / 4 > 1 ? def->segments / 4 : 1;
  const int64_t doubled = def->height > 0.0 ? 0 : 1; // one equator where there is no length
  int64_t rings = 0;
  for (int side = -1; side <= 1; side += 2)
    for (int64_t n = 0; n < half; n++) {
      const int64_t step = side < 0 ? half - 1 - n : n; // 0 at the equator
      if (side > 0 && step == 0 && doubled)
        continue;
      const double angle = 0.5 * THRUM_PI * (double)step / (double)half;
      radii[rings] = def->radius * cos(angle);
      heights[rings++] = side * (0.5 * def->height + def->radius * sin(angle));
    }
  const double pole = 0.5 * def->height + def->radius, poles[2] = {-pole, pole};
  return make_rings(radii, heights, rings, poles, def->segments, solid, error);
}

static thrum_status make_height_field(const thrum_scene_solid_def *def, scene_solid *solid,
                                      thrum_error *error) {
  if (def->heights == NULL || def->rows < 2 || def->columns < 2 || def->rows > GRID_MAX ||
      def->columns > GRID_MAX)
    return refuse(error, "height field needs 2 to 2^15 rows and columns of heights");
  THRUM_TRY(
      make_room(solid, def->rows * def->columns, 2 * (def->rows - 1) * (def->columns - 1), error));
  int64_t at = 0;
  for (int64_t row = 0; row < def->rows; row++)
    for (int64_t column = 0; column < def->columns; column++) {
      const int64_t here = row * def->columns + column;
      put_vertex(solid, here, ((double)column - 0.5 * (double)(def->columns - 1)) * def->spacing[0],
                 ((double)row - 0.5 * (double)(def->rows - 1)) * def->spacing[1],
                 def->heights[here]);
      if (row + 1 == def->rows || column + 1 == def->columns)
        continue;
      put_triangle(solid, at++, here, here + 1, here + 1 + def->columns);
      put_triangle(solid, at++, here, here + 1 + def->columns, here + def->columns);
    }
  return THRUM_OK;
}

thrum_status scene_solid_surface(const thrum_scene_solid_def *def, scene_solid *solid,
                                 thrum_error *error) {
  switch (def->shape) {
  case THRUM_SOLID_MESH:
    return copy_mesh(def, solid, error);
  case THRUM_SOLID_BOX:
    return make_box(def, solid, error);
  case THRUM_SOLID_CYLINDER:
    return make_cylinder(def, solid, error);
  case THRUM_SOLID_CAPSULE:
    return make_capsule(def, solid, error);
  case THRUM_SOLID_HEIGHT_FIELD:
    return make_height_field(def, solid, error);
  }
  return refuse(error, "shape is none of mesh, box, cylinder, capsule and height field");
}
