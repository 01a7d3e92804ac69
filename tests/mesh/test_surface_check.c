/* Surfaces that enclose a body and surfaces that do not: each fault is counted and located.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "mesh/formats/surface_read.h"
#include "mesh/surface_check.h"
#include "mesh/surface_join.h"

/* A unit cube; its corners are numbered by their bits, 1 + 4 x + 2 y + z in the file. */
#define CORNERS "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
#define SIDES "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\n"
#define LID "f 2 6 8 4\n"

static thrum_surface_mesh parse(const char *text) {
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  if (thrum_surface_parse_obj("s.obj", text, strlen(text), &surface, &error) < 0)
    fail_msg("%s", error.message);
  return surface;
}

static thrum_surface_checked check(const thrum_surface_mesh *surface) {
  thrum_surface_checked checked;
  thrum_error error = {0};
  if (thrum_surface_check(surface, &checked, &error) < 0)
    fail_msg("%s", error.message);
  return checked;
}

static void expect(const char *text, const char *words) {
  thrum_surface_mesh surface = parse(text);
  const thrum_surface_checked checked = check(&surface);
  thrum_error error = {0};
  const thrum_status status = thrum_surface_meshable(&surface, &checked, "s.obj", &error);
  if (words == NULL) {
    assert_int_equal(status, THRUM_OK);
  } else {
    assert_int_equal(status, THRUM_BAD_VALUE);
    mesh_check_message(&error, words);
  }
  thrum_surface_mesh_free(&surface);
}

static void a_cube_has_no_fault(void **state) {
  (void)state;
  thrum_surface_mesh surface = parse(CORNERS SIDES LID);
  const thrum_surface_checked c = check(&surface);
  assert_int_equal(c.flat.count + c.twice.count + c.open.count + c.crowded.count + c.turned.count,
                   0);
  assert_int_equal(c.shells, 1);
  assert_true(fabs(c.volume - 1) < 1e-15);
  // the triangles have 36 sides, of which 24 are edges of the cube
  assert_true(fabs(c.edge_mean - (24 + 12 * sqrt(2)) / 36) < 1e-14);
  for (int axis = 0; axis < 3; axis++)
    assert_true(c.box_min[axis] == 0 && c.box_max[axis] == 1);
  expect(CORNERS SIDES LID, NULL);
  thrum_surface_mesh_free(&surface);
}

static void faults_are_named_with_their_line(void **state) {
  (void)state;
  expect(CORNERS SIDES, "s.obj:9: the surface is not closed: edges of one triangle: 4, the first");
  // two tetrahedra that share an edge
  expect("v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\n"
         "f 1 2 4\nf 1 4 3\nf 1 3 2\nf 2 3 4\nf 1 2 6\nf 1 6 5\nf 1 5 2\nf 2 5 6\n",
         "s.obj:7: the surface crosses or touches itself: edges of three triangles or more: 1, the "
         "first from (0, 0, 0) to (0, 0, 1)");
  expect(CORNERS SIDES LID "f 2 6 8\n", "s.obj:15: triangles that are there twice: 1");
  expect(CORNERS SIDES LID "f 8 2 6\n", "s.obj:15: triangles that are there twice: 1");
  expect(CORNERS "v 2 0 0\n" SIDES LID "f 1 5 9\n",
         "s.obj:16: triangles without area: 1, the first from (0, 0, 0) to (1, 0, 0)");
  expect(CORNERS SIDES LID "f 1 1 5\n", "s.obj:15: triangles without area: 1");
}

static void triangles_that_wind_the_other_way_are_counted(void **state) {
  (void)state;
  // a reversed face of two triangles has four edges in common with others
  thrum_surface_mesh surface = parse(CORNERS SIDES "f 4 8 6 2\n");
  thrum_surface_checked checked = check(&surface);
  assert_int_equal(checked.turned.count, 4);
  assert_int_equal(checked.open.count, 0);
  thrum_surface_mesh_free(&surface);
  surface = parse(CORNERS "f 3 4 2 1\nf 6 8 7 5\nf 2 6 5 1\nf 7 8 4 3\nf 5 7 3 1\nf 4 8 6 2\n");
  checked = check(&surface);
  assert_int_equal(checked.turned.count, 0);
  assert_true(fabs(checked.volume + 1) < 1e-15);
  thrum_surface_mesh_free(&surface);
}

