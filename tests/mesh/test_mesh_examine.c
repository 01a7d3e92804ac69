/* The examination of meshes that are whole, in pieces, hollow, hinged, far away or in unusual
 * units; and input that is unusual in its text alone. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>
#include <sys/stat.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_flags.h"
#include "mesh/mesh_thickness.h"

static thrum_mesh beam(const char *spec) {
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read(spec, 1, &mesh, NULL), THRUM_OK);
  return mesh;
}

/* Keeps the tetrahedra of the cells that `keep` marks in a body of nx x ny cells of unit size. */
static void keep_cells(thrum_mesh *mesh, const char *keep, int ny) {
  int64_t kept = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    double centre[2] = {0, 0};
    for (int a = 0; a < 4; a++)
      for (int c = 0; c < 2; c++)
        centre[c] += mesh->vertices[3 * (int64_t)mesh->tets[4 * t + a] + c] / 4;
    const int cell = (int)centre[0] * ny + (int)floor(centre[1] + ny / 2.0);
    if (keep[cell] == '#')
      memmove(mesh->tets + 4 * kept++, mesh->tets + 4 * t, 4 * sizeof *mesh->tets);
  }
  mesh->tet_count = kept;
  assert_int_equal(thrum_mesh_clean(mesh, "cells", 1, NULL), THRUM_OK);
}

static thrum_mesh_examined examine(const thrum_mesh *mesh) {
  thrum_mesh_examined examined;
  thrum_error error = {0};
  if (thrum_mesh_examine(mesh, &examined, &error) < 0)
    fail_msg("%s", error.message);
  return examined;
}

/* The flags of a mesh; each flag has a line of text. */
static unsigned flags_of(const thrum_mesh *mesh) {
  const thrum_mesh_examined e = examine(mesh);
  const unsigned flags = thrum_mesh_flags(mesh, &e);
  for (unsigned bit = 1; bit <= flags; bit *= 2) {
    char line[300] = "";
    if (flags & bit)
      assert_true(strlen(thrum_mesh_flag_line(mesh, &e, (thrum_examine_flag)bit, line)) > 20);
  }
  return flags;
}

static void a_block_is_one_piece_with_one_closed_surface(void **state) {
  (void)state;
  thrum_mesh mesh = beam("beam:4x3x3@1x0.5x0.5");
  const thrum_mesh_examined e = examine(&mesh);

  // topology: one piece, one surface without holes
  assert_int_equal(e.pieces, 1);
  assert_int_equal(e.largest_piece, mesh.tet_count);
  assert_int_equal(e.surfaces, 1);
  assert_int_equal(e.genus, 0);
  assert_int_equal(e.hinges, 0);
  assert_int_equal(e.coincident_vertices, 0);

  // two triangles for each cell side, and 3 x 2 x 2 vertices inside
  assert_int_equal(e.surface_triangles, 2 * (2 * 9 + 4 * 12));
  assert_int_equal(e.interior_vertices, 12);

  // geometry
  assert_true(fabs(e.volume - 0.25) < 1e-14);
  assert_true(fabs(e.mass - 250) < 1e-11);
  assert_true(e.extent == 1);

  // quality: every tetrahedron is counted in the histogram, and the worst come first
  int64_t sum = 0;
  for (int b = 0; b < THRUM_EXAMINE_BINS; b++)
    sum += e.histogram[b];
  assert_int_equal(sum, mesh.tet_count);
  assert_true(e.worst_ratio[0] == e.ratio_min && e.worst_ratio[0] <= e.worst_ratio[4]);

  assert_int_equal(flags_of(&mesh), 0);

  thrum_mesh_free(&mesh);
}

static void holes_through_and_inside_the_body_are_counted(void **state) {
  (void)state;

  // a ring has one hole through it
  thrum_mesh ring = beam("beam:3x3x1@3x3x1");
  keep_cells(&ring, "####.####", 3);
  thrum_mesh_examined e = examine(&ring);
  assert_int_equal(e.genus, 1);
  assert_int_equal(e.surfaces, 1);
  assert_int_equal(e.pieces, 1);
  thrum_mesh_free(&ring);

  // a block without its middle cell has a second surface inside
  thrum_mesh hollow = beam("beam:3x3x3@3x3x3");
  int64_t kept = 0;
  for (int64_t t = 0; t < hollow.tet_count; t++) {
    double centre[3] = {-1.5, 0, 0};
    for (int i = 0; i < 12; i++)
      centre[i % 3] += hollow.vertices[3 * (int64_t)hollow.tets[4 * t + i / 3] + i % 3] / 4;
    if (fmax(fmax(fabs(centre[0]), fabs(centre[1])), fabs(centre[2])) > 0.5)
      memmove(hollow.tets + 4 * kept++, hollow.tets + 4 * t, 4 * sizeof *hollow.tets);
  }

  hollow.tet_count = kept;
  e = examine(&hollow);
  assert_int_equal(e.surfaces, 2);
  assert_int_equal(e.genus, 0);

  thrum_mesh_free(&hollow);
}

