/* Meshes from the programs that write them: Gmsh in every format that Thrum reads, and TetGen. The
 * arguments are the programs' paths; an absent program is "".
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"
#include "tests/support/test_folder.h"

#include <math.h>

#include "core/base/quadratic_tet.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_groups.h"

static const char *gmsh, *tetgen;

/* Two adjacent boxes: named volumes, and the face x = 0. */
static const char GEOMETRY[] =
    "SetFactory(\"OpenCASCADE\");\nBox(1) = {0,0,0, 1,0.2,0.2};\nBox(2) = {1,0,0, 1,0.2,0.2};\n"
    "BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }\nMesh.MeshSizeMax = 0.2;\n"
    "Physical Volume(\"soft\") = {1};\nPhysical Volume(\"hard\") = {2};\n"
    "Physical Surface(\"held\") = {1};\n";

/* Runs a program in the folder; NULL ends the arguments. */
static void run(const char *program, const char *const *arguments) {
  char *argv[20];
  int count = 0;
  memcpy(&argv[count++], &program, sizeof program);
  for (int i = 0; arguments[i]; i++)
    memcpy(&argv[count++], &arguments[i], sizeof arguments[i]);
  argv[count] = NULL;
  program_result result = program_execute(folder, argv);
  if (result.exit_code != 0)
    fail_msg("%s: %s", program, result.err);
  program_result_free(&result);
}

static thrum_mesh read_mesh(const char *name) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(in_folder(name), 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

static double volume(const thrum_mesh *mesh) {
  double sum = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    sum += thrum_mesh_tet_volume(mesh, t);
  return sum;
}

static int64_t group_count(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return mesh->groups[g].count;
  return 0;
}

static void gmsh_writes_and_we_read_every_format(void **state) {
  (void)state;
  static const struct {
    const char *format, *name, *binary;
    bool named; /* the names of physical groups are in the file */
    int64_t regions;
  } cases[] = {{"msh22", "a.msh", "-v", true, 2},   {"msh41", "b.msh", "-v", true, 2},
               {"msh22", "c.msh", "-bin", true, 2}, {"msh41", "d.msh", "-bin", true, 2},
               {"mesh", "e.mesh", "-v", false, 2},  {"vtk", "f.vtk", "-v", false, 2},
               {"vtk", "g.vtk", "-bin", false, 2},  {"inp", "h.inp", "-v", true, 2}};
  if (!*gmsh)
    return;

  // the geometry for Gmsh
  assert_true(text_file_write(in_folder("two.geo"), GEOMETRY));

  // each format, as text and binary
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const bool text = cases[i].binary[1] == 'v';
    const char *const arguments[] = {"two.geo", "-3",          "-format",       cases[i].format,
                                     "-o",      cases[i].name, cases[i].binary, text ? "0" : NULL,
                                     NULL};
    run(gmsh, arguments);

    // volume and regions as modelled, and the groups where the format names them
    thrum_mesh mesh = read_mesh(cases[i].name);
    assert_true(fabs(volume(&mesh) - 2 * 0.2 * 0.2) < 1e-12);
    assert_int_equal(mesh.region_count, cases[i].regions);
    if (cases[i].named) {
      assert_int_equal(group_count(&mesh, "held"), 5);
      assert_true(group_count(&mesh, "soft") > 8 && group_count(&mesh, "hard") > 8);

      // regions are called by their physical volumes, in decks as well, which have no sections
      assert_string_equal(thrum_mesh_region_text(&mesh, 0).text, "soft");
      assert_string_equal(thrum_mesh_region_text(&mesh, 1).text, "hard");
    }
    thrum_mesh_free(&mesh);
  }
}

/* How far the middle nodes are off the middle of their edges, at most. */
static double farthest_off(const thrum_mesh *mesh) {
  double most = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    for (int e = 0; e < 6; e++) {
      const double *from = mesh->vertices + 3 * mesh->tets[4 * t + thrum_quadratic_edges[e][0]];
      const double *to = mesh->vertices + 3 * mesh->tets[4 * t + thrum_quadratic_edges[e][1]];
      const double *middle = mesh->vertices + 3 * mesh->midsides[6 * t + e];
      for (int axis = 0; axis < 3; axis++)
        most = fmax(most, fabs(middle[axis] - (from[axis] + to[axis]) / 2));
    }
  return most;
}

