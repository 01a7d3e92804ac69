/* Sheets of surfaces: their volume by closed forms, their groups, and surfaces of which none can be
 * made. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "mesh/formats/surface_read.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_examine.h"
#include "mesh/solids.h"
#include "mesh/surface_sheet.h"

static thrum_status make(const char *text, double thickness, int64_t layers, thrum_sheet_side side,
                         thrum_mesh *mesh, thrum_error *error) {
  thrum_surface_mesh surface = {0};
  if (thrum_surface_parse_obj("s.obj", text, strlen(text), &surface, error) < 0)
    fail_msg("%s", error->message);
  const thrum_sheet_options options = {thickness, layers, side};
  const thrum_status status = thrum_surface_sheet(&surface, &options, "s.obj", mesh, error);
  thrum_surface_mesh_free(&surface);
  return status;
}

static thrum_mesh good(const char *text, double thickness, int64_t layers, thrum_sheet_side side,
                       double volume) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  thrum_mesh_examined examined;
  if (make(text, thickness, layers, side, &mesh, &error) < 0 ||
      thrum_mesh_clean(&mesh, "s.obj", 1, &error) < 0 ||
      thrum_mesh_examine(&mesh, &examined, &error) < 0)
    fail_msg("%s", error.message);
  if (!(fabs(examined.volume / volume - 1) < 1e-12))
    fail_msg("%.17g is not %.17g", examined.volume, volume);
  assert_int_equal(mesh.flipped_tets, 0);
  return mesh;
}

static void bad(const char *text, double thickness, const char *words) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  assert_int_equal(make(text, thickness, 1, THRUM_SHEET_MIDDLE, &mesh, &error), THRUM_BAD_VALUE);
  mesh_check_message(&error, words);
}

static int64_t members(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return mesh->groups[g].count;
  return -1;
}

/* A square, a triangle beside it, and the lowest and highest place of a sheet of both. */
#define PLATE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nf 1 2 3 4\nf 2 5 3\n"

static void a_plate_is_of_hexahedra_and_wedges(void **state) {
  (void)state;
  static const double low[] = {-0.05, -0.1, 0};
  for (int side = THRUM_SHEET_MIDDLE; side <= THRUM_SHEET_BOTTOM; side++) {
    thrum_mesh mesh = good(PLATE, 0.1, 2, (thrum_sheet_side)side, 0.15);
    double least = 1;
    for (int64_t v = 0; v < mesh.vertex_count; v++)
      least = fmin(least, mesh.vertices[3 * v + 2]);
    assert_true(fabs(least - low[side]) < 1e-15);
    assert_int_equal(mesh.solid_count, 4);
    assert_int_equal(mesh.solid_form[0], THRUM_FORM_HEX8);
    assert_int_equal(mesh.solid_form[2], THRUM_FORM_WEDGE6);
    assert_int_equal(members(&mesh, "top"), 5);
    assert_int_equal(members(&mesh, "bottom"), 5);
    assert_int_equal(members(&mesh, "middle"), 5);
    assert_int_equal(members(&mesh, "edge"), 15);
    assert_int_equal(members(&mesh, "edge_middle"), 5);
    thrum_mesh_free(&mesh);
  }
}

/* A polygon of four corners that goes back at one of them, from wherever it begins: two wedges. */
static void a_polygon_that_goes_back_is_two_wedges(void **state) {
  (void)state;
  for (int first = 0; first < 4; first++) {
    char text[200];
    snprintf(text, sizeof text, "v 0 0 0\nv 1 0 0\nv 0.2 0.2 0\nv 0 1 0\nf %d %d %d %d\n",
             first + 1, (first + 1) % 4 + 1, (first + 2) % 4 + 1, (first + 3) % 4 + 1);
    thrum_mesh mesh = good(text, 0.01, 1, THRUM_SHEET_MIDDLE, 0.002);
    assert_int_equal(mesh.solid_count, 2);
    assert_int_equal(mesh.solid_form[0], THRUM_FORM_WEDGE6);
    thrum_mesh_free(&mesh);
  }
}

/* The unit cube; corners are numbered by their bits. */
#define CORNERS "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
#define SIDES "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\n"

/* The faces of a box keep their distance at its edges and corners. */
static void a_box_has_walls_of_the_thickness(void **state) {
  (void)state;
  thrum_mesh mesh = good(CORNERS SIDES "f 2 6 8 4\n", 0.1, 1, THRUM_SHEET_MIDDLE,
                         1.1 * 1.1 * 1.1 - 0.9 * 0.9 * 0.9);
  assert_int_equal(mesh.solid_count, 6);
  assert_int_equal(members(&mesh, "edge"), -1);
  assert_int_equal(members(&mesh, "middle"), -1);
  thrum_mesh_free(&mesh);
}

static void what_makes_no_sheet_is_named_with_its_place(void **state) {
  (void)state;
  bad(CORNERS SIDES "f 2 6 8 4\n", 1.2,
      "s.obj:9: the surface bends too sharply for this thickness");
  bad("v 0 0 0\nv 0 1 0\nv 1 0 0\nv 1 0 .2\nf 1 3 2\nf 1 2 4\n", 0.01,
      "s.obj:5: the surface folds too sharply");
  bad(CORNERS "f 1 2 4 3\nf 1 2 6 5\n", 0.01,
      "s.obj:9: neighbours go round opposite ways, so the sheet has no top: edges: 1, the first "
      "from "
      "(0, 0, 0) to (0, 0, 1)");
  bad(CORNERS "f 1 2 4\nf 2 1 6\nf 2 1 3\n", 0.01, "edges of three triangles");
  bad(CORNERS "f 1 2 2\nf 1 2 3\n", 0.01, "s.obj:9: triangles without area");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_plate_is_of_hexahedra_and_wedges),
      cmocka_unit_test(a_polygon_that_goes_back_is_two_wedges),
      cmocka_unit_test(a_box_has_walls_of_the_thickness),
      cmocka_unit_test(what_makes_no_sheet_is_named_with_its_place),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
