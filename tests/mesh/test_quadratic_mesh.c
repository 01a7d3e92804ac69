/* Meshes of ten-node tetrahedra: made from linear ones, written and read again in every format that
 * has them, and refused where their middle nodes are wrong. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "core/base/quadratic_tet.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_examine.h"
#include "mesh/midsides.h"

/* How far the middle nodes are off the middle of their edges. */
static double farthest_off(const thrum_mesh *mesh) {
  double most = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    for (int e = 0; e < 6; e++)
      for (int axis = 0; axis < 3; axis++) {
        const int64_t a = mesh->tets[4 * t + thrum_quadratic_edges[e][0]];
        const int64_t b = mesh->tets[4 * t + thrum_quadratic_edges[e][1]];
        const double middle = (mesh->vertices[3 * a + axis] + mesh->vertices[3 * b + axis]) / 2;
        most = fmax(most,
                    fabs(mesh->vertices[3 * (int64_t)mesh->midsides[6 * t + e] + axis] - middle));
      }
  return most;
}

static thrum_mesh beam_make(void) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read_order("beam:3x2x2@1x0.3x0.3", 1, 2, &mesh, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  assert_non_null(mesh.midsides);
  return mesh;
}

static void a_linear_mesh_gets_a_node_in_the_middle_of_each_edge(void **state) {
  (void)state;
  thrum_mesh linear = {0}, mesh = beam_make();
  assert_int_equal(thrum_mesh_read("beam:3x2x2@1x0.3x0.3", 1, &linear, NULL), THRUM_OK);

  // the middles of edges, diagonals too, fill the grid of half the spacing
  assert_int_equal(mesh.vertex_count, 7 * 5 * 5);
  assert_memory_equal(mesh.tets, linear.tets, 4 * (size_t)linear.tet_count * sizeof *mesh.tets);
  assert_memory_equal(mesh.vertices, linear.vertices,
                      3 * (size_t)linear.vertex_count * sizeof *mesh.vertices);
  assert_true(farthest_off(&mesh) < 1e-15);

  // the face x = 0 holds its middle nodes too, and other faces alike
  for (int64_t g = 0; g < 6; g++) {
    const thrum_group *group = &mesh.groups[g];
    assert_int_equal(group->count, g < 2 ? 25 : 35);
    for (int64_t i = 1; i < group->count; i++)
      assert_true(group->vertices[i] > group->vertices[i - 1]);
  }
  for (int64_t i = 0; i < mesh.groups[0].count; i++)
    assert_true(mesh.vertices[3 * (int64_t)mesh.groups[0].vertices[i]] == 0);

  // what is examined counts all vertices
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(examined.interior_vertices, 5 * 3 * 3);
  assert_int_equal(examined.genus, 0);
  assert_true(fabs(examined.volume - 0.09) < 1e-15);

  // equal corners, other order: another mesh
  assert_true(thrum_mesh_hash(&mesh) != thrum_mesh_hash(&linear));
  thrum_mesh_free(&mesh);
  thrum_mesh_free(&linear);
}

static void every_format_with_ten_nodes_gives_back_the_mesh(void **state) {
  (void)state;
  static const struct {
    const char *name;
    thrum_mesh_write_options options;
  } cases[] = {{"a.msh", {.msh_version = 22}},
               {"b.msh", {.msh_version = 22, .binary = true}},
               {"c.msh", {.msh_version = 41}},
               {"d.msh", {.msh_version = 41, .binary = true}},
               {"e.vtk", {0}},
               {"f.vtk", {.binary = true}},
               {"g.vtu", {0}},
               {"h.vtu", {.ascii = true}},
               {"i.inp", {0}},
               {"j.mesh", {0}},
               {"k.ele", {0}}};
  thrum_mesh mesh = beam_make();

  // middle nodes off the middle show that no reader makes them itself
  for (int64_t v = 4 * 3 * 3; v < mesh.vertex_count; v++)
    mesh.vertices[3 * v] += 0.001 * (double)(v % 7);

  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char path[128];
    strcpy(path, mesh_write_text(cases[n].name, ""));
    if (strcmp(cases[n].name, "k.ele") == 0)
      mesh_write_text("k.node", "");
    thrum_mesh read = {0};
    thrum_mesh_lost lost;
    thrum_error error = {0};
    if (thrum_mesh_write(path, &mesh, &cases[n].options, &lost, &error) < 0 ||
        thrum_mesh_read(path, 1, &read, &error) < 0)
      fail_msg("%s", error.message);
    assert_int_equal(read.vertex_count, mesh.vertex_count);
    assert_int_equal(read.tet_count, mesh.tet_count);
    assert_non_null(read.midsides);
    assert_memory_equal(read.tets, mesh.tets, 4 * (size_t)mesh.tet_count * sizeof *mesh.tets);
    assert_memory_equal(read.midsides, mesh.midsides,
                        6 * (size_t)mesh.tet_count * sizeof *mesh.tets);
    assert_memory_equal(read.vertices, mesh.vertices,
                        3 * (size_t)mesh.vertex_count * sizeof *mesh.vertices);
    thrum_mesh_free(&read);
  }

  // Vega's has no place for them
  const thrum_mesh_write_options options = {0};
  thrum_mesh_lost lost;
  thrum_error error = {0};
  assert_int_equal(thrum_mesh_write("a.veg", &mesh, &options, &lost, &error), THRUM_UNSUPPORTED);
  mesh_check_message(&error, "--order 1");
  thrum_mesh_free(&mesh);
}

