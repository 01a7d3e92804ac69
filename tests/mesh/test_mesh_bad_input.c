/* Invalid meshes are refused, each with one line that names the fault, its place and its cause;
 * every truncation and many mutations of valid files are either read or refused.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_beam.h"
#include "tests/support/mesh_support.h"

#include <float.h>
#include <math.h>
#include <sys/stat.h>

#define VERTICES "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
#define ELEMENTS "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 4 5\n"
#define MATERIAL "*MATERIAL BODY\nENU, 1000, 5e6, 0.4\n*REGION\nallElements, BODY\n"
#define GOOD VERTICES ELEMENTS MATERIAL

#define FORMAT_2 "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define NODES_2 "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n"
#define FORMAT_4 "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
#define NODES_4 "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
#define ELEMENTS_4 "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"

typedef struct bad_case {
  const char *text, *words;
} bad_case;

static void check_all(const char *name, const bad_case *cases, size_t count) {
  for (size_t i = 0; i < count; i++)
    mesh_bad(name, cases[i].text, cases[i].words);
}

#define CHECK(name, cases) check_all(name, cases, sizeof(cases) / sizeof *(cases))

static void a_file_that_is_no_mesh_is_refused(void **state) {
  (void)state;
  static const char *const names[] = {
      "no-such.veg", "no-such.msh",         "mesh.obj", "", "veg", ".veg", "beam",
      "/",           "no-such-folder/x.veg"};

  // names that are no file, or no file of a known format
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    assert_true(thrum_mesh_read(names[i], 1, &mesh, &error) < 0);
    mesh_check_message(&error, names[i]);
  }

  // a folder with the name of a mesh
  char folder[128];
  snprintf(folder, sizeof folder, "%s/folder.veg", mesh_folder);
  assert_int_equal(mkdir(folder, 0700), 0);
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_mesh_read(folder, 1, &mesh, &error), THRUM_IO);
  mesh_check_message(&error, "folder.veg");
  assert_int_equal(rmdir(folder), 0);

  // the error is optional
  assert_true(thrum_mesh_read("no-such.veg", 1, &mesh, NULL) < 0);
}

static void files_that_are_not_text_are_refused(void **state) {
  (void)state;
  mesh_bad("a.veg", "", "there is no *VERTICES");
  mesh_bad("a.msh", "", "there is no $MeshFormat");
  mesh_bad("a.veg", "# only a comment\n\n", "there is no *VERTICES");
  mesh_bad("a.veg", "v 0 0 0\nf 1 2 3\n", "a.veg:1: expected *VERTICES");
  mesh_bad("a.msh", "solid cube\n", "a.msh:1: expected $MeshFormat");
  mesh_bad_bytes("a.veg", "\xff\xfe*\0V\0", 6, "UTF-16");
  mesh_bad_bytes("a.veg",
                 "\x7f"
                 "ELF\0\0\1\2\n\0\0",
                 11, "a.veg:1: expected *VERTICES");
  static const char zeros[1000];
  mesh_bad_bytes("a.veg", zeros, sizeof zeros, "a.veg:1: expected *VERTICES");
  mesh_bad_bytes("a.msh", zeros, sizeof zeros, "a.msh:1: expected $MeshFormat");
}

static void bad_veg_sections_are_refused_with_their_line(void **state) {
  (void)state;
  static const bad_case cases[] = {
      // the list of vertices
      {"*VERTICES\n", ":1: the file ends before the number of vertices"},
      {"*VERTICES\n5 3 0 0\n1 0 0 0\n",
       ":3: the file ends before the last vertex; is it cut short?"},
      {"*VERTICES\n0 3 0 0\n" ELEMENTS, ":2: the number of vertices is 0"},
      {"*VERTICES\n-4 3 0 0\n" ELEMENTS, ":2: the number of vertices is -4"},
      {"*VERTICES\n1000000000000000000 3 0 0\n1 0 0 0\n", ":2: the number of vertices is 1000000"},
      {"*VERTICES\n99999999999999999999999 3 0 0\n1 0 0 0\n",
       ":2: the number of vertices is 99999999999999999999999, which is out"},
      {"*VERTICES\n2000000000 3 0 0\n1 0 0 0\n", "the file ends before the last vertex"},
      {"*VERTICES\nmany 3 0 0\n", ":2: expected the number of vertices, found 'many'"},
      {"*VERTICES\n1 2 0 0\n1 0 0\n" ELEMENTS, ":2: numbers per line is 2"},
      {"*VERTICES\n1 3 0 0\n1 0 0\n" ELEMENTS, ":3: the line ends before the z coordinate"},
      {"*VERTICES\n1 3 0 0\n1 0 0 0 0\n" ELEMENTS,
       ":3: unexpected '0' after the three coordinates"},
      {"*VERTICES\n1 3 0 0\n1 0 zero 0\n" ELEMENTS, ":3: expected the y coordinate, found 'zero'"},
      {"*VERTICES\n1 3 0 0\n1 0 0 0x10\n" ELEMENTS, ":3: expected the z coordinate, found '0x10'"},
      {"*VERTICES\n1 3 0 0\n1 0 nan 0\n" ELEMENTS,
       ":3: the y coordinate is 'nan', which is not a fin"},
      {"*VERTICES\n1 3 0 0\n1 -inf 0 0\n" ELEMENTS, ":3: the x coordinate is '-inf'"},
      {"*VERTICES\n1 3 0 0\n1 1e999 0 0\n" ELEMENTS, ":3: the x coordinate is '1e999'"},
      {"*VERTICES\n1 3 0 0\n1 0,5 0,5 0,5\n" ELEMENTS, "(is a decimal mark a comma?)"},
      {"*VERTICES\n2 3 0 0\n5 0 0 0\n6 0 0 0\n", ":3: a vertex number is 5"},
      {"*VERTICES\n2 3 0 0\n1 0 0 0\n1 0 0 0\n", ":4: a vertex number is 1 where 2 comes next"},
      {"*VERTICES\n2 3 0 0\n1 0 0 0\n3 0 0 0\n", ":4: a vertex number is 3 where 2 comes next"},
      {"*VERTICES\n6 3 0 0\n1 0 0 0\n" ELEMENTS, ":4: expected the last vertex, found '*ELEMENTS'"},
      {"*VERTICES\n1 3 0 0\n1 0 0 0\n2 0 0 0\n", ":4: expected *VERTICES, *ELEMENTS"},

      // sections that occur twice or are missing
      {VERTICES VERTICES ELEMENTS, ":8: *VERTICES comes twice"},
      {VERTICES ELEMENTS ELEMENTS, ":13: *ELEMENTS comes twice"},
      {VERTICES, "there is no *ELEMENTS"},
      {ELEMENTS, "there is no *VERTICES"},

      // the list of elements
      {VERTICES "*ELEMENTS\nCUBIC\n1 8 0\n1 1 2 3 4 5 6 7 8\n",
       ":9: CUBIC elements are not supported"},
      {VERTICES "*ELEMENTS\nHEX\n", ":9: expected the kind of elements, TET, found 'HEX'"},
      {VERTICES "*ELEMENTS\nTET\n1 10 0\n", ":10: numbers per line is 10"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 1 2 3\n",
       ":11: the line ends before a vertex of the tet"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4 5\n",
       ":11: unexpected '5' after the four vertices"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 1 2 3 6\n",
       ":11: a vertex of the tet is 6, which is out of"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 0 2 3 4\n", ":11: a vertex of the tet is 0"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 -1 2 3 4\n", ":11: a vertex of the tet is -1"},
      {VERTICES "*ELEMENTS\nTET\n1 4 0\n1 1 2 3 2.5\n",
       ":11: expected a vertex of the tet, found '2.5'"},
      {"*ELEMENTS\nTET\n1 4 0\n1 1 2 3 6\n" VERTICES,
       ":4: tet 1 names vertex 6, which is not in the file; its vertices are 1 to 5"},
      {VERTICES "*TABLES\n", ":8: expected *VERTICES, *ELEMENTS, *MATERIAL"},
      {VERTICES "*ELEMENTS TET\n2 4 0\n", ":8: unexpected 'TET' after *ELEMENTS"}};

  CHECK("b.veg", cases);
}

static void bad_materials_and_regions_are_refused_with_their_line(void **state) {
  (void)state;
#define MESH VERTICES ELEMENTS
  static const bad_case cases[] = {
      // materials
      {MESH "*MATERIAL B\n", ":13: the file ends before the material's line"},
      {MESH "*MATERIAL\nENU, 1, 1, 0\n", ":13: a name is empty"},
      {MESH "*MATERIAL B\nMOONEYRIVLIN, 1000, 1, 2, 3\n",
       ":14: material 'MOONEYRIVLIN' is not supp"},
      {MESH "*MATERIAL B\nORTHOTROPIC, 1000, 1, 2, 3\n",
       ":14: material 'ORTHOTROPIC' is not suppor"},
      {MESH "*MATERIAL B\nENU, 1000, 5e6\n", ":14: the line ends before Poisson's ratio nu"},
      {MESH "*MATERIAL B\nENU, 1000, 5e6, 0,4\n", ":14: unexpected '4' after the material"},
      {MESH "*MATERIAL B\nENU, heavy, 5e6, 0.4\n", ":14: expected the density, found 'heavy'"},
      {MESH "*MATERIAL B\nENU, 1000, nan, 0.4\n", ":14: Young's modulus E is 'nan'"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*MATERIAL B\nENU,1,1,0\n", ":15: this material comes twice"},

      // regions
      {MESH "*MATERIAL B\nENU,1,1,0\n*MATERIAL C\nENU,1,1,0\n", "several materials but no *REGION"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*REGION\nnone, B\n", ":16: the region's set 'none' is not in"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*REGION\nallElements, C\n",
       ":16: the region's material 'C' is"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*REGION\nallElements\n",
       ":16: a region is a set and a material"},
      {MESH "*REGION\nallElements, B\n", ":14: the region's material 'B' is not in the file"},
      {MESH "*REGION\n", ":13: the file ends before the region's line"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*SET s\n1\n*REGION\ns, B\n", "element 2 is in no *REGION"},

      // sets
      {MESH "*SET s\n1, 3\n", ":14: an element of the set is 3, which is out of range"},
      {MESH "*SET s\n0\n", ":14: an element of the set is 0"},
      {MESH "*SET s\none\n", ":14: expected an element of the set, found 'one'"},
      {MESH "*SET s\n1\n*SET s\n2\n", ":15: this set comes twice"},
      {MESH "*SET\n1\n", ":13: a name is empty"},
      {MESH "*SET a\x01z\n1\n", ":13: a name holds a control character"},
      {MESH "*SET a\xe9z\n1\n", ":13: a name is not UTF-8"},
      {"*SET s\n1, 3\n" MESH, "set 's' names element 3, but there are 2"},
      {MESH "*SET allElements\n1, 1\n",
       "the set allElements holds 1 of 2 elements, but it stands for all; give it another name"},

      // a region divides its two names at a comma
      {MESH "*SET, s\n1\n", ":13: a name holds a comma: ', s'"},
      {MESH "*MATERIAL B, C\nENU,1,1,0\n", ":13: a name holds a comma: 'B, C'"},
      {MESH "*MATERIAL B\nENU,1,1,0\n*REGION\nallElements, B, C\n", ":16: a name holds a comma"},
      {MESH "*MATERIAL B\nORTHOTROPIC_N1G1R9,1,1,1,1,0,1\n", ":14: material 'ORTHOTROPIC_N1G1R9' "},
      {MESH "*MATERIAL B\nENU\n", ":14: the line ends before the density"},
      {MESH "*STEP\n", ":13: expected *VERTICES, *ELEMENTS"}};

  CHECK("c.veg", cases);
}

static void bad_includes_are_refused(void **state) {
  (void)state;

  // a missing file, and files that include themselves or each other
  mesh_bad("d.veg", "*INCLUDE\n", "d.veg:1: *INCLUDE names no file");
  mesh_bad("d.veg", "\n*INCLUDE none.node\n", "d.veg:2: cannot find the included file");
  mesh_bad("d.veg", "*INCLUDE d.veg\n", "d.veg:1: *INCLUDE goes in a circle");

  // nothing outside of the folder of the mesh is read
  static const char *const away[] = {"/etc/passwd", "../d.veg", "sub/../../d.veg", ".."};
  for (int n = 0; n < 4; n++) {
    char text[64];
    snprintf(text, sizeof text, "*INCLUDE %s\n", away[n]);
    mesh_bad("d.veg", text, "d.veg:1: *INCLUDE leads out of the folder");
  }

  // nor by a link that leads out
  char link[300];
  snprintf(link, sizeof link, "%s/away.veg", mesh_folder);
  assert_int_equal(symlink("/etc/passwd", link), 0);
  mesh_bad("d.veg", "*INCLUDE away.veg\n", "d.veg:1: *INCLUDE leads out of the folder");
  assert_int_equal(unlink(link), 0);

  // but from where the user allows it, and from nowhere else
  char allowed[256], line[320];
  snprintf(allowed, sizeof allowed, "%s/parts", mesh_folder);
  assert_int_equal(mkdir(allowed, 0777), 0);
  mesh_write_text("parts/part.node", "not a mesh\n");
  mesh_write_text("d.node", "nor is this\n");
  assert_int_equal(setenv("THRUM_INCLUDES", allowed, 1), 0);
  snprintf(line, sizeof line, "*INCLUDE %s/part.node\n", allowed);
  mesh_bad("d.veg", line, "part.node:1: ");
  mesh_bad("d.veg", "*INCLUDE parts/../parts/part.node\n", "part.node:1: ");
  mesh_bad("d.veg", "*INCLUDE parts/../d.node\n", "d.veg:1: *INCLUDE leads out of the folder");
  snprintf(line, sizeof line, "*INCLUDE %s/../d.node\n", allowed);
  mesh_bad("d.veg", line, "d.veg:1: *INCLUDE leads out of the folder");
  snprintf(line, sizeof line, "%s/link.node", allowed);
  assert_int_equal(symlink("../d.node", line), 0);
  mesh_bad("d.veg", "*INCLUDE parts/../parts/link.node\n", "*INCLUDE leads out of the folder");
  assert_int_equal(unlink(line), 0);

  // a file in another folder finds what it names beside itself, unless the first file has it too
  mesh_write_text("parts/part.veg", "*INCLUDE part.node\n");
  mesh_bad("d.veg", "*INCLUDE parts/part.veg\n", "part.node:1: ");
  mesh_write_text("part.node", "nor is this\n");
  mesh_bad("d.veg", "*INCLUDE parts/part.veg\n", "parts/part.veg:1: *INCLUDE may mean '");
  mesh_bad("d.veg", "*INCLUDE parts/part.veg\n", "; give one of them another name");
  snprintf(line, sizeof line, "%s/part.veg", allowed);
  assert_int_equal(unlink(line), 0);
  snprintf(line, sizeof line, "%s/part.node", allowed);
  assert_int_equal(unlink(line), 0);
  assert_int_equal(rmdir(allowed), 0);
  assert_int_equal(unsetenv("THRUM_INCLUDES"), 0);

  mesh_bad("d.veg", "*INCLUDE .\n", "cannot be read");
  mesh_write_text("e.veg", "*INCLUDE d.veg\n");
  mesh_bad("d.veg", "*INCLUDE ./e.veg\n", "e.veg:1: *INCLUDE goes in a circle");

  // a mistake in an included file is reported with that file's line
  mesh_write_text("f.node", "2 3 0 0\n1 0 0 0\n2 0 0\n");
  mesh_bad("d.veg", "*VERTICES\n*INCLUDE f.node\n", "f.node:3: the line ends before the z");

  // a chain that is too deep, and too many inclusions of one file
  for (int i = 0; i < 12; i++) {
    char name[32], text[32];
    snprintf(name, sizeof name, "g%d.veg", i);
    snprintf(text, sizeof text, "*INCLUDE g%d.veg\n", i + 1);
    mesh_write_text(name, text);
  }
  mesh_bad("g12.veg", "", "there is no *VERTICES");
  mesh_bad("d.veg", "*INCLUDE g0.veg\n", "*INCLUDE goes deeper than 8 files");
  char often[20 * 200] = "";
  for (int i = 0; i < 200; i++)
    strcat(often, "*INCLUDE g12.veg\n");
  mesh_bad("d.veg", often, "there are more than 100");
}

static void bad_tets_are_named(void **state) {
  (void)state;
  static const bad_case cases[] = {
      {"*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 .3 .7 0\n*ELEMENTS\nTET\n1 4 0\n1 1 2 3 "
       "4\n",
       "h.veg:10: tet 1 (vertices 1 2 3 4) has no volume"},
      // coplanar in exact arithmetic alone, and far from the origin
      {"*VERTICES\n4 3 0 0\n1 1000 .1 .7\n2 1000.1 .2 .7\n3 1000.3 .7 .7\n4 1000.9 .4 .7\n"
       "*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n",
       "tet 1 (vertices 1 2 3 4) has no volume"},
      {"*VERTICES\n4 3 0 0\n1 .1 .1 .1\n2 .2 .2 .2\n3 .3 .3 .3\n4 0 0 1\n*ELEMENTS\nTET\n1 4 0\n"
       "1 1 2 3 4\n",
       "has no volume"},
      {"*VERTICES\n4 3 0 0\n1 0 0 0\n2 0 0 0\n3 0 0 0\n4 0 0 0\n*ELEMENTS\nTET\n1 4 0\n1 1 2 3 4\n",
       "has no volume"},

      // faults of topology: repeated vertices, repeated tetrahedra, overfull faces, overlaps
      {VERTICES "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 3 5\n", ":12: tet 2 has vertex 3 twice"},
      {VERTICES "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 1 4\n",
       ":12: tet 2 has the same vertices as"},
      {"*VERTICES\n6 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n6 2 1 1\n*ELEMENTS\nTET\n"
       "3 4 0\n1 1 2 3 4\n2 2 5 3 4\n3 2 6 3 4\n",
       ":14: tet 1, tet 2 and tet 3 share one face"},
      {"*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .1 .1 .2\n*ELEMENTS\nTET\n"
       "2 4 0\n1 1 2 3 4\n2 5 2 3 4\n",
       ":12: tet 1 and tet 2 lie on the same side of the face"},

      // coordinates whose volumes overflow or underflow
      {"*VERTICES\n4 3 0 0\n1 0 0 0\n2 1e200 0 0\n3 0 1e200 0\n4 0 0 1e200\n*ELEMENTS\nTET\n1 4 0\n"
       "1 1 2 3 4\n",
       "check the scale"},
      {"*VERTICES\n4 3 0 0\n1 0 0 0\n2 1e-200 0 0\n3 0 1e-200 0\n4 0 0 1e-200\n*ELEMENTS\nTET\n"
       "1 4 0\n1 1 2 3 4\n",
       "check the scale"}};

  CHECK("h.veg", cases);
}

static void bad_scales_are_refused(void **state) {
  (void)state;
  const char *path = mesh_write_text("good.veg", GOOD);
  static const double scales[] = {0, -1, INFINITY, NAN, DBL_MAX, DBL_MIN};
  for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    assert_true(thrum_mesh_read(path, scales[i], &mesh, &error) < 0);
    mesh_check_message(&error, "scale");
  }
}

static void bad_beams_are_refused(void **state) {
  (void)state;
  static const struct {
    const char *spec, *words;
  } cases[] = {{"beam:", "is no beam"},
               {"beam:1x1x1", "is no beam"},
               {"beam:1x1@1x1x1", "is no beam"},
               {"beam:1x1x1@1x1", "is no beam"},
               {"beam:1x1x1@1x1x1x1", "is no beam"},
               {"beam:1x1x1@1x1x1 ", "is no beam"},
               {"beam:4x1x1@1x1x1,parts=5", "is no beam"},
               {"beam:4x1x1@1x1x1,parts=0", "is no beam"},
               {"beam:4x1x1@1x1x1,parts=", "is no beam"},
               {"beam:1.5x1x1@1x1x1", "is no beam"},
               {"beam:axbxc@1x1x1", "is no beam"},
               {"beam:1x1x1@0,1x1x1", "is no beam"},
               {"beam:99999999999999999999x1x1@1x1x1", "is no beam"},

               // counts and lengths out of range
               {"beam:0x1x1@1x1x1", "at least one cell"},
               {"beam:-1x1x1@1x1x1", "at least one cell"},
               {"beam:1x1x1@1e300x1x1", "a length of 1e+300 m is out of range"},
               {"beam:1x1x1@0x1x1", "a length above 0"},
               {"beam:1x1x1@1x-1x1", "a length above 0"},
               {"beam:1x1x1@1xnanx1", "a length above 0"},
               {"beam:1x1x1@1x1xinf", "out of range"},
               {"beam:1x1x1@1x1e-40x1", "out of range"},

               // beams too large to make, or too thin for a volume
               {"beam:100000x100000x100000@1x1x1", "would have 6e+15 tets"},
               {"beam:9000000000000000000x9000000000000000000x9@1x1x1", "would have"},
               {"beam:1x1x1@1x1e-14x1", "has no volume"}};

  // the message quotes the specification
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(cases[i].spec, 1, &mesh, &error) >= 0)
      fail_msg("not refused: %s", cases[i].spec);
    mesh_check_message(&error, cases[i].words);
    mesh_check_message(&error, cases[i].spec);
  }

  // other prefixes are not parsed as a beam at all
  thrum_mesh mesh = {0};
  assert_true(thrum_mesh_beam("veam:1x1x1@1x1x1", &mesh, NULL) < 0);
  assert_true(thrum_mesh_beam("", &mesh, NULL) < 0);
}

static void bad_gmsh_sections_are_refused_with_their_line(void **state) {
  (void)state;
#define TET_2 "$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n"
  static const bad_case cases[] = {
      // the header
      {"$NODES\n1\n", ":1: expected $MeshFormat, found '$NODES'"},
      {NODES_2, ":1: expected $MeshFormat, found '$Nodes'"},
      {FORMAT_2 FORMAT_2, ":4: expected a section such as $Nodes, found '$MeshFormat'"},
      {"$MeshFormat\n4 0 8\n$EndMeshFormat\n", ":2: version 4 is not read, only 2.2 and 4.1"},
      {"$MeshFormat\n3 0 8\n$EndMeshFormat\n", ":2: version 3 is not read"},
      {"$MeshFormat\n4.1 1 8\n\1\n$EndMeshFormat\n",
       ":2: in the binary data behind this line: there is no 1"},
      {"$MeshFormat\n2.2\n$EndMeshFormat\n", ":2: the line ends before the kind, 0 for ASCII"},
      {"$MeshFormat\n", ":1: the file ends before the version"},
      {"$MeshFormat\n2.2 0 8\n", ":2: the file ends before $EndMeshFormat"},

      // sections missing, repeated or unknown
      {FORMAT_2, "there is no $Nodes section"},
      {FORMAT_2 NODES_2, "there is no $Elements section"},
      {FORMAT_2 TET_2, ":4: $Elements comes twice or before $Nodes"},
      {FORMAT_2 NODES_2 NODES_2, "$Nodes comes twice"},
      {FORMAT_2 NODES_2 TET_2 TET_2, "$Elements comes twice"},
      {FORMAT_2 NODES_2 TET_2 "$PostData\n1 2 3\n", "the file ends before $EndPostData"},
      {FORMAT_2 NODES_2 "loose words\n", ":12: expected a section such as $Nodes, found 'loose"},
      {FORMAT_2 "$\n", ":4: expected a section"},

      // nodes
      {FORMAT_2 "$Nodes\n-5\n", ":5: the number of nodes is -5"},
      {FORMAT_2 "$Nodes\n1000000000000000000\n1 0 0 0\n", "the file ends before the last node"},
      {FORMAT_2 "$Nodes\n2\n1 0 0 0\n$EndNodes\n", ":7: expected the last node, found '$EndNodes'"},
      {FORMAT_2 "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n",
       ":7: expected $EndNodes, found '2 0 0 0'"},
      {FORMAT_2 "$Nodes\n1\n0 0 0 0\n$EndNodes\n", ":6: the tag of a node is 0"},
      {FORMAT_2 "$Nodes\n1\n1 0 0\n$EndNodes\n", ":6: the line ends before the z coordinate"},
      {FORMAT_2 "$Nodes\n1\n1 0 0 nan\n$EndNodes\n", ":6: the z coordinate is 'nan'"},
      {FORMAT_2 "$Nodes\n1\n1 0,5 0 0\n$EndNodes\n", "'0,5' (the decimal mark is a point)"},
      {FORMAT_2 "$Nodes\n2\n7 0 0 0\n7 0 0 0\n$EndNodes\n", ":7: vertex 7 comes twice"},

      // elements
      {FORMAT_2 NODES_2 "$Elements\n1\n1 4 2 0 1 1 2 3\n$EndElements\n",
       ":14: the line ends before a node of the element"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 4 2 0 1 1 2 3 9\n$EndElements\n",
       ":14: the element names node 9, which is not in $Nodes"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 4 2 0 1 1 2 3 4 5\n$EndElements\n", ":14: unexpected '5'"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 15 2 3 1 9\n$EndElements\n",
       "names node 9, which is not in"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 11 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n",
       ":14: the element names node 6, which is not in $Nodes"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 29 2 0 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n",
       ":14: tetrahedra of order 3 and more (type 29) are not supported"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 92 2 0 1 1 2 3 4 5 6 7 8\n$EndElements\n",
       ":14: elements of type 92 are not supported"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 4711 2 0 1 1\n$EndElements\n",
       "elements of type 4711 are"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n", "holds no tetrahedra"},
      {FORMAT_2 NODES_2 "$Elements\n0\n$EndElements\n", "holds no tetrahedra"},
      {FORMAT_2 NODES_2 "$Elements\n1\n1 4 2 0 1 1 2 3 3\n$EndElements\n",
       ":14: tet 1 has vertex 3 twice"},

      // physical names, and sections of the other version
      {FORMAT_2 "$PhysicalNames\n1\n2 1 \"a\n", ":6: the file ends before $EndPhysicalNames"},
      {FORMAT_2 "$PhysicalNames\n1\n2 1 \"\"\n$EndPhysicalNames\n", ":6: a name is empty"},
      {FORMAT_2 "$PhysicalNames\n1\n4 1 \"a\"\n$EndPhysicalNames\n", ":6: the dimension is 4"},
      {FORMAT_2 "$PhysicalNames\n2\n2 1 \"a\"\n2 1 \"b\"\n$EndPhysicalNames\n",
       ":7: physical group 1"},
      {FORMAT_2 "$Entities\n0 0 0 0\n$EndEntities\n",
       ":4: $Entities does not belong into a file of"}};

  CHECK("i.msh", cases);
}

static void bad_gmsh_4_sections_are_refused_with_their_line(void **state) {
  (void)state;
  static const bad_case cases[] = {
      // entities
      {FORMAT_4 "$PartitionedEntities\n2\n$EndPartitionedEntities\n", ":4: partitioned meshes"},
      {FORMAT_4 "$Entities\n1 0 0 0\n$EndEntities\n",
       ":6: expected the last entity, found '$EndEnt"},
      {FORMAT_4 "$Entities\n1 0 0 0\n1 0 0 0 2 5\n$EndEntities\n",
       ":6: the line ends before a phys"},

      // nodes
      {FORMAT_4 "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n", ":8: the file ends before the last tag of the"},
      {FORMAT_4 "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n$EndNodes\n",
       ":12: expected the last node of the block"},
      {FORMAT_4 "$Nodes\n1 5 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n",
       "the section says that it has 5 nodes, but its blocks hold 4"},
      {FORMAT_4 "$Nodes\n1 4 1 4\n3 1 2 4\n", ":6: the parametric flag is 2"},
      {FORMAT_4 "$Nodes\n1 1 1 1\n3 1 0 1000000000000000000\n1\n",
       "the file ends before the last tag"},
      {FORMAT_4 "$Nodes\n1 1 1 1\n3 1 0 -1\n", "the number of nodes in the block is -1"},

      // elements
      {FORMAT_4 NODES_4 "$Elements\n1 1 1 1\n3 1 4 2\n1 1 2 3 4\n$EndElements\n",
       "expected the last element of the block, found '$EndElements'"},
      {FORMAT_4 NODES_4 "$Elements\n1 2 1 1\n3 1 4 1\n1 1 2 3 4\n$EndElements\n",
       "the section says that it has 2 elements, but its blocks hold 1"},
      {FORMAT_4 NODES_4 "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 3 77\n$EndElements\n",
       "the element names node 77"},
      {FORMAT_4 NODES_4 "$Elements\n1 1 1 1\n3 1 11 1\n1 1 2 3 4\n$EndElements\n",
       "the line ends before a node of the element"},
      {FORMAT_4 NODES_4 "$Elements\n1 1 1 1\n3 1 29 1\n1 1 2 3 4\n$EndElements\n",
       "tetrahedra of order 3 and more (type 29)"},
      {FORMAT_4 NODES_4 "$Elements\n1 1 1 1\n3 1 92 1\n1 1 2 3 4\n$EndElements\n",
       "elements of type 92 are not supported"},
      {FORMAT_4 NODES_4 ELEMENTS_4 "$Entities\n0 0 0 0\n$EndEntities\n",
       "$Entities comes twice or"}};

  CHECK("j.msh", cases);
}

static void a_very_long_line_is_cut_in_the_message(void **state) {
  (void)state;
  enum { LONG = 1000000 };

  // a word of a million characters where a number belongs
  char *text = malloc(LONG + 1000);
  assert_non_null(text);
  strcpy(text, "*VERTICES\n1 3 0 0\n1 0 ");
  size_t start = strlen(text);
  memset(text + start, 'x', LONG);
  mesh_bad_bytes("k.veg", text, start + LONG, ":3: expected the y coordinate, found 'xxxx");

  // a number of a million digits is valid, unless its value is not finite
  memset(text + start, '0', LONG);
  text[start] = '.';
  memcpy(text + start + LONG - 3, "7 0", 3);
  mesh_bad_bytes("k.veg", text, start + LONG, "there is no *ELEMENTS");
  memset(text + start, '9', LONG);
  mesh_bad_bytes("k.veg", text, start + LONG, "which is not a finite number");

  // the name of a set that is too long
  strcpy(text, VERTICES ELEMENTS "*SET ");
  start = strlen(text);
  memset(text + start, 'n', LONG);
  memcpy(text + start + LONG - 3, "\n1\n", 3);
  mesh_bad_bytes("k.veg", text, start + LONG, ":13: a name is longer than 255 bytes");

  free(text);
}

/* Reads arbitrary bytes: the result is a valid mesh or a message of one line. */
static void survive(const char *name, const char *data, size_t size) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  thrum_status status = thrum_mesh_read(mesh_write(name, data, size), 1, &mesh, &error);
  if (status < 0) {
    mesh_check_message(&error, name);
    return;
  }

  // a mesh that was read has valid indices, volumes and regions
  assert_true(mesh.tet_count > 0 && mesh.region_count > 0);
  for (int64_t i = 0; i < 4 * mesh.tet_count; i++)
    assert_true(mesh.tets[i] >= 0 && mesh.tets[i] < mesh.vertex_count);
  for (int64_t t = 0; t < mesh.tet_count; t++) {
    assert_true(thrum_mesh_tet_volume(&mesh, t) > 0);
    assert_true(mesh.tet_region[t] >= 0 && mesh.tet_region[t] < mesh.region_count);
  }

  thrum_mesh_free(&mesh);
}