/* Each face has corners of its own, as files with one normal per face have, and one vertex is
 * unused. */
static void vertices_at_one_place_are_joined(void **state) {
  (void)state;

  // the cube's faces without common corners
  char text[2048] = "v 7 7 7\n";
  static const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                  {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  for (int f = 0; f < 6; f++)
    for (int c = 0; c < 4; c++)
      snprintf(text + strlen(text), 64, "v %s%d %d %d\n", c % 2 == 0 && faces[f][c] < 4 ? "-" : "",
               faces[f][c] / 4, faces[f][c] / 2 % 2, faces[f][c] % 2);
  for (int f = 0; f < 6; f++)
    snprintf(text + strlen(text), 64, "f %d %d %d %d\n", 4 * f + 2, 4 * f + 3, 4 * f + 4,
             4 * f + 5);

  // without joining it is six open squares
  expect(text, "s.obj:26: the surface is not closed: edges of one triangle: 24");
  thrum_surface_mesh surface = parse(text);
  int64_t joined = 0;
  assert_int_equal(check(&surface).shells, 6);

  // joined at equal places, it is a closed cube
  assert_int_equal(thrum_surface_join(&surface, &joined, NULL), THRUM_OK);
  assert_int_equal(joined, 16);
  assert_int_equal(surface.vertex_count, 8);
  const thrum_surface_checked checked = check(&surface);
  assert_int_equal(checked.open.count, 0);
  assert_int_equal(checked.shells, 1);
  assert_true(fabs(checked.volume - 1) < 1e-15);

  thrum_surface_mesh_free(&surface);
}

/* A cube with a cubic cavity, and a tetrahedron beside them; then with all triangles reversed. */
static void a_cavity_has_a_point_inside(void **state) {
  (void)state;

  // the cavity and the tetrahedron
  static const char cavity[] =
      "v .3 .3 .3\nv .3 .3 .6\nv .3 .6 .3\nv .3 .6 .6\nv .6 .3 .3\nv .6 .3 .6\nv .6 .6 .3\n"
      "v .6 .6 .6\nf 11 12 10 9\nf 14 16 15 13\nf 10 14 13 9\nf 15 16 12 11\nf 13 15 11 9\n"
      "f 12 16 14 10\nv 2 0 0\nv 2 0 1\nv 2 1 0\nv 3 0 0\nf 17 18 19\nf 17 19 20\n"
      "f 17 20 18\nf 18 20 19\n";
  char text[2048];
  snprintf(text, sizeof text, "%s%s", CORNERS SIDES LID, cavity);
  thrum_surface_mesh surface = parse(text);

  // both windings
  for (int turn = 0; turn < 2; turn++) {
    // three closed shells with the volume that the cavity leaves
    const thrum_surface_checked checked = check(&surface);
    assert_int_equal(checked.turned.count, 0);
    assert_int_equal(checked.shells, 3);
    assert_true(fabs(fabs(checked.volume) - (1 - 0.027 + 1.0 / 6)) < 1e-14);

    // one point, inside of the cavity
    double *points = NULL;
    int64_t count = 0;
    assert_int_equal(thrum_surface_cavities(&surface, &points, &count, NULL), THRUM_OK);
    assert_int_equal(count, 1);
    for (int axis = 0; axis < 3; axis++)
      assert_true(points[axis] > 0.3 && points[axis] < 0.6);
    free(points);

    // the other winding
    for (int64_t t = 0; t < surface.triangle_count; t++) {
      const int32_t swap = surface.triangles[3 * t];
      surface.triangles[3 * t] = surface.triangles[3 * t + 1];
      surface.triangles[3 * t + 1] = swap;
    }
  }

  thrum_surface_mesh_free(&surface);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cube_has_no_fault),
      cmocka_unit_test(faults_are_named_with_their_line),
      cmocka_unit_test(triangles_that_wind_the_other_way_are_counted),
      cmocka_unit_test(vertices_at_one_place_are_joined),
      cmocka_unit_test(a_cavity_has_a_point_inside),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
