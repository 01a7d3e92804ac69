/* Solids of each shape are closed surfaces, seen counter-clockwise from outside, that hold the
 * volume of the shape; a height field lies over its plane. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "tests/support/scene_call.h"

/* The surface of a def in a scene of its own, which stays. */
static thrum_scene_solid solid_of(const thrum_scene_solid_def *def, thrum_scene **scene) {
  thrum_scene_solid solid;
  MUST(thrum_scene_create(0.01, scene, &failure));
  MUST(thrum_scene_add_solid(*scene, def, NULL, &failure));
  MUST(thrum_scene_solid_get(*scene, 0, &solid, &failure));
  return solid;
}

/* How many triangles go along the edge from a to b. */
static int count_edge(const thrum_scene_solid *solid, int32_t a, int32_t b) {
  int count = 0;
  for (int64_t t = 0; t < solid->triangle_count; t++)
    for (int c = 0; c < 3; c++)
      count += solid->triangles[3 * t + c] == a && solid->triangles[3 * t + (c + 1) % 3] == b;
  return count;
}

/* A sixth of the sum of x0 (x1 x x2) over the triangles is the volume inside (Gauss). */
static double volume_of(const thrum_scene_solid *solid) {
  double sum = 0;
  for (int64_t t = 0; t < solid->triangle_count; t++) {
    const int32_t *corner = solid->triangles + 3 * t;
    sum += thrum_triple3(solid->vertices + 3 * corner[0], solid->vertices + 3 * corner[1],
                         solid->vertices + 3 * corner[2]);
  }
  return sum / 6;
}

static void assert_closed(const thrum_scene_solid *solid, double volume) {
  for (int64_t t = 0; t < solid->triangle_count; t++)
    for (int c = 0; c < 3; c++) {
      const int32_t a = solid->triangles[3 * t + c], b = solid->triangles[3 * t + (c + 1) % 3];
      assert_true(a >= 0 && a < solid->vertex_count);
      assert_int_equal(count_edge(solid, a, b), 1);
      assert_int_equal(count_edge(solid, b, a), 1);
    }

  // Euler: without holes there are two triangles a vertex, less four
  assert_int_equal(solid->triangle_count, 2 * solid->vertex_count - 4);
  const double found = volume_of(solid);
  if (!(fabs(found - volume) <= 1e-12 * volume))
    fail_msg("the volume is %.15g, not %.15g", found, volume);
}

static void a_box_has_its_sides(void **state) {
  (void)state;
  thrum_scene *scene = NULL;
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.half[0] = 0.5;
  def.half[1] = 2;
  def.half[2] = 0.25;
  const thrum_scene_solid solid = solid_of(&def, &scene);
  assert_closed(&solid, 8 * 0.5 * 2 * 0.25);
  thrum_scene_destroy(scene);
}

/* The area of a regular polygon of so many corners at distance 1. */
static double polygon(int segments) {
  return 0.5 * segments * sin(2 * THRUM_PI / segments);
}

static void a_cylinder_is_a_prism(void **state) {
  (void)state;
  static const int segments[] = {3, 4, 17, 1024};
  for (int n = 0; n < 4; n++) {
    thrum_scene *scene = NULL;
    thrum_scene_solid_def def = thrum_default_scene_solid_def();
    def.shape = THRUM_SOLID_CYLINDER;
    def.radius = 0.7;
    def.height = 1.5;
    def.segments = segments[n];
    const thrum_scene_solid solid = solid_of(&def, &scene);
    if (segments[n] < 100)
      assert_closed(&solid, polygon(segments[n]) * 0.49 * 1.5);
    assert_true(fabs(volume_of(&solid) / (polygon(segments[n]) * 0.49 * 1.5) - 1) < 1e-12);

    // its middle is the origin
    double low[3], high[3];
    thrum_box3(solid.vertices, solid.vertex_count, low, high);
    assert_true(low[2] == -0.75 && high[2] == 0.75 && high[0] == 0.7);
    thrum_scene_destroy(scene);
  }
}

/* Frusta between rings at equal angles, with a cone at either end. */
static double capsule_volume(double radius, double height, int segments) {
  const int half = segments / 4 > 1 ? segments / 4 : 1;
  double sum = radius * radius * height;
  for (int n = 0; n < half; n++) {
    const double a = 0.5 * THRUM_PI * n / half, b = 0.5 * THRUM_PI * (n + 1) / half;
    const double r = radius * cos(a), s = n + 1 < half ? radius * cos(b) : 0;
    sum += 2 * radius * (sin(b) - sin(a)) * (r * r + r * s + s * s) / 3;
  }
  return polygon(segments) * sum;
}

static void a_capsule_has_half_spheres_on_its_ends(void **state) {
  (void)state;
  static const int segments[] = {3, 8, 13, 32};
  for (int n = 0; n < 8; n++) {
    thrum_scene *scene = NULL;
    thrum_scene_solid_def def = thrum_default_scene_solid_def();
    def.shape = THRUM_SOLID_CAPSULE;
    def.radius = 0.3;
    def.height = n < 4 ? 0.8 : 0;
    def.segments = segments[n % 4];
    const thrum_scene_solid solid = solid_of(&def, &scene);
    assert_closed(&solid, capsule_volume(0.3, def.height, def.segments));
    double low[3], high[3];
    thrum_box3(solid.vertices, solid.vertex_count, low, high);
    assert_true(fabs(high[2] - 0.5 * def.height - 0.3) < 1e-15 && low[2] == -high[2]);
    thrum_scene_destroy(scene);
  }
}