static void pieces_and_hinges_are_flagged(void **state) {
  (void)state;

  // two pieces without contact
  thrum_mesh apart = beam("beam:3x1x1@3x1x1");
  keep_cells(&apart, "#.#", 1);
  thrum_mesh_examined e = examine(&apart);
  assert_int_equal(e.pieces, 2);
  assert_int_equal(e.surfaces, 2);
  assert_true(flags_of(&apart) & THRUM_EXAMINE_PIECES);
  thrum_mesh_free(&apart);

  // two columns that share an edge
  thrum_mesh hinged = beam("beam:2x2x1@2x2x1");
  keep_cells(&hinged, "#..#", 2);
  e = examine(&hinged);
  assert_int_equal(e.pieces, 1);
  assert_int_equal(e.hinges, 1);
  assert_int_equal(e.genus, -1);
  assert_true(flags_of(&hinged) & THRUM_EXAMINE_HINGES);

  thrum_mesh_free(&hinged);
}

/* Two tetrahedra that touch in a face, each with vertices of its own. */
static void vertices_on_top_of_each_other_are_flagged(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "two.veg", "*VERTICES\n8 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 0 0\n6 1 1 1\n"
                 "7 0 1 0\n8 0 0 1\n*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 5 6 7 8\n");
  const thrum_mesh_examined e = examine(&mesh);
  assert_int_equal(e.coincident_vertices, 3);
  assert_int_equal(e.pieces, 2);
  assert_true(flags_of(&mesh) & THRUM_EXAMINE_COINCIDENT);
  thrum_mesh_free(&mesh);
}

static void units_places_and_materials_out_of_the_ordinary_are_flagged(void **state) {
  (void)state;
  static const struct {
    double scale, shift, poisson, density, young;
    unsigned flag;
  } cases[] = {{1000, 0, 0.3, 1000, 1e6, THRUM_EXAMINE_UNITS},
               {21, 0, 0.3, 1000, 1e6, THRUM_EXAMINE_UNITS},
               {19, 0, 0.3, 1000, 1e6, 0},
               {0.0009, 0, 0.3, 1000, 1e6, THRUM_EXAMINE_UNITS},
               {0.002, 0, 0.3, 1000, 1e6, 0},
               {1, 1e9, 0.3, 1000, 1e6, THRUM_EXAMINE_FAR},
               {1, 0, 0.49, 1000, 1e6, THRUM_EXAMINE_LOCKING},
               {1, 0, 0.3, 7.85e-9, 1e6, THRUM_EXAMINE_DENSITY},
               {1, 1, 0.3, 1000, 1e6, 0},
               // steel and aluminium in MPa, a gel, a filled rubber, diamond, and what is none
               {1, 0, 0.3, 7850, 2.1e5, THRUM_EXAMINE_MODULUS},
               {1, 0, 0.3, 2700, 7e4, THRUM_EXAMINE_MODULUS},
               {1, 0, 0.3, 1000, 50, 0},
               {1, 0, 0.3, 3500, 1e6, 0},
               {1, 0, 0.3, 3500, 1.2e12, 0},
               {1, 0, 0.3, 1000, 1, THRUM_EXAMINE_MODULUS},
               {1, 0, 0.3, 7850, 2.1e17, THRUM_EXAMINE_MODULUS}};

  // every oddity is flagged, and nothing else
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    thrum_mesh mesh = beam("beam:4x3x3@1x0.5x0.5");
    for (int64_t n = 0; n < 3 * mesh.vertex_count; n++)
      mesh.vertices[n] = cases[i].scale * mesh.vertices[n] + cases[i].shift;
    mesh.materials[0].poisson = cases[i].poisson;
    mesh.materials[0].density = cases[i].density;
    mesh.materials[0].young = cases[i].young;
    assert_int_equal(flags_of(&mesh), cases[i].flag);
    thrum_mesh_free(&mesh);
  }
}

