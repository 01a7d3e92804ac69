/* One small mesh in every format that is read: equal vertices and tetrahedra, and the groups,
 * regions and materials that the format can hold; and the files that are refused, with place and
 * cause.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "tests/support/mesh_support.h"

#include <math.h>

/* Two tetrahedra with one face in common; decimals do not represent the coordinates exactly. */
static const double POINTS[5][3] = {
    {0, 0, 0}, {0.1, 0, 0}, {0, 1e-1, 0}, {0, 0, 0.30000000000000004}, {0.1, 0.1, 0.3}};
static const int TETS[2][4] = {{0, 1, 2, 3}, {1, 4, 2, 3}};

static const char MEDIT[] = "MeshVersionFormatted 2\nDimension\n3\n# a comment\nVertices\n5\n"
                            "0 0 0 0\n0.1 0 0 7\n0 0.1 0 7\n0 0 0.30000000000000004 0\n"
                            "0.1 0.1 0.3 0\nTriangles 1\n1 2 3 4\nRidges 1\n1\n"
                            "Tetrahedra\n2\n1 2 3 4 10\n2 5 3 4 20\nEnd\n";
static const char NODE[] =
    "# made by hand\n5 3 1 1\n0 0 0 0 9.5 0\n1 0.1 0 0 9.5 2\n"
    "2 0 0.1 0 9.5 2\n3 0 0 0.30000000000000004 9.5 0\n4 0.1 0.1 0.3 9.5 0\n";
static const char ELE[] = "2 4 1\n0 0 1 2 3 10\n1 1 4 2 3 20\n# end\n";
static const char NODE_1[] = "5 3 0 0\n1 0 0 0\n2 0.1 0 0\n3 0 0.1 0\n4 0 0 0.30000000000000004\n"
                             "5 0.1 0.1 0.3\n";
static const char ELE_1[] = "2 4 0\n1 1 2 3 4\n2 2 5 3 4\n";

static const char VTK[] =
    "# vtk DataFile Version 2.0\na title\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0 0.1 0 0\n0 0.1 0 0 0 0.30000000000000004 0.1 0.1 0.3\n\nCELLS 3 14\n3 0 1 2\n"
    "4 0 1 2 3\n4 1 4 2 3\n\nCELL_TYPES 3\n5\n10 10\n\nCELL_DATA 3\nSCALARS region int 1\n"
    "LOOKUP_TABLE default\n0 10 20\nFIELD FieldData 3\nyoung 1 3 double\n0 1e6 2e6\n"
    "poisson 1 3 double\n0 0.3 0.4\ndensity 1 3 double\n0 1000 2000\n"
    "POINT_DATA 5\nSCALARS held unsigned_char 1\nLOOKUP_TABLE default\n0 1 1 0 0\n"
    "VECTORS speed float\n0 0 0 0 0 0 0 0 0 0 0 0 0 0 0\n";
static const char VTK_5[] =
    "# vtk DataFile Version 5.1\nvtk output\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"
    "0 0 0 0.1 0 0 0 0.1 0\n0 0 0.30000000000000004 0.1 0.1 0.3\nMETADATA\nINFORMATION 1\n"
    "NAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\nCELLS 3 8\nOFFSETS vtktypeint64\n"
    "0 4 8\nCONNECTIVITY vtktypeint64\n0 1 2 3\n1 4 2 3\nCELL_TYPES 2\n10\n10\n";

#define VTU_HEAD(attributes)                                                                       \
  "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" " attributes ">\n"                  \
  "<UnstructuredGrid><!-- a > comment -->\n<Piece NumberOfPoints='5' NumberOfCells=\"2\">\n"