static const char *const seeds[] = {
    GOOD "*SET s\n1,\n2\n*MATERIAL hard\nENU, 1, 2, .3\n*REGION\ns, hard\n",
    FORMAT_2 "$PhysicalNames\n1\n3 5 \"a b\"\n$EndPhysicalNames\n" NODES_2
             "$Elements\n3\n1 4 2 5 1 1 2 3 4\n2 4 2 6 1 2 3 4 5\n3 2 2 7 1 2 3 4\n$EndElements\n",
    FORMAT_4 "$Entities\n1 0 0 1\n1 0 0 0 1 3\n1 0 0 0 1 1 1 1 5 0\n$EndEntities\n" NODES_4
             "$Elements\n2 2 1 2\n0 1 15 1\n2 3\n3 1 4 1\n1 1 2 3 4\n$EndElements\n"};

static const char *seed_name(size_t s) {
  return s == 0 ? "seed.veg" : "seed.msh";
}

static void every_truncation_is_survived(void **state) {
  (void)state;
  for (size_t s = 0; s < sizeof seeds / sizeof *seeds; s++)
    for (size_t size = 0; size <= strlen(seeds[s]); size++)
      survive(seed_name(s), seeds[s], size);
}

static void random_mutations_are_survived(void **state) {
  (void)state;
  static const char alphabet[] = "0123456789-+.,eE \n\r\t*$#:\"aT\0\xff";

  // a fixed seed, so that every run tries the same bytes
  uint64_t random = 88172645463325252u;
  for (int round = 0; round < 6000; round++) {
    size_t s = (size_t)round % 3, size = strlen(seeds[s]);
    char data[2048];
    memcpy(data, seeds[s], size);
    for (int change = 0; change < 1 + round % 4; change++) {
      // xorshift64
      random ^= random << 13;
      random ^= random >> 7;
      random ^= random << 17;
      size_t at = random % size;
      char with = alphabet[(random >> 32) % (sizeof alphabet - 1)];

      // the change replaces, removes or inserts a byte
      if ((random >> 60) < 8) {
        data[at] = with;
      } else if ((random >> 60) < 12) {
        memmove(data + at, data + at + 1, --size - at);
      } else if (size < sizeof data) {
        memmove(data + at + 1, data + at, size++ - at);
        data[at] = with;
      }
    }
    survive(seed_name(s), data, size);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // files that are no text, and VegaFEM's format
      cmocka_unit_test(a_file_that_is_no_mesh_is_refused),
      cmocka_unit_test(files_that_are_not_text_are_refused),
      cmocka_unit_test(bad_veg_sections_are_refused_with_their_line),
      cmocka_unit_test(bad_materials_and_regions_are_refused_with_their_line),
      cmocka_unit_test(bad_includes_are_refused),
      cmocka_unit_test(bad_tets_are_named),

      // scale and generator
      cmocka_unit_test(bad_scales_are_refused),
      cmocka_unit_test(bad_beams_are_refused),

      // Gmsh's formats
      cmocka_unit_test(bad_gmsh_sections_are_refused_with_their_line),
      cmocka_unit_test(bad_gmsh_4_sections_are_refused_with_their_line),

      // long lines, truncations and mutations
      cmocka_unit_test(a_very_long_line_is_cut_in_the_message),
      cmocka_unit_test(every_truncation_is_survived),
      cmocka_unit_test(random_mutations_are_survived),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
