/* Hexahedra, wedges and pyramids are cut into tetrahedra of their order: neighbours agree on the
 * diagonal of their face however vertices are numbered, nothing is lost, and curved elements keep
 * their shape. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "mesh/divide_shells.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_flags.h"
#include "mesh/solids.h"

enum { CELLS = 3, HALVES = 2 * CELLS + 1, TEXT_MAX = 1 << 17 };

/* A grid of hexahedra, or of wedges where each is halved, of numbers in a random order. */
typedef struct grid {
  bool quadratic, wedges;
  double curved; /* 0: straight edges */
  int numbers[HALVES][HALVES][HALVES];
} grid;

/* A map of degree 2 in all of its terms, with edges of any direction curved. */
static void place(const grid *g, int i, int j, int k, double x[3]) {
  const double a = i / 2.0, b = j / 2.0, c = k / 2.0, d = g->curved;
  x[0] = a + 0.1 * b + d * (a * a + b * b - c * c + a * b);
  x[1] = b + 0.2 * c + d * (a * a - b * b + c * c + b * c);
  x[2] = c - 0.1 * a + d * (b * b - a * a + c * c + a * c);
}

static int64_t next_random(uint64_t *state) {
  *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
  return (int64_t)(*state >> 33);
}

static void number(grid *g, uint64_t seed) {
  int order[HALVES * HALVES * HALVES];
  const int count = HALVES * HALVES * HALVES;
  for (int n = 0; n < count; n++)
    order[n] = n + 1;
  for (int n = count - 1; n > 0; n--) {
    const int other = (int)(next_random(&seed) % (n + 1)), swap = order[n];
    order[n] = order[other];
    order[other] = swap;
  }
  memcpy(g->numbers, order, sizeof order);
}

/* Adds the corners of an element, given in halves, and its middle nodes. */
static int add_element(const grid *g, thrum_solid kind, int corners[][3], char *text) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  int used = 0;
  for (int c = 0; c < shape->corners; c++)
    used += sprintf(text + used, ",%d", g->numbers[corners[c][0]][corners[c][1]][corners[c][2]]);
  for (int e = 0; e < shape->edges && g->quadratic; e++) {
    const int *p = corners[shape->edge[e][0]], *q = corners[shape->edge[e][1]];
    used += sprintf(text + used, ",%s%d", e == 3 ? "\n" : "",
                    g->numbers[(p[0] + q[0]) / 2][(p[1] + q[1]) / 2][(p[2] + q[2]) / 2]);
  }
  return used + sprintf(text + used, "\n");
}

static int add_cell(const grid *g, const int at[3], int *count, char *text) {
  static const int cube[8][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},
                                 {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}};
  static const int wedges[2][6] = {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
  int used = 0, corners[8][3];
  for (int half = 0; half < (g->wedges ? 2 : 1); half++) {
    for (int c = 0; c < (g->wedges ? 6 : 8); c++)
      for (int axis = 0; axis < 3; axis++)
        corners[c][axis] = 2 * at[axis] + cube[g->wedges ? wedges[half][c] : c][axis];
    used += sprintf(text + used, "%d", ++*count);
    used += add_element(g, g->wedges ? THRUM_SOLID_WEDGE : THRUM_SOLID_HEXAHEDRON, corners,
                        text + used);
  }
  return used;
}