#define VTU_TAIL "</Piece></UnstructuredGrid></VTKFile>\n"
static const char VTU[] = VTU_HEAD(
    "version=\"0.1\"") "<PointData><DataArray type=\"UInt8\" "
                       "Name=\"held &amp; a&gt;b\" format=\"ascii\">0 1 1 0 "
                       "0</DataArray></PointData>"
                       "<CellData><DataArray type=\"Int32\" Name=\"region\" format=\"ascii\">10 "
                       "20</DataArray>"
                       "</CellData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
                       "format=\"ascii\">"
                       "0 0 0 0.1 0 0 0 0.1 0\n0 0 0.30000000000000004 0.1 0.1 "
                       "0.3</DataArray></Points>\n<Cells>"
                       "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 1 "
                       "4 2 3</DataArray>"
                       "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 8</DataArray>"
                       "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 "
                       "10</DataArray></Cells>" VTU_TAIL;

static const char INP[] =
    "*Heading\n two tets\n** a comment\n*Part, name=Body\n*NODE, NSET=all\n10, 0, 0, 0\n"
    "20, 0.1\n30, 0, 0.1, 0\n40, 0, 0, 0.30000000000000004\n50, 0.1, 0.1, 0.3\n"
    "*Element, type=S3, elset=skin\n1, 10, 20, 30\n"
    "*Element, type=C3D4,\n elset=one\n7, 10, 20, 30, 40\n*ELEMENT, TYPE=C3D4\n8, 20, 50, 30, 40\n"
    "*Nset, nset=\"Held End\"\n20,\n30\n*NSET, NSET=steps, GENERATE\n10, 30, 20\n"
    "*NSET, NSET=both\nheld end, 50\n*Elset, elset=Two\n8\n*Elset, elset=painted\n1\n"
    "*Solid Section, elset=ONE, material=Soft\n,\n*Solid Section, elset=two, material=HARD\n"
    "*End Part\n*Material, name=SOFT\n*Elastic\n1e6, 0.3\n*Density\n1000.,\n"
    "*Material, name=hard\n*Density\n2000\n*Elastic, type=isotropic\n2e6, 0.4, 20\n"
    "*Step\n*Static\n0.1, 1\n*Boundary\nbody.held, 1, 3\n*End Step\n";

/* The vertices bit for bit and the tetrahedra, in every format. */
static void check_mesh(const thrum_mesh *mesh) {
  assert_int_equal(mesh->vertex_count, 5);
  assert_int_equal(mesh->tet_count, 2);
  assert_memory_equal(mesh->vertices, POINTS, sizeof POINTS);
  assert_memory_equal(mesh->tets, TETS, sizeof TETS);
  assert_int_equal(mesh->flipped_tets, 0);
}

static void check_group(const thrum_mesh *mesh, const char *name, int count, int first, int last) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0) {
      assert_int_equal(mesh->groups[g].count, count);
      assert_int_equal(mesh->groups[g].vertices[0], first);
      assert_int_equal(mesh->groups[g].vertices[count - 1], last);
      return;
    }
  fail_msg("no group %s", name);
}

static void check_regions(const thrum_mesh *mesh) {
  assert_int_equal(mesh->region_count, 2);
  assert_int_equal(mesh->tet_region[0], 0);
  assert_int_equal(mesh->tet_region[1], 1);
}

static void check_materials(const thrum_mesh *mesh) {
  const thrum_material expected[2] = {{1e6, 0.3, 1000}, {2e6, 0.4, 2000}};
  check_regions(mesh);
  assert_true(mesh->has_material);
  assert_memory_equal(mesh->materials, expected, sizeof expected);
}

static void medit_files_give_references_as_groups_and_regions(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.mesh", MEDIT);
  check_mesh(&mesh);
  check_regions(&mesh);
  assert_false(mesh.has_material);
  assert_int_equal(mesh.group_count, 4);
  check_group(&mesh, "vertices_7", 2, 1, 2);
  check_group(&mesh, "triangles_4", 3, 0, 2);
  check_group(&mesh, "tetrahedra_10", 4, 0, 3);
  check_group(&mesh, "tetrahedra_20", 4, 1, 4);
  thrum_mesh_free(&mesh);
}