/* The strain at the foot of a column is its weight over its section and Young's modulus. */
static void a_column_is_compressed_by_its_own_weight(void **state) {
  (void)state;
  thrum_mesh mesh = beam("beam:3x1x1@1x0.1x0.1");
  mesh.materials[0] = (thrum_material){2e11, 0.3, 7850};
  assert_true(fabs(thrum_mesh_weight_strain(&mesh, 100) - 7850 * 9.81 * 100 / 2e11) < 1e-18);
  mesh.has_material = false;
  assert_true(thrum_mesh_weight_strain(&mesh, 100) == 0);
  thrum_mesh_free(&mesh);
}

static void cells_are_counted_over_the_thickness(void **state) {
  (void)state;
  static const struct {
    const char *beam;
    double cells;
  } cases[] = {{"beam:10x1x1@1x0.1x0.1", 1},
               {"beam:20x2x2@1x0.1x0.1", 2},
               {"beam:40x4x4@1x0.1x0.1", 4},
               {"beam:80x8x8@1x0.1x0.1", 8},
               {"beam:20x20x3@1x1x0.05", 3},
               {"beam:12x5x2@1x0.5x0.1", 2},
               {"beam:20x20x20@1x1x1", THRUM_THICKNESS_CELLS_MAX}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++)
    for (int order = 1; order <= 2; order++) {
      thrum_mesh mesh = {0};
      thrum_mesh_examined examined;
      assert_int_equal(thrum_mesh_read_order(cases[n].beam, 1, order, &mesh, NULL), THRUM_OK);
      assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
      assert_true(examined.cells_across == cases[n].cells);
      thrum_mesh_free(&mesh);
    }

  // as cantilevers of nu = 0.4 err: 107, 39, 12 and 3.4 %
  assert_true(fabs(thrum_bending_error(1) - 1.07) < 0.2);
  assert_true(fabs(thrum_bending_error(2) - 0.39) < 0.05);
  assert_true(fabs(thrum_bending_error(4) - 0.121) < 0.01);
  assert_true(fabs(thrum_bending_error(8) - 0.034) < 0.004);
}