static thrum_mesh read_as(const char *text, thrum_element_choice element) {
  const thrum_mesh_read_options options = {.scale = 1, .element = element};
  const char *path = mesh_write("a.inp", text, strlen(text));
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read_with(path, &options, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

/* Wedges cut by the plane x = y need nodes in the middle of that face, which the grid has. */
static thrum_mesh read_grid(const grid *g, thrum_element_choice element) {
  char *text = malloc(TEXT_MAX);
  assert_non_null(text);
  int used = sprintf(text, "*NODE\n"), count = 0;

  // nodes in the middle of cells and faces are there too, and are dropped
  for (int i = 0; i < HALVES; i++)
    for (int j = 0; j < HALVES; j++)
      for (int k = 0; k < HALVES; k++) {
        double x[3];
        place(g, i, j, k, x);
        used +=
            sprintf(text + used, "%d,%.17g,%.17g,%.17g\n", g->numbers[i][j][k], x[0], x[1], x[2]);
      }
  const char *type =
      g->wedges ? (g->quadratic ? "C3D15" : "C3D6") : (g->quadratic ? "C3D20R" : "C3D8R");
  used += sprintf(text + used, "*ELEMENT, TYPE=%s\n", type);
  for (int i = 0; i < CELLS; i++)
    for (int j = 0; j < CELLS; j++)
      for (int k = 0; k < CELLS; k++)
        used += add_cell(g, (const int[3]){i, j, k}, &count, text + used);
  assert_true(used < TEXT_MAX);
  thrum_mesh mesh = read_as(text, element);
  free(text);
  return mesh;
}

/* Integral of the determinant of the map, of degree 3, by two points an axis. */
static double exact_volume(const grid *g) {
  const double d = g->curved, L = CELLS, root = 1 / sqrt(3.0);
  double sum = 0;
  for (int n = 0; n < 8; n++) {
    const double a = L / 2 * (1 + (n & 1 ? root : -root)), b = L / 2 * (1 + (n & 2 ? root : -root)),
                 c = L / 2 * (1 + (n & 4 ? root : -root));
    const double J[3][3] = {{1 + d * (2 * a + b), 0.1 + d * (2 * b + a), -2 * d * c},
                            {2 * d * a, 1 + d * (c - 2 * b), 0.2 + d * (2 * c + b)},
                            {-0.1 + d * (c - 2 * a), 2 * d * b, 1 + d * (2 * c + a)}};
    sum += J[0][0] * (J[1][1] * J[2][2] - J[1][2] * J[2][1]) -
           J[0][1] * (J[1][0] * J[2][2] - J[1][2] * J[2][0]) +
           J[0][2] * (J[1][0] * J[2][1] - J[1][1] * J[2][0]);
  }
  return sum * L * L * L / 8;
}

static void elements_are_cut_conformingly_whatever_their_numbers(void **state) {
  (void)state;
  for (int n = 0; n < 16; n++) {
    grid g = {.quadratic = n & 1, .wedges = n & 2, .curved = n & 4 ? 0.01 : 0};
    number(&g, (uint64_t)n);
    if (n & 4 && !g.quadratic) // faces of linear elements would not be planar
      continue;
    thrum_mesh mesh = read_grid(&g, THRUM_ELEMENT_TET);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);

    // six tets a cell; with one diagonal that differs faces of cells would count as surface
    assert_int_equal(mesh.tet_count, 6 * CELLS * CELLS * CELLS);
    assert_int_equal(examined.surface_triangles, 6 * 2 * CELLS * CELLS);
    assert_int_equal(examined.genus, 0);
    assert_int_equal(mesh.flipped_tets, 0);
    assert_int_equal((mesh.midsides != NULL), g.quadratic);

    // the tets of a map of degree 2 show it exactly, also where nodes had to be made
    if (!(fabs(examined.volume / exact_volume(&g) - 1) < 1e-13))
      fail_msg("%d: volume %.17g, not %.17g", n, examined.volume, exact_volume(&g));

    // and a line says what was done
    assert_int_equal(mesh.note_count, 1);
    assert_string_equal(mesh.notes[0].text,
                        g.wedges
                            ? (g.quadratic ? "54 wedges were cut into 162 tetrahedra of ten nodes"
                                           : "54 wedges were cut into 162 tetrahedra of four nodes")
                        : g.quadratic ? "27 hexahedra were cut into 162 tetrahedra of ten nodes"
                                      : "27 hexahedra were cut into 162 tetrahedra of four nodes");
    thrum_mesh_free(&mesh);
  }
}

/* Solids that stay have their nodes, their volume where edges are curved too, and tets of all of
 * their nodes that are their shape. */
static void solids_stay_with_tets_for_their_shape(void **state) {
  (void)state;
  for (int n = 0; n < 8; n++) {
    grid g = {.quadratic = n & 1, .wedges = n & 2, .curved = n & 4 && n & 1 ? 0.01 : 0};
    number(&g, (uint64_t)n);
    thrum_mesh mesh = read_grid(&g, THRUM_ELEMENT_SOLID);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
    const int64_t cells = (int64_t)CELLS * CELLS * CELLS, solids = g.wedges ? 2 * cells : cells;
    const thrum_solid_form form =
        thrum_solid_form_of(g.wedges ? THRUM_SOLID_WEDGE : THRUM_SOLID_HEXAHEDRON, g.quadratic);
    assert_int_equal(mesh.solid_count, solids);
    assert_int_equal(mesh.solid_form[solids - 1], form);
    assert_int_equal(thrum_mesh_solid_nodes(&mesh), solids * thrum_solid_forms[form].nodes);
    assert_int_equal(mesh.solid_tet_ends[solids - 1], mesh.tet_count);
    assert_null(mesh.midsides);
    assert_int_equal(mesh.flipped_tets, 0);
    assert_int_equal(mesh.note_count, g.wedges && !g.quadratic ? 1 : 0);

    // faces of neighbours are cut alike, into two triangles, or six, or four of a triangle
    const int64_t squares = (int64_t)CELLS * CELLS * (g.wedges ? 4 : 6);
    const int64_t halves = (int64_t)CELLS * CELLS * (g.wedges ? 4 : 0);
    assert_int_equal(examined.surface_triangles,
                     g.quadratic ? 6 * squares + 4 * halves : 2 * squares + halves);
    assert_int_equal(examined.genus, 0);
    assert_true(fabs(examined.volume / exact_volume(&g) - 1) < 1e-13);
    thrum_mesh_free(&mesh);
  }
}

/* A cube that is wound the other way is reflected; one that is a wedge, and one with a pyramid on
 * top, are cut. */
static void solids_are_turned_or_cut_where_they_must_be(void **state) {
  (void)state;
  static const char nodes[] = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n"
                              "7,1,1,1\n8,0,1,1\n9,.5,.5,2\n";
  char text[1000];
  snprintf(text, sizeof text, "%s*ELEMENT, TYPE=C3D8\n1,5,6,7,8,1,2,3,4\n", nodes);
  thrum_mesh mesh = read_as(text, THRUM_ELEMENT_SOLID);
  assert_int_equal(mesh.solid_count, 1);
  for (int n = 0; n < 8; n++)
    assert_int_equal(mesh.solid_nodes[n], n);
  assert_int_equal(mesh.flipped_tets, mesh.tet_count);
  thrum_mesh_free(&mesh);

  static const char *const others[] = {"*ELEMENT, TYPE=C3D8\n1,1,2,3,3,5,6,7,7\n",
                                       "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n"
                                       "*ELEMENT, TYPE=C3D5\n2,5,6,7,8,9\n"};
  for (int n = 0; n < 2; n++) {
    snprintf(text, sizeof text, "%s%s", nodes, others[n]);
    mesh = read_as(text, THRUM_ELEMENT_AUTO);
    assert_int_equal(mesh.solid_count, 0);
    assert_int_equal(mesh.note_count, 1);
    thrum_mesh_free(&mesh);

    // who asks for solids is not given others
    const thrum_mesh_read_options solid = {.scale = 1, .element = THRUM_ELEMENT_SOLID};
    thrum_error error = {0};
    mesh = read_as(text, THRUM_ELEMENT_SOLID);
    assert_int_equal(thrum_mesh_check_kept("a.inp", &solid, &mesh, &error), THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "or some with a node twice"));
    thrum_mesh_free(&mesh);
    assert_int_equal(thrum_mesh_read_with("beam:2x1x1@1x1x1", &solid, &mesh, &error), THRUM_OK);
    assert_int_equal(thrum_mesh_check_kept("beam", &solid, &mesh, &error), THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "it has tetrahedra alone"));
    thrum_mesh_free(&mesh);
  }
}