static void tetgen_pairs_count_from_the_first_index(void **state) {
  (void)state;
  static const char *const either[] = {"a.node", "a.ele"};

  // the indices of a pair may begin at 0 or at 1
  const char *texts[2][2] = {{NODE, ELE}, {NODE_1, ELE_1}};
  for (int base = 0; base < 2; base++) {
    mesh_write_text("a.node", texts[base][0]);
    mesh_write_text("a.ele", texts[base][1]);

    // either file of the pair names the mesh
    for (int i = 0; i < 2; i++) {
      thrum_mesh mesh = mesh_good(either[i], texts[base][i]);
      check_mesh(&mesh);
      if (base == 0) {
        check_regions(&mesh);
        check_group(&mesh, "marker_2", 2, 1, 2);
        check_group(&mesh, "region_20", 4, 1, 4);
        assert_int_equal(mesh.file_number[4], 4);
      } else {
        assert_int_equal(mesh.region_count, 1);
        assert_int_equal(mesh.group_count, 0);
      }
      thrum_mesh_free(&mesh);
    }
  }
}

static void vtk_files_give_cell_and_point_data_as_regions_and_groups(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.vtk", VTK);
  check_mesh(&mesh);
  check_materials(&mesh);
  check_group(&mesh, "held", 2, 1, 2);
  thrum_mesh_free(&mesh);
  mesh = mesh_good("a.vtk", VTK_5);
  check_mesh(&mesh);
  assert_int_equal(mesh.region_count, 1);
  thrum_mesh_free(&mesh);
}

static void put_big(unsigned char **at, uint64_t bits, int size) {
  for (int i = size - 1; i >= 0; i--)
    *(*at)++ = (unsigned char)(bits >> 8 * i & 0xff);
}