/* Nodes of one tet, and a second one on its face 1 2 3 (tags 2 3 4). */
#define NODES                                                                                      \
  "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n"           \
  "9,.5,0,.5\n10,0,.5,.5\n11,1,1,1\n12,1,.5,.5\n13,.5,1,.5\n14,.5,.5,1\n15,.5,.5,.01\n"
#define TEN "*ELEMENT, TYPE=C3D10\n1,1,2,3,4,5,6,7,8,9,10\n"

static void tets_wound_the_other_way_are_flipped_with_their_middle_nodes(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", NODES "*ELEMENT, TYPE=C3D10\n1,1,2,4,3,5,9,8,7,6,10\n");
  assert_int_equal(mesh.flipped_tets, 1);
  assert_true(farthest_off(&mesh) == 0);
  thrum_mesh_free(&mesh);

  // two tets share three middle nodes
  mesh = mesh_good("b.inp", NODES TEN "2,2,3,4,11,6,10,9,12,13,14\n");
  assert_int_equal(mesh.vertex_count, 14);
  assert_true(farthest_off(&mesh) == 0);
  thrum_mesh_free(&mesh);
}

static void refuse(const char *name, const char *text, const char *words) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  assert_true(thrum_mesh_read(mesh_write_text(name, text), 1, &mesh, &error) < 0);
  mesh_check_message(&error, words);
  assert_null(mesh.tets);
}

static void wrong_middle_nodes_are_refused_with_the_element_and_its_line(void **state) {
  (void)state;

  // elements of mixed orders
  refuse("a.inp", NODES TEN "*ELEMENT, TYPE=C3D4\n2,2,3,4,11\n",
         "a.inp:20: tet 2 has no middle nodes, where those before it have some");
  refuse("a.inp", NODES "*ELEMENT, TYPE=C3D4\n2,2,3,4,11\n" TEN,
         "a.inp:20: tet 1 has middle nodes, where those before it have none");

  // nodes in Gmsh's order are refused, and a middle node beyond the end of its edge
  refuse("a.inp", NODES "*ELEMENT, TYPE=C3D10\n1,1,2,3,4,7,8,9,10,5,6\n",
         "a.inp:18: tet 1 is turned inside out by its middle nodes");
  refuse("a.inp", NODES "*ELEMENT, TYPE=C3D10\n1,1,2,3,4,12,6,7,8,9,10\n",
         "a.inp:18: tet 1 is turned inside out by its middle nodes");

  // that are missing, come twice, are corners, or differ between neighbours
  refuse("a.inp", NODES "*ELEMENT, TYPE=C3D10\n1,1,2,3,4,5,6,7,8,9,99\n",
         "a.inp:18: tet 1 names vertex 99, which is not in the file");
  refuse("a.inp", NODES "*ELEMENT, TYPE=C3D10\n1,1,2,3,4,5,5,7,8,9,10\n",
         "a.inp:18: tet 1 has vertex 5 twice");
  refuse("a.inp", NODES TEN "2,2,3,4,11,1,10,9,12,13,14\n",
         "a.inp:19: tet 2 has vertex 1 between 2 and 3, where that is a corner of a tet");
  refuse(
      "a.inp", NODES TEN "2,2,3,4,11,15,10,9,12,13,14\n",
      "a.inp:19: tet 2 has vertex 15 between 2 and 3, where another tet at this edge has another "
      "one");
  refuse("a.inp", NODES TEN "2,2,3,4,11,6,10,9,12,13,5\n",
         "a.inp:19: tet 2 has vertex 5 between 4 and 11, where it lies on another edge as well");
}

/* Middle node 5 at a share of its edge from 1 to 2. */
static const char *with_middle_at(double share, char text[600]) {
  snprintf(text, 600, "%s*NODE\n16,%.17g,0,0\n*ELEMENT, TYPE=C3D10\n1,1,2,3,4,16,6,7,8,9,10\n",
           NODES, share);
  return text;
}

static void a_middle_node_beyond_a_quarter_of_its_edge_is_refused(void **state) {
  (void)state;
  char text[600];
  static const double beyond[] = {0.05, 0.15, 0.2, 0.24, 0.2499, 0.7501, 0.8};
  for (size_t n = 0; n < sizeof beyond / sizeof *beyond; n++)
    refuse("a.inp", with_middle_at(beyond[n], text), "a.inp:20: tet 1 is turned inside out");
  refuse("a.inp", with_middle_at(0.24, text), "inside out at vertex 1");
  refuse("a.inp", with_middle_at(0.76, text), "inside out at vertex 2");

  // the quarter itself is what elements at the tip of a crack have
  static const double within[] = {0.25, 0.2501, 0.4, 0.75};
  for (size_t n = 0; n < sizeof within / sizeof *within; n++) {
    thrum_mesh mesh = mesh_good("a.inp", with_middle_at(within[n], text));
    thrum_mesh_free(&mesh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_linear_mesh_gets_a_node_in_the_middle_of_each_edge),
      cmocka_unit_test(every_format_with_ten_nodes_gives_back_the_mesh),
      cmocka_unit_test(tets_wound_the_other_way_are_flipped_with_their_middle_nodes),
      cmocka_unit_test(wrong_middle_nodes_are_refused_with_the_element_and_its_line),
      cmocka_unit_test(a_middle_node_beyond_a_quarter_of_its_edge_is_refused),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