/* A cube as six pyramids to its centre, and a hexahedron on top of one of them. */
static void pyramids_meet_hexahedra(void **state) {
  (void)state;
  static const char nodes[] =
      "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,.5,.5,.5\n"
      "10,0,0,2\n11,1,0,2\n12,1,1,2\n13,0,1,2\n";
  char text[2000];

  // the faces of the cube are each the foot of a pyramid, and the upper one is the hexahedron's too
  snprintf(
      text, sizeof text,
      "%s*ELEMENT, TYPE=C3D5\n1,1,2,3,4,9\n2,8,7,6,5,9\n3,5,6,2,1,9\n4,6,7,3,2,9\n5,7,8,4,3,9\n"
      "6,8,5,1,4,9\n*ELEMENT, TYPE=C3D8\n7,5,6,7,8,10,11,12,13\n",
      nodes);
  thrum_mesh mesh = mesh_good("a.inp", text);
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(mesh.tet_count, 18);
  assert_int_equal(examined.surface_triangles, 20);
  assert_true(fabs(examined.volume - 2) < 1e-14);
  assert_string_equal(mesh.notes[0].text,
                      "6 pyramids, 1 hexahedra were cut into 18 tetrahedra of four nodes");
  thrum_mesh_free(&mesh);
}

#define CUBE                                                                                       \
  "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n8,0,1,1\n9,2,0,0\n10,2,"  \
  "0,1\n"