static void binary_vtk_is_big_endian(void **state) {
  (void)state;

  // the header and the points, most significant byte first
  unsigned char bytes[1000], *at = bytes;
  static const char head[] = "# vtk DataFile Version 3.0\n\nBINARY\nDATASET UNSTRUCTURED_GRID\n"
                             "POINTS 5 double\n";
  memcpy(at, head, sizeof head - 1);
  at += sizeof head - 1;
  for (int i = 0; i < 15; i++) {
    uint64_t bits;
    memcpy(&bits, &POINTS[i / 3][i % 3], sizeof bits);
    put_big(&at, bits, 8);
  }

  // two cells of four points each
  at += sprintf((char *)at, "\nCELLS 2 10\n");
  for (int t = 0; t < 2; t++) {
    put_big(&at, 4, 4);
    for (int a = 0; a < 4; a++)
      put_big(&at, (uint64_t)TETS[t][a], 4);
  }

  // both are tetrahedra
  at += sprintf((char *)at, "\nCELL_TYPES 2\n");
  put_big(&at, 10, 4);
  put_big(&at, 10, 4);

  // the file is read, and refused when its last bytes are missing
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  const char *path = mesh_write("a.vtk", (char *)bytes, (size_t)(at - bytes));
  if (thrum_mesh_read(path, 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  check_mesh(&mesh);
  thrum_mesh_free(&mesh);
  mesh_bad_bytes("a.vtk", (char *)bytes, (size_t)(at - bytes) - 5, "longer than the file");
}

static void vtu_files_in_ascii_are_read(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.vtu", VTU);
  check_mesh(&mesh);
  check_regions(&mesh);
  check_group(&mesh, "held & a>b", 2, 1, 2);
  thrum_mesh_free(&mesh);
}

static size_t base64(const unsigned char *bytes, size_t size, char *text) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  size_t used = 0;
  for (size_t i = 0; i < size; i += 3) {
    uint32_t bits = 0;
    for (size_t j = 0; j < 3; j++)
      bits = bits << 8 | (i + j < size ? bytes[i + j] : 0);
    for (size_t j = 0; j < 4; j++)
      text[used++] = i + j > size ? '=' : digits[bits >> (18 - 6 * j) & 63];
  }
  text[used] = 0;
  return used;
}

/* The bytes of an array behind their length, in either byte order. */
static size_t packed(const void *values, size_t size, int width, int header, bool little,
                     unsigned char *bytes) {
  const uint64_t length = size;
  for (int i = 0; i < header; i++)
    bytes[i] = (unsigned char)(length >> 8 * (little ? i : header - 1 - i) & 0xff);
  for (size_t i = 0; i < size; i += (size_t)width) {
    uint64_t bits = 0;
    if (width == 8)
      memcpy(&bits, (const char *)values + i, 8);
    else
      bits = ((const unsigned char *)values)[i];
    for (int j = 0; j < width; j++)
      bytes[(size_t)header + i + (size_t)j] =
          (unsigned char)(bits >> 8 * (little ? j : width - 1 - j) & 0xff);
  }
  return (size_t)header + size;
}

/* The mesh as a .vtu file: the arrays are inline in base64, or appended in base64 or raw. */
static size_t make_vtu(char *file, int header, bool little, bool in_line, bool raw) {
  // the arrays that a grid needs
  static const int64_t list[8] = {0, 1, 2, 3, 1, 4, 2, 3}, ends[2] = {4, 8};
  static const unsigned char types[2] = {10, 10};
  const struct {
    const char *name, *type, *open, *close;
    const void *values;
    size_t size;
    int width;
  } arrays[] = {{"Points", "Float64", "<Points>", "</Points>", POINTS, sizeof POINTS, 8},
                {"connectivity", "Int64", "<Cells>", "", list, sizeof list, 8},
                {"offsets", "Int64", "", "", ends, sizeof ends, 8},
                {"types", "UInt8", "", "</Cells>", types, sizeof types, 1}};

  // appended data is collected while the tags are written
  char appended[2000];
  size_t offset = 0, used = 0;
  used += (size_t)sprintf(file, VTU_HEAD("header_type=\"%s\" byte_order=\"%s\""),
                          header == 8 ? "UInt64" : "UInt32", little ? "LittleEndian" : "BigEndian");

  // each array in its encoding, with its tag
  for (int i = 0; i < 4; i++) {
    unsigned char bytes[500];
    char text[700];
    const size_t size =
        packed(arrays[i].values, arrays[i].size, arrays[i].width, header, little, bytes);
    const size_t length = base64(bytes, size, text);
    used += (size_t)sprintf(file + used, "%s<DataArray type=\"%s\" Name=\"%s\" ", arrays[i].open,
                            arrays[i].type, arrays[i].name);

    // the tag holds the data itself or the offset
    if (in_line)
      used += (size_t)sprintf(file + used, "format=\"binary\">\n  %s\n</DataArray>%s", text,
                              arrays[i].close);
    else
      used += (size_t)sprintf(file + used, "format=\"appended\" offset=\"%zu\"/>%s", offset,
                              arrays[i].close);
    memcpy(appended + offset, raw ? (const char *)bytes : text, raw ? size : length);
    offset += raw ? size : length;
  }

  // the appended block follows the grid
  used += (size_t)sprintf(file + used, "</Piece></UnstructuredGrid>");
  if (!in_line) {
    used +=
        (size_t)sprintf(file + used, "<AppendedData encoding=\"%s\">\n_", raw ? "raw" : "base64");
    memcpy(file + used, appended, offset);
    used += offset;
    used += (size_t)sprintf(file + used, "\n</AppendedData>");
  }

  return used + (size_t)sprintf(file + used, "</VTKFile>\n");
}

static void vtu_files_of_bytes_are_read_in_every_encoding(void **state) {
  (void)state;
  for (int n = 0; n < 12; n++) {
    char file[6000];
    const int encoding = n / 4;
    const size_t size =
        make_vtu(file, n % 2 == 0 ? 4 : 8, n / 2 % 2 == 0, encoding == 0, encoding == 2);
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(mesh_write("a.vtu", file, size), 1, &mesh, &error) < 0)
      fail_msg("%d: %s", n, error.message);
    check_mesh(&mesh);
    thrum_mesh_free(&mesh);
  }
}