static void gmsh_writes_ten_nodes_and_we_read_their_order(void **state) {
  (void)state;
  static const struct {
    const char *format, *name, *binary;
  } cases[] = {{"msh22", "q.msh", "0"}, {"msh41", "r.msh", "0"}, {"msh22", "s.msh", "1"},
               {"msh41", "t.msh", "1"}, {"vtk", "u.vtk", "0"},   {"inp", "v.inp", "0"},
               {"mesh", "w.mesh", "0"}};
  if (!*gmsh)
    return;
  assert_true(text_file_write(in_folder("two.geo"), GEOMETRY));
  assert_true(text_file_write(in_folder("ball.geo"),
                              "SetFactory(\"OpenCASCADE\");\nSphere(1) = {0,0,0, 1};\n"
                              "Mesh.MeshSizeMax = 0.5;\nPhysical Volume(\"ball\") = {1};\n"
                              "Physical Surface(\"skin\") = {1};\n"));

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    // straight edges: only the right order has all middle nodes in the middle
    const char *const boxes[] = {"two.geo",       "-3", "-order",      "2",          "-format",
                                 cases[i].format, "-o", cases[i].name, "-setnumber", "Mesh.Binary",
                                 cases[i].binary, NULL};
    run(gmsh, boxes);
    thrum_mesh mesh = read_mesh(cases[i].name);
    assert_non_null(mesh.midsides);
    assert_true(farthest_off(&mesh) < 1e-9);
    assert_true(fabs(volume(&mesh) - 2 * 0.2 * 0.2) < 1e-9);
    if (i < 4) // its middle nodes belong to a face too
      assert_int_equal(group_count(&mesh, "held"), 13);
    thrum_mesh_free(&mesh);

    // curved edges: of 4/3 pi the corners alone lack 8 %
    const char *const ball[] = {"ball.geo",      "-3", "-order",      "2",          "-format",
                                cases[i].format, "-o", cases[i].name, "-setnumber", "Mesh.Binary",
                                cases[i].binary, NULL};
    run(gmsh, ball);
    mesh = read_mesh(cases[i].name);
    assert_true(farthest_off(&mesh) > 0.01);
    assert_true(fabs(volume(&mesh) / (4 * 3.14159265358979 / 3) - 1) < 0.005);
    thrum_mesh_free(&mesh);
  }
}

/* A quarter of a pipe of hexahedra, and beside it one of wedges. */
static const char PIPES[] =
    "SetFactory(\"OpenCASCADE\");\nRectangle(1) = {1,0,0, 1,1};\nRectangle(2) = {4,0,0, 1,1};\n"
    "Transfinite Curve{1:4} = 4; Transfinite Surface{1}; Recombine Surface{1};\n"
    "Mesh.MeshSizeMax = 0.4;\n"
    "a[] = Extrude{{0,1,0}, {0,0,0}, Pi/2}{ Surface{1}; Layers{5}; Recombine; };\n"
    "b[] = Extrude{{0,1,0}, {0,0,0}, Pi/2}{ Surface{2}; Layers{20}; Recombine; };\n"
    "Physical Volume(\"inner\") = {a[1]};\nPhysical Volume(\"outer\") = {b[1]};\n"
    "Physical Surface(\"held\") = {1,2};\n";