static void a_wedge_may_be_written_as_a_hexahedron(void **state) {
  (void)state;

  // corners 3 and 4 are one, and so are 7 and 8
  thrum_mesh mesh = mesh_good("a.inp", CUBE "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n"
                                            "2,2,9,3,3,6,10,7,7\n");
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(mesh.tet_count, 9);
  assert_int_equal(examined.surface_triangles, 10 + 2 * 2 + 2);
  assert_true(fabs(examined.volume - 1.5) < 1e-14);
  thrum_mesh_free(&mesh);
}

static void bad_elements_are_refused_with_their_number_and_line(void **state) {
  (void)state;
  mesh_bad("a.inp", CUBE "*ELEMENT, TYPE=C3D8\n71,1,2,3,3,1,2,3,3\n",
           "a.inp:13: element 71 has no volume");
  mesh_bad("a.inp", CUBE "*ELEMENT, TYPE=C3D8\n70,1,2,3,4,5,6,7,8\n71,2,9,3,99,6,10,7,7\n",
           "a.inp:14: element 71 names vertex 99, which is not in the file");
  mesh_bad("a.inp", CUBE "*ELEMENT, TYPE=C3D20\n71,1,2,3,4,5,6,7,8,1,2,3,4,5,6,7,8,1,2,3\n",
           "element 71 has too few nodes: 19, not 20");

  // twisted so far that its parts overlap
  mesh_bad("a.inp", CUBE "*ELEMENT, TYPE=C3D8\n71,1,2,3,4,7,8,5,6\n",
           "a.inp:13: element 71 is too warped to be cut into tetrahedra, or its nodes are in "
           "another order");

  // linear hexahedra beside tets of ten nodes
  mesh_bad("a.inp",
           CUBE "11,.5,0,0\n*ELEMENT, TYPE=C3D8\n70,1,2,3,4,5,6,7,8\n*ELEMENT, TYPE=C3D10\n"
                "71,1,2,3,4,5,6,7,8,9,10\n",
           "a.inp:16: element 71 has middle nodes, where those before it have none");
}

/* A wedge of fifteen nodes as VTK and as Gmsh wind it. */
static void wedges_of_vtk_may_be_wound_either_way(void **state) {
  (void)state;
  static const char *const cells[] = {"0 1 2 3 4 5 6 7 8 9 10 11 12 13 14",
                                      "0 2 1 3 5 4 8 7 6 11 10 9 12 14 13"};

  // either way it is the same body, and nothing is counted as inside out
  for (int n = 0; n < 2; n++) {
    char text[1000];
    snprintf(text, sizeof text,
             "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 15 double\n"
             "0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1 .5 0 0 .5 .5 0 0 .5 0 .5 0 1 .5 .5 1 0 .5 1\n"
             "0 0 .5 1 0 .5 0 1 .5\nCELLS 1 16\n15 %s\nCELL_TYPES 1\n26\n",
             cells[n]);
    thrum_mesh mesh = mesh_good("a.vtk", text);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
    assert_int_equal(mesh.tet_count, 3);
    assert_int_equal(mesh.flipped_tets, 0);
    assert_true(fabs(examined.volume - 0.5) < 1e-15);
    thrum_mesh_free(&mesh);
  }
}

/* Wedges of six nodes that are not thin bend too stiffly: all is cut unless they are asked for. */
static void thick_wedges_are_cut_by_default(void **state) {
  (void)state;
  grid g = {.wedges = true};
  number(&g, 1);
  thrum_mesh mesh = read_grid(&g, THRUM_ELEMENT_AUTO);
  assert_int_equal(mesh.solid_count, 0);
  assert_int_equal(mesh.tet_count, 3 * 2 * CELLS * CELLS * CELLS);
  assert_int_equal(mesh.note_count, 1);
  assert_non_null(strstr(mesh.notes[0].text, "54 are wedges of six nodes, which bend too stiffly"));
  thrum_mesh_free(&mesh);
}

/* A thin sheet of 2 x 1 cells: two wedges, and a hexahedron or two wedges more, in one layer or
 * two. */