static void numbers_may_be_those_of_fortran(void **state) {
  (void)state;
  static const char *const names[] = {"f.mesh", "f.vtk", "f.ele"};
  mesh_write_text("f.mesh",
                  "MeshVersionFormatted 1\nDimension\n3\nVertices\n4\n0.D0 0. 0. 0\n"
                  "1.d+00 0. 0. 0\n0. .2+1 0. 0\n0. 0. 1.0E0 0\nTetrahedra\n1\n1 2 3 4 1\n");
  mesh_write_text("f.vtk", "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                           "POINTS 4 double\n0.D0 0. 0. 1.d+00 0. 0. 0. .2+1 0. 0. 0. 1.0E0\n"
                           "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10\n");
  mesh_write_text("f.node", "4 3 0 0\n1 0.D0 0. 0.\n2 1.d+00 0. 0.\n3 0. .2+1 0.\n4 0. 0. 1.0E0\n");
  mesh_write_text("f.ele", "1 4 1\n1 1 2 3 4 7.D0\n");
  for (int n = 0; n < 3; n++) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", mesh_folder, names[n]);
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(path, 1, &mesh, &error) < 0)
      fail_msg("%s", error.message);
    assert_true(fabs(thrum_mesh_tet_volume(&mesh, 0) - 1.0 / 3) < 1e-15);
    thrum_mesh_free(&mesh);
  }
}

static void abaqus_files_give_sets_and_sections(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", INP);
  check_mesh(&mesh);
  check_materials(&mesh);

  // node sets and element sets, in every notation
  check_group(&mesh, "all", 5, 0, 4);
  check_group(&mesh, "Held End", 2, 1, 2);
  check_group(&mesh, "steps", 2, 0, 2);
  check_group(&mesh, "both", 3, 1, 4);
  check_group(&mesh, "skin", 3, 0, 2);
  check_group(&mesh, "painted", 3, 0, 2);
  check_group(&mesh, "one", 4, 0, 3);
  check_group(&mesh, "Two", 4, 1, 4);

  // the numbers of the file are kept
  assert_int_equal(mesh.file_number[4], 50);
  assert_int_equal(mesh.cornered_tets, 0);

  thrum_mesh_free(&mesh);
}

#define INP_NODES "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"
#define INP_TET INP_NODES "*ELEMENT,TYPE=C3D4,ELSET=E\n1,1,2,3,4\n"

static void tets_of_ten_nodes_are_read_by_their_corners_where_asked_and_counted(void **state) {
  (void)state;

  // Abaqus lists the corners first
  const char *path = mesh_write_text(
      "a.inp", INP_NODES "5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n"
                         "*ELEMENT, TYPE=C3D10M\n1,1,2,3,4,5,6,\n7,8,9,10\n");
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read_order(path, 1, 1, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.vertex_count, 4);
  assert_int_equal(mesh.tet_count, 1);
  assert_int_equal(mesh.cornered_tets, 1);
  assert_int_equal(mesh.dropped_vertices, 6);
  assert_null(mesh.midsides);
  thrum_mesh_free(&mesh);

  // TetGen lists the corners first as well, but orders the middle nodes in its own way
  static const char nodes[] = "10 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .5 0 0\n6 .5 .5 0\n"
                              "7 0 .5 0\n8 0 0 .5\n9 .5 0 .5\n10 0 .5 .5\n";
  path = mesh_write_text("b.ele", "1 10 0\n1 1 2 3 4 10 8 5 6 9 7\n");
  mesh_write_text("b.node", nodes);
  for (int order = 0; order < 2; order++) {
    assert_int_equal(thrum_mesh_read_order(path, 1, order, &mesh, NULL), THRUM_OK);
    assert_int_equal(mesh.cornered_tets, order);
    assert_int_equal(mesh.vertex_count, order == 0 ? 10 : 4);
    for (int e = 0; e < 6 && order == 0; e++)
      assert_int_equal(mesh.midsides[e], 4 + e);
    thrum_mesh_free(&mesh);
  }
}