static void thin_and_flat_meshes_are_flagged(void **state) {
  (void)state;
  thrum_mesh plate = beam("beam:8x8x1@1x1x0.1");
  assert_int_equal(flags_of(&plate), THRUM_EXAMINE_THIN);
  thrum_mesh_free(&plate);
  thrum_mesh sliver = mesh_good("s.veg", "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                                         "4 0.3 0.3 0.0001\n*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n");
  assert_true(flags_of(&sliver) & THRUM_EXAMINE_SLIVERS);
  thrum_mesh_free(&sliver);
}

static void repairs_are_flagged(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("r.veg", "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                                       "5 1 1 1\n*ELEMENTS\nTET\n1 4 0\n1 1 3 2 4\n");
  assert_true(flags_of(&mesh) & THRUM_EXAMINE_REPAIRED);
  thrum_mesh_free(&mesh);
}

/* The formats, each with a valid beginning. */
static const struct {
  const char *name, *head;
} FORMATS[] = {{"x.veg", "*VERTICES\n4 3 0 0\n1 "},
               {"x.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 "},
               {"x.mesh", "MeshVersionFormatted 2\nVertices 4\n"},
               {"x.node", "4 3 0 0\n0 "},
               {"x.vtk", "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                         "POINTS 4 double\n"},
               {"x.vtu", "<VTKFile type=\"UnstructuredGrid\"><Piece NumberOfPoints=\"4\" "
                         "NumberOfCells=\"1\"><Points><DataArray type=\"Float64\">"},
               {"x.inp", "*NODE\n1, "}};
enum { FORMAT_COUNT = sizeof FORMATS / sizeof *FORMATS };

static void a_line_of_a_million_characters_is_refused_in_a_short_one(void **state) {
  (void)state;
  enum { LENGTH = 1000000 };
  char *text = malloc(LENGTH + 1000);
  assert_non_null(text);
  mesh_write_text("x.ele", "1 4 0\n0 0 1 2 3\n");
  for (int i = 0; i < FORMAT_COUNT; i++) {
    size_t used = strlen(FORMATS[i].head);
    memcpy(text, FORMATS[i].head, used);
    memset(text + used, 'x', LENGTH);
    mesh_bad_bytes(FORMATS[i].name, text, used + LENGTH, "xxx...");
  }
  free(text);
}

static void decimal_commas_are_refused(void **state) {
  (void)state;
  char text[1000];
  for (int i = 0; i < FORMAT_COUNT; i++) {
    // where commas part numbers, as in .veg and .inp, one number too many is all there is to see
    if (i == 0 || i == FORMAT_COUNT - 1)
      continue;
    snprintf(text, sizeof text, "%s0,5 0,5 0,5 0,5 0,5 0,5 0,5 0,5 0,5\n", FORMATS[i].head);
    mesh_bad(FORMATS[i].name, text, "0,5");
  }
}

static void a_folder_is_no_mesh(void **state) {
  (void)state;
  for (int i = 0; i < FORMAT_COUNT; i++) {
    char path[200];
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    snprintf(path, sizeof path, "%s/d%s", mesh_folder, FORMATS[i].name + 1);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_int_equal(thrum_mesh_read(path, 1, &mesh, &error), THRUM_IO);
    assert_non_null(strstr(error.message, path));
    assert_int_equal(rmdir(path), 0);
  }
}

#define POINTS_4 "0 0 0 1 0 0 0 1 0 0 0 1"
static void an_index_past_two_to_the_31_is_refused(void **state) {
  (void)state;
  static const struct {
    const char *name, *text, *words;
  } cases[] = {{"y.veg",
                "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n*ELEMENTS\nTET\n1 4 0\n"
                "1 1 2 3 4294967300\n",
                "4294967300, which is out of range"},
               {"y.msh",
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                "4 0 0 1\n$EndNodes\n$Elements\n1\n1 4 0 1 2 3 4294967300\n$EndElements\n",
                "names node 4294967300"},
               {"y.mesh",
                "MeshVersionFormatted 2\nVertices 4\n0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0\n"
                "Tetrahedra 1\n1 2 3 4294967300 0\n",
                "4294967300, which is out of range"},
               // beyond 64 bits as well
               {"z.mesh",
                "MeshVersionFormatted 2\nVertices 4\n0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 0\n"
                "Tetrahedra 1\n1 2 3 18446744073709551621 0\n",
                "18446744073709551621, which is out of range"},
               {"y.vtk",
                "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                "POINTS 4 double\n" POINTS_4 "\nCELLS 1 5\n4 0 1 2 4294967300\nCELL_TYPES 1\n10\n",
                "names a point that is out of range"},
               {"y.vtu",
                "<VTKFile type=\"UnstructuredGrid\"><Piece NumberOfPoints=\"4\" "
                "NumberOfCells=\"1\"><Points><DataArray type=\"Float64\">" POINTS_4
                "</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\">"
                "0 1 2 4294967300</DataArray><DataArray type=\"Int64\" Name=\"offsets\">4"
                "</DataArray><DataArray type=\"Int64\" Name=\"types\">10</DataArray></Cells>"
                "</Piece></VTKFile>",
                "names a point that is out of range"},
               {"y.inp",
                "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n"
                "1,1,2,3,4294967300\n",
                ":7: tet 1 names vertex 4294967300"}};

  // an index must not wrap around to a valid one
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    mesh_bad(cases[i].name, cases[i].text, cases[i].words);

  // TetGen's mesh is a pair of files
  mesh_write_text("y.ele", "1 4 0\n0 0 1 2 4294967300\n");
  mesh_bad("y.node", "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n",
           "y.ele:2: a node of the tet is 4294967300");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_block_is_one_piece_with_one_closed_surface),
      cmocka_unit_test(holes_through_and_inside_the_body_are_counted),
      cmocka_unit_test(pieces_and_hinges_are_flagged),
      cmocka_unit_test(vertices_on_top_of_each_other_are_flagged),
      cmocka_unit_test(units_places_and_materials_out_of_the_ordinary_are_flagged),
      cmocka_unit_test(a_column_is_compressed_by_its_own_weight),
      cmocka_unit_test(cells_are_counted_over_the_thickness),
      cmocka_unit_test(thin_and_flat_meshes_are_flagged),
      cmocka_unit_test(repairs_are_flagged),
      cmocka_unit_test(a_line_of_a_million_characters_is_refused_in_a_short_one),
      cmocka_unit_test(decimal_commas_are_refused),
      cmocka_unit_test(a_folder_is_no_mesh),
      cmocka_unit_test(an_index_past_two_to_the_31_is_refused),
  };

  // one folder holds the meshes of all tests
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