static void gmsh_writes_hexahedra_and_wedges_and_we_cut_them(void **state) {
  (void)state;
  static const struct {
    const char *format, *name, *binary, *order, *incomplete;
  } cases[] = {{"msh22", "a1.msh", "0", "1", "1"}, {"msh41", "b1.msh", "1", "1", "1"},
               {"vtk", "c1.vtk", "0", "1", "1"},   {"inp", "d1.inp", "0", "1", "1"},
               {"msh22", "a2.msh", "1", "2", "1"}, {"msh41", "b2.msh", "0", "2", "1"},
               {"vtk", "c2.vtk", "0", "2", "1"},   {"inp", "d2.inp", "0", "2", "1"},
               {"msh22", "a3.msh", "0", "2", "0"}, {"msh41", "b3.msh", "1", "2", "0"},
               {"vtk", "c3.vtk", "0", "2", "0"}};
  if (!*gmsh)
    return;
  assert_true(text_file_write(in_folder("pipes.geo"), PIPES));

  // a quarter turn of a square of 1 m^2 about an axis at 1.5 and 4.5 m
  const double exact = 3.14159265358979 / 2 * (1.5 + 4.5);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const char *const arguments[] = {"pipes.geo",
                                     "-3",
                                     "-order",
                                     cases[i].order,
                                     "-format",
                                     cases[i].format,
                                     "-o",
                                     cases[i].name,
                                     "-setnumber",
                                     "Mesh.Binary",
                                     cases[i].binary,
                                     "-setnumber",
                                     "Mesh.SecondOrderIncomplete",
                                     cases[i].incomplete,
                                     NULL};
    run(gmsh, arguments);
    thrum_mesh mesh = read_mesh(cases[i].name);
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);

    // linear elements lack volume; a node in the wrong place would show in it, or turn a tet over
    const bool quadratic = cases[i].order[0] == '2';
    assert_int_equal((mesh.midsides != NULL), quadratic);
    const double off = examined.volume / exact - 1;
    if (quadratic ? !(fabs(off) < 2e-4) : !(off < -1e-3 && off > -0.02))
      fail_msg("%s: volume %.9g of %.9g", cases[i].name, examined.volume, exact);

    // two whole bodies: no face is left open between neighbours
    assert_int_equal(examined.pieces, 2);
    assert_int_equal(examined.surfaces, 2);
    assert_int_equal(mesh.flipped_tets, 0);
    assert_true(mesh.note_count > 0 && strstr(mesh.notes[0].text, " hexahedra were cut into "));

    // nodes of faces belong to the group of their face, made ones too
    if (i < 2)
      assert_true(group_count(&mesh, "held") > 2 * 16);
    thrum_mesh_free(&mesh);
  }
}

static void gmsh_reads_the_ten_nodes_that_we_write(void **state) {
  (void)state;
  if (!*gmsh)
    return;
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read_order("beam:3x2x2@1x0.3x0.3", 1, 2, &mesh, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_add_region_group(&mesh, 0, "body", NULL), THRUM_OK);
  for (int n = 0; n < 5; n++) {
    const thrum_mesh_write_options options = {.binary = n % 2, .msh_version = n < 2 ? 22 : 41};
    const char *ours = n < 4 ? "ours.msh" : "ours.mesh";
    thrum_mesh_lost lost;
    assert_int_equal(thrum_mesh_write(in_folder(ours), &mesh, &options, &lost, NULL), THRUM_OK);

    // as another format, into whose order Gmsh turns the nodes
    const char *const arguments[] = {ours, "-save", "-format", "vtk", "-o", "theirs.vtk", NULL};
    run(gmsh, arguments);
    thrum_mesh read = read_mesh("theirs.vtk");
    assert_int_equal(read.vertex_count, mesh.vertex_count);
    assert_int_equal(read.tet_count, mesh.tet_count);
    assert_non_null(read.midsides);
    assert_true(farthest_off(&read) < 1e-12);
    thrum_mesh_free(&read);
  }
  thrum_mesh_free(&mesh);
}