static void an_abaqus_file_without_density_has_no_material(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", INP_TET "*SOLID SECTION, ELSET=E, MATERIAL=M\n"
                                               "*MATERIAL, NAME=M\n*ELASTIC\n1e6, .3\n");
  assert_false(mesh.has_material);
  thrum_mesh_free(&mesh);
}

typedef struct bad_case {
  const char *name, *text, *words;
} bad_case;

static void bad_files_are_refused_with_their_line(void **state) {
  (void)state;
  static const bad_case cases[] = {
      // Medit
      {"a.mesh", "", "there is no MeshVersionFormatted"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 2\n", ":2: the mesh is flat"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 3\nVertices 2\n0 0 0 0\n",
       "the file ends before the x coordinate"},
      {"a.mesh", "MeshVersionFormatted 2\nVertices 1\n0 0,5 0 0\n",
       ":3: expected the y coordinate"},
      {"a.mesh", "MeshVersionFormatted 2\nVertices 1\n0 0 0 0 7\n", ":3: expected a keyword"},
      {"a.mesh", "MeshVersionFormatted 2\nVertices 1\n0 0 0 0\nTetrahedra 1\n1 2 3 4 0\n",
       ":5: tet 1 names vertex 2"},
      {"a.mesh", "MeshVersionFormatted 2\nVertices 1\n0 0 0 0\nTetrahedra 1\n1 2 3 4294967297 0\n",
       ":5: a vertex is 4294967297, which is out of range"},
      {"a.mesh", "MeshVersionFormatted 2\nVertices 0\n", "there are no Tetrahedra"},

      // TetGen
      {"c.ele", "1 4 0\n1 1 2 3 4\n", "c.node"},
      {"d.node", "4 2 0 0\n", ":1: the dimension is 2"},
      {"d.node", "2 3 0 0\n2 0 0 0\n", ":2: the index of a node is 2"},
      {"d.node", "2 3 0 0\n1 0 0 0\n3 0 0 0\n", ":3: the index of a node is 3 where 2 comes next"},
      {"d.node", "2 3 0 0\n1 0 0 0 5\n2 0 0 1\n", ":2: unexpected '5'"},

      // VTK's old format
      {"a.vtk", "", "the file ends before the version"},
      {"a.vtk", "solid\n", ":1: expected '# vtk DataFile Version'"},
      {"a.vtk", "# vtk DataFile Version 3", "the file ends before ASCII or BINARY"},
      {"a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n",
       ":4: expected DATASET UNSTRUCTURED_GRID"},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 99999999 double\n0",
       ":5: an array is longer than the file"},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 quad\n0 0 0\n",
       ":5: numbers of type 'quad'"},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 double\n0 0 0\n"
       "CELLS 1 9\n8 0 0 0 0 0 0 0 0\nCELL_TYPES 1\n42\n",
       "cell 0 is of type 42, which is not supported"},
      {"a.vtk",
       "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 double\n0 0 0\n"
       "CELLS 1 5\n4 0 0 0 5\nCELL_TYPES 1\n10\n",
       "tet 1 names vertex 5"},

      // VTK's XML format
      {"a.vtu", "", "there is no <VTKFile>"},
      {"a.vtu", "<VTKFile type=\"PolyData\">", "is no UnstructuredGrid"},
      {"a.vtu", "<VTKFile type=\"UnstructuredGrid\">", "the grid has no points"},
      {"a.vtu", VTU_HEAD("") "<Points><DataArray type=\"Float64\" format=\"ascii\">0 x 0",
       "expected a number, found 'x'"},
      {"a.vtu",
       VTU_HEAD("") "<Points><DataArray type=\"Float64\" format=\"appended\" "
                    "offset=\"5\"/></Points>",
       "beyond the appended data"},
      {"a.vtu",
       VTU_HEAD("") "<Points><DataArray type=\"Float64\" format=\"binary\">"
                    "/////w==</DataArray></Points>",
       "longer than the file"},

      // formats of other versions and orders
      {"a.msh", "$NOD\n1\n1 0 0 0\n$ENDNOD\n", "a.msh:1: version 1 is not read, only 2.2 and 4.1"},
      {"a.msh", "$MeshFormat\n4 0 8\n$EndMeshFormat\n", "convert it with: gmsh FILE -save"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 3\nHexahedraQ2\n1\n",
       "HexahedraQ2 is not read"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 3\nPolyhedraHeaders\n1\n1 1\n",
       "a.mesh:3: PolyhedraHeaders is not read"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 3\nIncludeFile \"b.mesh\"\n",
       "a.mesh:3: IncludeFile is not read; save the mesh as one file"},
      {"a.mesh", "MeshVersionFormatted 2\nDimension 3\nTetrahedraP3Ordering\n1\n",
       "a.mesh:3: TetrahedraP3Ordering is not read; save the mesh with Tetrahedra"},

      // Abaqus
      {"a.inp", "", "there is no *NODE"},
      {"a.inp", "solid\n", ":1: expected a keyword such as *NODE"},
      {"a.inp", "*NODE\n1, 0, 0, x\n", ":2: expected the z coordinate, found 'x'"},
      {"a.inp", "*NODE\n1,0,0,0\n1,1,0,0\n*ELEMENT\n1,1,1,1,1\n", ":4: *ELEMENT needs TYPE="},
      {"a.inp", INP_NODES "*ELEMENT,TYPE=C3D27\n", ":6: elements of type C3D27 are not supported"},
      {"a.inp", INP_NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3\n", "element 1 has too few nodes: 3, not 4"},
      {"a.inp", INP_NODES "*ELEMENT,TYPE=C3D4\n1,1,2,3,9\n", ":7: tet 1 names vertex 9"},
      {"a.inp", INP_TET "1,1,2,3,4\n", "element 1 comes twice"},
      {"a.inp", INP_TET "*NSET,NSET=S\nnone\n", ":9: the set names 'none'"},
      {"a.inp", INP_TET "*NSET,NSET=S\n12\n", "group 'S' names vertex 12"},
      {"a.inp", INP_TET "*ELSET,ELSET=S\n12\n", "set 'S' names element 12"},
      {"a.inp", INP_TET "*ELSET\n1\n", ":8: the set has no name"},
      {"a.inp", INP_TET "*NSET,NSET=S,GENERATE\n1,2000000000\n", ":9: a range is longer"},
      {"a.inp", INP_TET "*SOLID SECTION,ELSET=X,MATERIAL=M\n", ":8: there is no element set 'X'"},
      {"a.inp", INP_TET "*SOLID SECTION,ELSET=E,MATERIAL=M\n", ":8: there is no material 'M'"},
      {"a.inp", INP_TET "*MATERIAL,NAME=M\n*ELASTIC,TYPE=ANISOTROPIC\n1,1\n",
       ":9: *ELASTIC of type ANISOTROPIC"},
      {"a.inp", INP_TET "*INCLUDE, INPUT=x.inp\n", ":8: cannot find the included file"},
      {"a.inp", "*PART, NAME=A\n" INP_TET "*PART, NAME=B\n", ":9: there are several parts"},
  };

  // the .node files among the cases need a partner
  mesh_write_text("d.ele", ELE_1);
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    mesh_bad(cases[i].name, cases[i].text, cases[i].words);
}

