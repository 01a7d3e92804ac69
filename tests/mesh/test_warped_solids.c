/* Hexahedra, wedges and pyramids with faces that are not flat keep the volume of the trilinear
 * element when they are cut, and fit their neighbours. A bar whose section turns by an angle a from
 * one layer of nodes to the next has in between the section times 1 - 2 z (1 - z) (1 - cos a), with
 * z from 0 to 1, which makes 1 - (1 - cos a) / 3. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "mesh/mesh_examine.h"
#include "mesh/mesh_groups.h"

enum { SIDE = 3, LAYERS = 4, TEXT_MAX = 1 << 16 };

static const double DEGREE = 3.14159265358979323846 / 180;

static bool has_note(const thrum_mesh *mesh, const char *words) {
  for (int64_t n = 0; n < mesh->note_count; n++)
    if (strstr(mesh->notes[n].text, words))
      return true;
  return false;
}

static int node(int i, int j, int k, unsigned seed) {
  // any order of the numbers that a prime number makes
  const unsigned count = 173, plain = (unsigned)((k * (SIDE + 1) + j) * (SIDE + 1) + i + 1);
  return (int)(seed ? plain * seed % count : plain);
}

/* A bar of hexahedra or wedges, turned by `degrees[k]` at the layer k of nodes. */
static thrum_mesh read_bar(const double *degrees, bool wedges, unsigned seed) {
  static char text[TEXT_MAX];
  int used = sprintf(text, "*NODE\n"), elements = 0;
  for (int k = 0; k <= LAYERS; k++)
    for (int j = 0; j <= SIDE; j++)
      for (int i = 0; i <= SIDE; i++) {
        const double x = i - SIDE / 2.0, y = j - SIDE / 2.0, a = degrees[k] * DEGREE;
        used += sprintf(text + used, "%d,%.17g,%.17g,%d\n", node(i, j, k, seed),
                        cos(a) * x - sin(a) * y, sin(a) * x + cos(a) * y, k);
      }
  used += sprintf(text + used, "*ELEMENT, TYPE=%s, ELSET=ALL\n", wedges ? "C3D6" : "C3D8");
  static const int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  static const int halves[2][6] = {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
  for (int cell = 0; cell < LAYERS * SIDE * SIDE; cell++)
    for (int half = 0; half < (wedges ? 2 : 1); half++) {
      used += sprintf(text + used, "%d", ++elements);
      for (int c = 0; c < (wedges ? 6 : 8); c++) {
        const int *at = corners[wedges ? halves[half][c] : c];
        used += sprintf(text + used, ",%d",
                        node(cell % SIDE + at[0], cell / SIDE % SIDE + at[1],
                             cell / SIDE / SIDE + at[2], seed));
      }
      used += sprintf(text + used, "\n");
    }
  used += sprintf(text + used, "*NSET, NSET=FOOT\n");
  for (int n = 0; n < (SIDE + 1) * (SIDE + 1); n++)
    used += sprintf(text + used, "%d\n", node(n % (SIDE + 1), n / (SIDE + 1), 0, seed));
  used += sprintf(text + used, "*NSET, NSET=FRONT\n");
  for (int n = 0; n < (SIDE + 1) * (LAYERS + 1); n++)
    used += sprintf(text + used, "%d\n", node(n % (SIDE + 1), 0, n / (SIDE + 1), seed));
  assert_true(used < TEXT_MAX);
  return mesh_good("a.inp", text);
}

static double bar_volume(const double *degrees) {
  double sum = 0;
  for (int k = 0; k < LAYERS; k++)
    sum += SIDE * SIDE * (1 - (1 - cos((degrees[k + 1] - degrees[k]) * DEGREE)) / 3);
  return sum;
}

static void a_twisted_bar_keeps_its_volume(void **state) {
  (void)state;
  static const double twists[][LAYERS + 1] = {
      {0, 20, 40, 60, 80}, {0, 0, 50, 50, 50}, {0, 50, 0, 50, 0}, {0, 0, 0, 0, 0}, {0, 1, 2, 3, 4}};
  for (int n = 0; n < 5; n++)
    for (int kind = 0; kind < 6; kind++) {
      thrum_mesh mesh = read_bar(twists[n], kind & 1, kind < 2 ? 0 : 37U * (unsigned)kind);
      thrum_mesh_examined examined;
      assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);

      // closed, of one piece, without any hole or crack
      assert_int_equal(examined.pieces, 1);
      assert_int_equal(examined.genus, 0);
      assert_int_equal(mesh.flipped_tets, 0);
      const double off = fabs(examined.volume / bar_volume(twists[n]) - 1);
      if (!(off < (n == 4 ? 0.01 : 1e-12)))
        fail_msg("%d, %d: volume %g off", n, kind, off);

      // only elements beside a strong twist have more tets; a loss is told of
      if ((n < 3) != has_note(&mesh, "around their centres"))
        fail_msg("%d, %d: %s", n, kind, mesh.notes[0].text);
      assert_true(has_note(&mesh, " by that") == (off > 1e-5));
      if (n == 1 && !(kind & 1))
        assert_true(has_note(&mesh, ", 9 of them around"));
      const thrum_group *foot = thrum_mesh_find_group(&mesh, "FOOT");
      const thrum_group *front = thrum_mesh_find_group(&mesh, "FRONT");
      assert_int_equal(foot->count, (SIDE + 1) * (SIDE + 1));
      assert_int_equal(front->count, (SIDE + 1) * (LAYERS + 1) + (n == 1  ? SIDE
                                                                  : n < 3 ? SIDE * LAYERS
                                                                          : 0));
      assert_int_equal(thrum_mesh_find_group(&mesh, "ALL")->count, mesh.vertex_count);
      thrum_mesh_free(&mesh);
    }
}