static int write_sheet(char *text, bool hexahedron, int layers) {
  int used = sprintf(text, "*NODE\n");
  for (int k = 0; k <= layers; k++)
    for (int j = 0; j < 2; j++)
      for (int i = 0; i < 3; i++)
        used += sprintf(text + used, "%d,%d,%d,%g\n", 1 + i + 3 * j + 6 * k, i, j, 0.1 * k);
  static const int wedges[4][3] = {{1, 2, 5}, {1, 5, 4}, {2, 3, 6}, {2, 6, 5}};
  int count = 0;
  used += sprintf(text + used, "*ELEMENT, TYPE=C3D6\n");
  for (int k = 0; k < layers; k++)
    for (int w = 0; w < (hexahedron ? 2 : 4); w++) {
      const int *n = wedges[w], up = 6 * (k + 1), low = 6 * k;
      used += sprintf(text + used, "%d,%d,%d,%d,%d,%d,%d\n", ++count, n[0] + low, n[1] + low,
                      n[2] + low, n[0] + up, n[1] + up, n[2] + up);
    }
  if (hexahedron)
    used += sprintf(text + used, "*ELEMENT, TYPE=C3D8\n%d,2,3,6,5,8,9,12,11\n", ++count);
  return used + sprintf(text + used, "*NSET, NSET=edge\n1,2,3\n*NSET, NSET=face\n1,2,5\n");
}

static const thrum_group *group_of(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  fail_msg("no group %s", name);
  return NULL;
}

/* Thin wedges are three solid-shell hexahedra each, and neighbours agree on their new nodes. */
static void thin_wedges_are_divided(void **state) {
  (void)state;
  for (int n = 0; n < 3; n++) {
    const bool hexahedron = n == 1;
    const int layers = n == 2 ? 2 : 1;
    char text[4000];
    write_sheet(text, hexahedron, layers);
    thrum_mesh mesh = read_as(text, THRUM_ELEMENT_AUTO);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
    assert_int_equal(mesh.solid_count, hexahedron ? 6 + 4 : 12 * layers);
    for (int64_t s = 0; s < mesh.solid_count; s++)
      assert_int_equal(mesh.solid_form[s], THRUM_FORM_SHELL8);

    // Euler: V - E + F of a sheet is 1; a layer of nodes has its vertices, edges and faces
    const int faces = hexahedron ? 3 : 4, edges = 6 + faces - 1;
    assert_int_equal(mesh.vertex_count, (layers + 1) * (6 + edges + faces));
    assert_int_equal(examined.genus, 0);
    assert_true(fabs(examined.volume - 0.2 * layers) < 1e-15);
    assert_int_equal(examined.surface_triangles,
                     2 * 2 * (hexahedron ? 10 : 12) + 2 * 2 * 6 * layers);

    // a node joins a group with the vertices of its edge or face: 2 edges; 3 edges and a face
    assert_int_equal(group_of(&mesh, "edge")->count, 3 + 2);
    assert_int_equal(group_of(&mesh, "face")->count, 3 + 3 + 1);
    thrum_mesh_free(&mesh);
  }
}

/* Elements come back from each format as they were, in their order. */
static void solids_are_written_as_what_they_are(void **state) {
  (void)state;
  static const char *const names[] = {"b.inp", "b.vtu", "b.vtk", "b.msh", "b.mesh"};
  for (int n = 0; n < 4; n++) {
    grid g = {.quadratic = n & 1, .wedges = n & 2};
    number(&g, (uint64_t)n);
    thrum_mesh mesh = read_grid(&g, THRUM_ELEMENT_SOLID);
    for (int f = 0; f < 2 * 5; f++) {
      const thrum_mesh_write_options options = {
          .binary = f >= 5, .ascii = f < 5, .msh_version = f >= 5 ? 22 : 41};
      const thrum_mesh_read_options kept = {.scale = 1, .element = THRUM_ELEMENT_SOLID};
      char name[100];
      snprintf(name, sizeof name, "%s/%s", mesh_folder, names[f % 5]);
      thrum_mesh_lost lost;
      thrum_mesh back = {0};
      thrum_error error = {0};
      const thrum_status status = thrum_mesh_write(name, &mesh, &options, &lost, &error);
      if (f % 5 == 4 && g.quadratic) {
        assert_int_equal(status, THRUM_UNSUPPORTED);
        continue;
      }
      if (status < 0 || thrum_mesh_read_with(name, &kept, &back, &error) < 0)
        fail_msg("%s", error.message);
      assert_int_equal(back.solid_count, mesh.solid_count);
      assert_true(thrum_mesh_hash(&back) == thrum_mesh_hash(&mesh));
      remove(name);
      thrum_mesh_free(&back);
    }

    // these have tetrahedra alone
    thrum_error error = {0};
    thrum_mesh_lost lost;
    assert_int_equal(
        thrum_mesh_write("b.veg", &mesh, &(thrum_mesh_write_options){0}, &lost, &error),
        THRUM_UNSUPPORTED);
    thrum_mesh_free(&mesh);
  }
}