static void gmsh_reads_what_we_write(void **state) {
  (void)state;
  if (!*gmsh)
    return;
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read("beam:3x2x2@1x0.3x0.3", 1, &mesh, NULL), THRUM_OK);

  // in a file with physical groups Gmsh writes only their elements
  assert_int_equal(thrum_mesh_add_region_group(&mesh, 0, "body", NULL), THRUM_OK);
  for (int n = 0; n < 5; n++) {
    const thrum_mesh_write_options options = {.binary = n % 2, .msh_version = n < 2 ? 22 : 41};
    thrum_mesh_lost lost;
    assert_int_equal(
        thrum_mesh_write(in_folder(n < 4 ? "ours.msh" : "ours.mesh"), &mesh, &options, &lost, NULL),
        THRUM_OK);
    const char *const arguments[] = {n < 4 ? "ours.msh" : "ours.mesh",
                                     "-save",
                                     "-format",
                                     "msh22",
                                     "-bin",

                                     "-o",
                                     "theirs.msh",
                                     NULL};
    run(gmsh, arguments);
    thrum_mesh read = read_mesh("theirs.msh");
    assert_int_equal(read.vertex_count, mesh.vertex_count);
    assert_int_equal(read.tet_count, mesh.tet_count);

    // the format has its own numbering of vertices
    assert_true(fabs(volume(&read) - volume(&mesh)) < 1e-15);
    if (n < 4)
      assert_int_equal(group_count(&read, "left"), group_count(&mesh, "left"));
    thrum_mesh_free(&read);
  }
  thrum_mesh_free(&mesh);
}

/* The unit cube in two regions, divided at x = 1/2. */
static const char CUBES[] =
    "12 3 0 0\n0 0 0 0\n1 .5 0 0\n2 1 0 0\n3 0 1 0\n4 .5 1 0\n5 1 1 0\n6 0 0 1\n7 .5 0 1\n8 1 0 1\n"
    "9 0 1 1\n10 .5 1 1\n11 1 1 1\n11 1\n"
    "1 0 5\n4 0 3 9 6\n1 0 6\n4 2 5 11 8\n1 0 0\n4 1 4 10 7\n"
    "1\n4 0 1 7 6\n1\n4 1 2 8 7\n1\n4 3 4 10 9\n1\n4 4 5 11 10\n"
    "1\n4 0 1 4 3\n1\n4 1 2 5 4\n1\n4 6 7 10 9\n1\n4 7 8 11 10\n"
    "0\n2\n0 .25 .5 .5 10 .02\n1 .75 .5 .5 20 .02\n";

static void tetgen_writes_and_we_read_markers_and_regions(void **state) {
  (void)state;
  if (!*tetgen)
    return;

  // the geometry for TetGen
  assert_true(text_file_write(in_folder("cubes.poly"), CUBES));

  // z: indices from 0; o2: tetrahedra of ten nodes
  static const char *const flags[] = {"-pqaAQ", "-pqaAQz", "-pqaAQo2"};
  for (int i = 0; i < 3; i++) {
    const char *const arguments[] = {flags[i], "cubes.poly", NULL};
    run(tetgen, arguments);

    // volume, regions and ten-node tetrahedra as asked for
    thrum_mesh mesh = read_mesh("cubes.1.node");
    assert_true(fabs(volume(&mesh) - 1) < 1e-12);
    assert_int_equal(mesh.region_count, 2);
    assert_true(group_count(&mesh, "region_10") > 8 && group_count(&mesh, "region_20") > 8);
    assert_int_equal((mesh.midsides != NULL), i == 2);

    // straight edges: only the right order has all middle nodes in the middle
    assert_true(i < 2 || farthest_off(&mesh) < 1e-15);
    thrum_mesh_free(&mesh);
  }
}

int main(int argc, char **argv) {
  gmsh = argc > 1 ? argv[1] : "";
  tetgen = argc > 2 ? argv[2] : "";

  // one folder holds what the programs write
  if (!test_folder_make(folder))
    return 1;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gmsh_writes_and_we_read_every_format),
      cmocka_unit_test(gmsh_writes_ten_nodes_and_we_read_their_order),
      cmocka_unit_test(gmsh_writes_hexahedra_and_wedges_and_we_cut_them),
      cmocka_unit_test(gmsh_reads_what_we_write),
      cmocka_unit_test(gmsh_reads_the_ten_nodes_that_we_write),
      cmocka_unit_test(tetgen_writes_and_we_read_markers_and_regions),
  };

  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  test_folder_remove(folder);
  return failed;
}