#define TURNED                                                                                     \
  "-.5 -.5 0\n.5 -.5 0\n.5 .5 0\n-.5 .5 0\n-.183012702 -.683012702 1\n.683012702 -.183012702 1\n"  \
  ".183012702 .683012702 1\n-.683012702 .183012702 1\n"

static double volume_of(const char *name, const char *text, int64_t tets) {
  thrum_mesh mesh = mesh_good(name, text);
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(mesh.tet_count, tets);
  thrum_mesh_free(&mesh);
  return examined.volume;
}

static void single_elements_keep_their_volume(void **state) {
  (void)state;

  // turned by 30 degrees, in three formats; a pyramid has a quarter of the tetrahedron of its base
  char text[2000];
  snprintf(text, sizeof text,
           "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 double\n%s"
           "CELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n",
           TURNED);
  assert_true(fabs(volume_of("a.vtk", text, 20) - 0.955341801) < 1e-8);
  assert_true(fabs(volume_of("a.inp",
                             "*NODE\n1,0,0,0\n2,1,0,.5\n3,1,1,0\n4,0,1,.5\n5,.5,.5,1\n"
                             "*ELEMENT, TYPE=C3D5\n1,1,2,3,4,5\n",
                             8) -
                   0.25) < 1e-14);

  // in a file that names an element once for each of its groups, both are one
  snprintf(text, sizeof text,
           "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n8\n1 -.5 -.5 0\n2 .5 -.5 0\n3 .5 .5 0\n"
           "4 -.5 .5 0\n5 -.183012702 -.683012702 1\n6 .683012702 -.183012702 1\n"
           "7 .183012702 .683012702 1\n8 -.683012702 .183012702 1\n$EndNodes\n$Elements\n2\n"
           "1 5 2 1 1 1 2 3 4 5 6 7 8\n2 5 2 2 1 1 2 3 4 5 6 7 8\n$EndElements\n");
  assert_true(fabs(volume_of("a.msh", text, 20) - 0.955341801) < 1e-8);
}

static void elements_of_order_two_keep_their_volume(void **state) {
  (void)state;
  static const int edges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                   {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  double x[20][3];
  char text[2000];
  int used = sprintf(text, "*NODE\n");

  // straight edges, and faces that are not flat: their centres lie on the common edge of the halves
  for (int n = 0; n < 8; n++) {
    const double a = (n < 4 ? 0 : 20) * DEGREE, p = n % 4 == 1 || n % 4 == 2 ? 0.5 : -0.5;
    const double q = n % 4 >= 2 ? 0.5 : -0.5;
    const double place[3] = {cos(a) * p - sin(a) * q, sin(a) * p + cos(a) * q, n / 4};
    memcpy(x[n], place, sizeof place);
  }
  for (int e = 0; e < 12; e++)
    for (int c = 0; c < 3; c++)
      x[8 + e][c] = (x[edges[e][0]][c] + x[edges[e][1]][c]) / 2;
  for (int n = 0; n < 20; n++)
    used += sprintf(text + used, "%d,%.17g,%.17g,%.17g\n", n + 1, x[n][0], x[n][1], x[n][2]);
  sprintf(text + used, "*ELEMENT, TYPE=C3D20\n1,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15\n"
                       "16,17,18,19,20\n");
  assert_true(fabs(volume_of("a.inp", text, 6) - (1 - (1 - cos(20 * DEGREE)) / 3)) < 1e-14);

  // by its corners it is cut as one of order 1 is
  thrum_mesh mesh = {0};
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_read_order(mesh_write_text("a.inp", text), 1, 1, &mesh, NULL),
                   THRUM_OK);
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(mesh.tet_count, 20);
  assert_int_equal(mesh.cornered_tets, 20);
  assert_true(fabs(examined.volume - (1 - (1 - cos(20 * DEGREE)) / 3)) < 1e-14);
  thrum_mesh_free(&mesh);
}

static void what_cannot_be_cut_is_refused(void **state) {
  (void)state;
  char text[2000];

  // turned by 180 degrees, where the middle of the element has no section
  mesh_bad("a.mesh",
           "MeshVersionFormatted 2\nDimension 3\nVertices\n8\n0 0 0 0\n1 0 0 0\n1 1 0 0\n0 1 0 0\n"
           "1 1 1 0\n0 1 1 0\n0 0 1 0\n1 0 1 0\nHexahedra\n1\n1 2 3 4 5 6 7 8 0\nEnd\n",
           "element 1 is too warped to be cut into tetrahedra");

  // a tetrahedron at half of a face that is cut in four would leave a crack
  snprintf(text, sizeof text,
           "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 double\n%s"
           "0 -2 .5\nCELLS 2 14\n8 0 1 2 3 4 5 6 7\n4 0 1 5 8\nCELL_TYPES 2\n12\n10\n",
           TURNED);
  mesh_bad("a.vtk", text, "tetrahedron 2 lies at a warped face of a hexahedron");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_twisted_bar_keeps_its_volume),
      cmocka_unit_test(single_elements_keep_their_volume),
      cmocka_unit_test(elements_of_order_two_keep_their_volume),
      cmocka_unit_test(what_cannot_be_cut_is_refused),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