/* Every truncation, and every byte replaced by some others: the file is read or refused, and the
 * sanitizers find the rest. */
static void damage(const char *name, const char *data, size_t size) {
  static const char bytes[] = {0, '\n', '9', '-', '*', '<', (char)0xff};
  char *copy = malloc(size + 1);
  assert_non_null(copy);

  // each byte is replaced in turn; the last round truncates the file there instead
  for (size_t n = 0; n < size; n++) {
    for (size_t b = 0; b <= sizeof bytes; b++) {
      memcpy(copy, data, size);
      copy[n] = b < sizeof bytes ? bytes[b] : copy[n];
      thrum_mesh mesh = {0};
      const size_t length = b < sizeof bytes ? size : n;

      // the reader of this format, without the file system
      const thrum_mesh_source source = {name, copy, length, NULL, false, false};
      const thrum_mesh_source nodes = {name, NODE, strlen(NODE), NULL, false, false};
      thrum_status status =
          strcmp(name, "a.mesh") == 0  ? thrum_mesh_parse_medit(&source, &mesh, NULL)
          : strcmp(name, "a.vtk") == 0 ? thrum_mesh_parse_vtk(&source, &mesh, NULL)
          : strcmp(name, "a.vtu") == 0 ? thrum_mesh_parse_vtu(&source, &mesh, NULL)
          : strcmp(name, "a.inp") == 0 ? thrum_mesh_parse_abaqus(&source, &mesh, NULL)
                                       : thrum_mesh_parse_tetgen(&nodes, &source, &mesh, NULL);

      // a refusal leaves no mesh behind
      if (status < 0)
        assert_null(mesh.tets);
      thrum_mesh_free(&mesh);
    }
  }

  free(copy);
}