static void a_plane_of_heights_is_a_plane(void **state) {
  (void)state;
  enum { ROWS = 4, COLUMNS = 6 };
  double heights[ROWS * COLUMNS], area = 0;
  for (int n = 0; n < ROWS * COLUMNS; n++)
    heights[n] = 0.5 * (n % COLUMNS - 2.5) * 0.2 - 2 * (n / COLUMNS - 1.5) * 0.1 + 0.3;
  thrum_scene *scene = NULL;
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.shape = THRUM_SOLID_HEIGHT_FIELD;
  def.heights = heights;
  def.rows = ROWS;
  def.columns = COLUMNS;
  def.spacing[0] = 0.2;
  def.spacing[1] = 0.1;
  const thrum_scene_solid solid = solid_of(&def, &scene);
  assert_int_equal(solid.vertex_count, ROWS * COLUMNS);
  assert_int_equal(solid.triangle_count, 2 * (ROWS - 1) * (COLUMNS - 1));
  for (int64_t v = 0; v < solid.vertex_count; v++) {
    const double *x = solid.vertices + 3 * v;
    assert_true(fabs(x[2] - (0.5 * x[0] - 2 * x[1] + 0.3)) < 1e-15);
    assert_true(fabs(x[0]) < 0.5 + 1e-15 && fabs(x[1]) < 0.15 + 1e-15);
  }

  // all triangles look up, and cover the plane once
  for (int64_t t = 0; t < solid.triangle_count; t++) {
    const int32_t *corner = solid.triangles + 3 * t;
    double e[3], f[3], normal[3];
    thrum_subtract3(solid.vertices + 3 * corner[1], solid.vertices + 3 * corner[0], e);
    thrum_subtract3(solid.vertices + 3 * corner[2], solid.vertices + 3 * corner[0], f);
    thrum_cross3(e, f, normal);
    assert_true(fabs(normal[2] - 0.02) < 1e-15);
    assert_true(fabs(normal[0] + 0.5 * normal[2]) < 1e-15 &&
                fabs(normal[1] - 2 * normal[2]) < 1e-15);
    area += 0.5 * normal[2];
  }
  assert_true(fabs(area - 1.0 * 0.3) < 1e-14);
  thrum_scene_destroy(scene);
}

static void shapes_that_are_none_are_refused(void **state) {
  (void)state;
  static const double heights[4] = {0}, corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static const int32_t triangle[3] = {0, 1, 2};
  const thrum_scene_solid_def none = thrum_default_scene_solid_def();
  thrum_scene_solid_def cases[9];
  for (int n = 0; n < 9; n++) {
    cases[n] = none;
    cases[n].shape = n < 1   ? THRUM_SOLID_CYLINDER
                     : n < 4 ? THRUM_SOLID_HEIGHT_FIELD
                             : THRUM_SOLID_MESH;
    cases[n].heights = heights;
    cases[n].rows = cases[n].columns = 2;
    cases[n].vertices = corners;
    cases[n].vertex_count = 3;
    cases[n].triangles = triangle;
    cases[n].triangle_count = 1;
  }
  cases[0].height = 0;
  cases[1].heights = NULL;
  cases[2].rows = 1;
  cases[3].columns = 1;
  cases[4].vertices = NULL;
  cases[5].triangles = NULL;
  cases[6].vertex_count = 2;
  cases[7].triangle_count = 0;
  cases[8].shape = (thrum_solid_shape)7;
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.01, &scene, &failure));
  for (int n = 0; n < 9; n++)
    assert_true(thrum_scene_add_solid(scene, &cases[n], NULL, &failure) < 0);
  assert_int_equal(thrum_scene_solid_count(scene), 0);

  // the smallest ones are taken
  cases[2].rows = 2;
  cases[6].vertex_count = 3;
  MUST(thrum_scene_add_solid(scene, &cases[2], NULL, &failure));
  MUST(thrum_scene_add_solid(scene, &cases[6], NULL, &failure));
  thrum_scene_destroy(scene);
}

/* What lies behind an array is none of the scene's business. */
static void arrays_are_read_to_their_ends(void **state) {
  (void)state;
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.01, &scene, &failure));
  const double times[3] = {0, 1, NAN}, place[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, NAN};
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.path_times = times;
  def.path_places = place;
  def.path_count = 2;
  MUST(thrum_scene_add_solid(scene, &def, NULL, &failure));
  def.path_count = 3;
  assert_int_equal(thrum_scene_add_solid(scene, &def, NULL, &failure), THRUM_BAD_VALUE);

  // the ground by a record
  const double moments[2] = {0, 1}, still[7] = {0, 0, 0, 0, 0, 0, NAN};
  const thrum_base_motion motion = {2, moments, still, still, still};
  MUST(thrum_scene_add_base_motion_record(scene, &motion, &failure));
  thrum_scene_destroy(scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_box_has_its_sides),
      cmocka_unit_test(a_cylinder_is_a_prism),
      cmocka_unit_test(a_capsule_has_half_spheres_on_its_ends),
      cmocka_unit_test(a_plane_of_heights_is_a_plane),
      cmocka_unit_test(shapes_that_are_none_are_refused),
      cmocka_unit_test(arrays_are_read_to_their_ends),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