/* A list of held vertices holds what was made between them, and nothing else. */
static void what_was_made_is_held_with_its_vertices(void **state) {
  (void)state;
  char text[4000];
  write_sheet(text, false, 1);
  thrum_mesh mesh = read_as(text, THRUM_ELEMENT_AUTO);
  uint8_t *marks = calloc((size_t)mesh.vertex_count, 1);
  assert_non_null(marks);
  static const int given[3] = {0, 1, 4};
  for (int n = 0; n < 3; n++)
    marks[given[n]] = 1;
  thrum_mesh_mark_divided(&mesh, marks);
  int64_t count = 0;
  for (int64_t v = 0; v < mesh.vertex_count; v++)
    count += marks[v];
  assert_int_equal(count, 3 + 3 + 1);
  free(marks);
  thrum_mesh_free(&mesh);
}

/* A hexahedron with a corner of nearly 180 degrees is flagged as a sliver is. */
static void a_squashed_hexahedron_is_flagged(void **state) {
  (void)state;
  for (int n = 0; n < 2; n++) {
    char text[400], line[300];
    snprintf(text, sizeof text,
             "*NODE\n1,0,0,0\n2,1,0,0\n3,%g,%g,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,%g,%g,1\n8,0,1,1\n"
             "*ELEMENT, TYPE=C3D8\n1,1,2,3,4,5,6,7,8\n",
             n ? 0.51 : 1.0, n ? 0.51 : 1.0, n ? 0.51 : 1.0, n ? 0.51 : 1.0);
    thrum_mesh mesh = read_as(text, THRUM_ELEMENT_SOLID);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
    assert_int_equal((thrum_mesh_flags(&mesh, &examined) & THRUM_EXAMINE_SLIVERS) != 0, n);
    assert_non_null(strstr(thrum_mesh_flag_line(&mesh, &examined, THRUM_EXAMINE_SLIVERS, line),
                           "element has a scaled Jacobian"));
    thrum_mesh_free(&mesh);
  }
}

static void elements_that_stay_have_the_order_of_the_file(void **state) {
  (void)state;
  char text[4000];
  write_sheet(text, true, 1);
  const thrum_mesh_read_options options = {.scale = 1, .order = 2, .element = THRUM_ELEMENT_SHELL};
  const char *path = mesh_write("a.inp", text, strlen(text));
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, &error), THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "--order 2"));

  // those that have middle nodes may be read without, which is no fault of the file
  grid g = {.quadratic = true};
  number(&g, 1);
  mesh = read_grid(&g, THRUM_ELEMENT_SOLID);
  thrum_mesh_free(&mesh);
  const thrum_mesh_read_options corners = {.scale = 1, .order = 1, .element = THRUM_ELEMENT_SOLID};
  assert_int_equal(thrum_mesh_read_with(path, &corners, &mesh, &error), THRUM_OK);
  thrum_mesh_examined examined;
  assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
  assert_int_equal(mesh.solid_form[0], THRUM_FORM_HEX8);
  assert_int_equal(mesh.cornered_tets, mesh.tet_count);
  assert_true((thrum_mesh_flags(&mesh, &examined) & THRUM_EXAMINE_REPAIRED) == 0);
  thrum_mesh_free(&mesh);
}