static void damaged_files_are_read_or_refused(void **state) {
  (void)state;
  char file[6000];
  damage("a.mesh", MEDIT, strlen(MEDIT));
  damage("a.ele", ELE, strlen(ELE));
  damage("a.vtk", VTK, strlen(VTK));
  damage("a.vtk", VTK_5, strlen(VTK_5));
  damage("a.vtu", VTU, strlen(VTU));
  damage("a.inp", INP, strlen(INP));
  for (int n = 0; n < 3; n++)
    damage("a.vtu", file, make_vtu(file, 8, true, n == 0, n == 2));
}

/* The same text with other line endings and with a byte-order mark. */
static void ends_of_lines_and_byte_order_marks_make_no_difference(void **state) {
  (void)state;
  static const char *const names[] = {"a.mesh", "a.vtk", "a.vtu", "a.inp"};
  static const char *const texts[] = {MEDIT, VTK, VTU, INP};
  for (int i = 0; i < 4; i++) {
    // a byte-order mark, and CR LF for each LF
    char text[8000] = "\xef\xbb\xbf";
    size_t used = 3;
    for (const char *p = texts[i]; *p; p++) {
      if (*p == '\n')
        text[used++] = '\r';
      text[used++] = *p;
    }
    text[used] = 0;

    // the mesh is the same
    thrum_mesh mesh = mesh_good(names[i], text);
    check_mesh(&mesh);
    thrum_mesh_free(&mesh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // Medit and TetGen
      cmocka_unit_test(medit_files_give_references_as_groups_and_regions),
      cmocka_unit_test(tetgen_pairs_count_from_the_first_index),

      // VTK
      cmocka_unit_test(vtk_files_give_cell_and_point_data_as_regions_and_groups),
      cmocka_unit_test(binary_vtk_is_big_endian),
      cmocka_unit_test(vtu_files_in_ascii_are_read),
      cmocka_unit_test(vtu_files_of_bytes_are_read_in_every_encoding),

      // Abaqus
      cmocka_unit_test(numbers_may_be_those_of_fortran),
      cmocka_unit_test(abaqus_files_give_sets_and_sections),
      cmocka_unit_test(tets_of_ten_nodes_are_read_by_their_corners_where_asked_and_counted),
      cmocka_unit_test(an_abaqus_file_without_density_has_no_material),

      // refusals and damage
      cmocka_unit_test(bad_files_are_refused_with_their_line),
      cmocka_unit_test(damaged_files_are_read_or_refused),
      cmocka_unit_test(ends_of_lines_and_byte_order_marks_make_no_difference),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