/* A box has 1 however thin it is, and a corner that leans by 60 degrees the cosine of it. */
static void the_shape_of_a_solid_is_that_of_its_corners(void **state) {
  (void)state;
  double places[8][3] = {{0, 0, 0},    {1, 0, 0},    {1, 1, 0},    {0, 1, 0},
                         {0, 0, 1e-3}, {1, 0, 1e-3}, {1, 1, 1e-3}, {0, 1, 1e-3}};
  static const int32_t nodes[8] = {0, 1, 2, 3, 4, 5, 6, 7}, wedge[6] = {0, 1, 2, 4, 5, 6};
  const thrum_solid hexahedron = THRUM_SOLID_HEXAHEDRON;
  assert_true(fabs(thrum_solid_shape_measure(hexahedron, places[0], nodes) - 1) < 1e-15);
  assert_true(fabs(thrum_solid_shape_measure(THRUM_SOLID_WEDGE, places[0], wedge) -
                   sqrt(0.5) / sqrt(0.75)) < 1e-14);
  for (int n = 4; n < 8; n++)
    places[n][0] += 1e-3 * sqrt(3.0);
  assert_true(fabs(thrum_solid_shape_measure(hexahedron, places[0], nodes) - 0.5) < 1e-12);
  for (int n = 4; n < 8; n++)
    places[n][2] = -1e-3;
  assert_true(thrum_solid_shape_measure(hexahedron, places[0], nodes) < 0);
  static const double tet[4][3] = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  assert_true(fabs(thrum_solid_shape_measure(THRUM_SOLID_TET, tet[0], nodes) - 1) < 1e-14);
}

static void a_beam_may_be_of_hexahedra(void **state) {
  (void)state;
  const thrum_mesh_read_options kept = {.scale = 1, .element = THRUM_ELEMENT_AUTO};
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read_with("beam:4x1x3@1x0.02x0.6,hex", &kept, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.solid_count, 12);
  assert_int_equal(mesh.tet_count, 72);

  // thin across y, which comes last; all are wound as they should be
  for (int64_t s = 0; s < mesh.solid_count; s++) {
    const int32_t *node = mesh.solid_nodes + 8 * s;
    assert_int_equal(mesh.solid_form[s], THRUM_FORM_SHELL8);
    const double *from = mesh.vertices + 3 * (int64_t)node[0];
    double edge[3][3], cross[3];
    thrum_subtract3(mesh.vertices + 3 * (int64_t)node[1], from, edge[0]);
    thrum_subtract3(mesh.vertices + 3 * (int64_t)node[3], from, edge[1]);
    thrum_subtract3(mesh.vertices + 3 * (int64_t)node[4], from, edge[2]);
    thrum_cross3(edge[0], edge[1], cross);
    assert_true(fabs(thrum_dot3(cross, edge[2]) - 0.25 * 0.02 * 0.2) < 1e-15);
    assert_true(fabs(fabs(edge[2][1]) - 0.02) < 1e-15);
  }
  thrum_mesh_free(&mesh);

  // what takes tetrahedra alone has its cut, and says so
  const thrum_mesh_read_options cut = {.scale = 1, .tets_for = "points take"};
  assert_int_equal(thrum_mesh_read_with("beam:4x1x3@1x0.02x0.6,hex", &cut, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.solid_count, 0);
  assert_string_equal(mesh.notes[0].text, "12 hexahedra were cut into 72 tetrahedra; points take "
                                          "tetrahedra alone");
  thrum_mesh_free(&mesh);

  // commands that want tetrahedra have it, too
  assert_int_equal(thrum_mesh_read("beam:4x1x3@1x0.02x0.6,hex", 1, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.solid_count, 0);
  assert_int_equal(mesh.tet_count, 72);
  thrum_mesh_free(&mesh);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(elements_are_cut_conformingly_whatever_their_numbers),
      cmocka_unit_test(solids_stay_with_tets_for_their_shape),
      cmocka_unit_test(solids_are_turned_or_cut_where_they_must_be),
      cmocka_unit_test(pyramids_meet_hexahedra),
      cmocka_unit_test(a_wedge_may_be_written_as_a_hexahedron),
      cmocka_unit_test(wedges_of_vtk_may_be_wound_either_way),
      cmocka_unit_test(thick_wedges_are_cut_by_default),
      cmocka_unit_test(thin_wedges_are_divided),
      cmocka_unit_test(what_was_made_is_held_with_its_vertices),
      cmocka_unit_test(a_squashed_hexahedron_is_flagged),
      cmocka_unit_test(elements_that_stay_have_the_order_of_the_file),
      cmocka_unit_test(solids_are_written_as_what_they_are),
      cmocka_unit_test(the_shape_of_a_solid_is_that_of_its_corners),
      cmocka_unit_test(a_beam_may_be_of_hexahedra),
      cmocka_unit_test(bad_elements_are_refused_with_their_number_and_line),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
