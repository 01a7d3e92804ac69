/* The description of VTK's XML files, line by line: each has a file that has it, which is read for
 * what it says or refused by name. The files hold two tetrahedra of five points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include "mesh/mesh_groups.h"

/* What a file has in the place of the plain one's; NULL: as the plain one. */
typedef struct vtu_dress {
  const char *file;                        /* attributes of <VTKFile> */
  const char *grid;                        /* attributes of <UnstructuredGrid> */
  const char *point;                       /* attributes of the points' array */
  const char *points, *corners, *offsets;  /* numbers */
  const char *index;                       /* attributes of the connectivity's array */
  const char *types;                       /* numbers */
  const char *point_data, *cell_data;      /* arrays */
  const char *more_points, *more, *behind; /* behind the points, the cells and the grid */
} vtu_dress;

#define OF(value, plain) ((value) ? (value) : (plain))
#define UG "type=\"UnstructuredGrid\" "
#define PLACES "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1"
#define THREE "type=\"Float64\" NumberOfComponents=\"3\" "
#define ARRAY(type, name, numbers)                                                                 \
  "<DataArray type=\"" type "\" Name=\"" name "\" format=\"ascii\">" numbers "</DataArray>"

static const char *dress(const vtu_dress *d) {
  static char file[4000];
  snprintf(file, sizeof file,
           "<?xml version=\"1.0\"?>\n<VTKFile %s>\n<UnstructuredGrid %s>\n"
           "<FieldData><Array type=\"String\" Name=\"s\" NumberOfTuples=\"1\">65 0</Array>\n"
           "<DataArray type=\"Float64\" Name=\"TimeValue\">1.5</DataArray></FieldData>\n"
           "<Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">\n<PointData>%s</PointData>\n"
           "<CellData>%s</CellData>\n<Points><DataArray %s>%s</DataArray>%s</Points>\n<Cells>\n"
           "<DataArray %s Name=\"connectivity\">%s</DataArray>\n"
           "<DataArray type=\"Int64\" Name=\"offsets\">%s</DataArray>\n"
           "<DataArray type=\"UInt8\" Name=\"types\">%s</DataArray>%s</Cells>\n</Piece>\n"
           "</UnstructuredGrid>%s</VTKFile>\n",
           OF(d->file, UG "version=\"1.0\" byte_order=\"LittleEndian\""), OF(d->grid, ""),
           OF(d->point_data, ""), OF(d->cell_data, ""), OF(d->point, THREE "format=\"ascii\""),
           OF(d->points, PLACES), OF(d->more_points, ""), OF(d->index, "type=\"Int64\""),
           OF(d->corners, "0 1 2 3 1 2 3 4"), OF(d->offsets, "4 8"), OF(d->types, "10 10"),
           OF(d->more, ""), OF(d->behind, ""));
  return file;
}

/* Five points of 32-bit numbers in base64, behind 60, their length, and in the other byte order. */
#define LITTLE                                                                                     \
  "PAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAACAPwAAgD8AAIA/AACAPw=="
#define BIG                                                                                        \
  "AAAAPAAAAAAAAAAAAAAAAD+AAAAAAAAAAAAAAAAAAAA/gAAAAAAAAAAAAAAAAAAAP4AAAD+AAAA/gAAAP4AAAA=="
#define SINGLE "type=\"Float32\" NumberOfComponents=\"3\" "

static void what_the_format_has_is_read(void **state) {
  (void)state;
  static const vtu_dress good[] = {
      {0},
      {.file = UG "version=\"0.1\""},
      {.file = UG "version=\"2.3\" byte_order=\"LittleEndian\" header_type=\"UInt32\""},
      {.file = UG "compressor=\"\""},
      {.grid = "TimeValues=\"0.5\""},
      {.point = "type=\"Float32\""},
      {.point = SINGLE "format=\"binary\"", .points = "\n" LITTLE "\n"},
      {.file = UG "byte_order=\"BigEndian\"", .point = SINGLE "format=\"binary\"", .points = BIG},
      {.point = SINGLE "format=\"appended\" offset=\"0\"",
       .points = "",
       .behind = "<AppendedData encoding=\"base64\">\n  _" LITTLE "\n</AppendedData>"},
      {.point = SINGLE "format=\"appended\" offset=\"2\"",
       .points = "",
       .behind = "<AppendedData>_AA" LITTLE "</AppendedData>"},
      // a key of information holds no numbers, wherever it stands
      {.points = "<InformationKey name=\"L2\"><Value>7</Value></InformationKey>" PLACES},
      {.points = PLACES "<InformationKey name=\"L2\"><Value>7</Value></InformationKey>"},
      {.more = ARRAY("Int64", "faces", "") ARRAY("Int64", "faceoffsets", "-1 -1")},
      {.cell_data = ARRAY("Float64", "stress", "nan inf"),
       .point_data = ARRAY("String", "label", "")},
      {.cell_data = ARRAY("UInt8", "vtkGhostType", "0 16")}};
  for (size_t n = 0; n < sizeof good / sizeof *good; n++) {
    thrum_mesh mesh = mesh_good("a.vtu", dress(&good[n]));
    assert_int_equal(mesh.vertex_count, 5);
    assert_int_equal(mesh.tet_count, 2);
    assert_true(thrum_mesh_tet_volume(&mesh, 0) == 1.0 / 6);
    assert_int_equal(mesh.note_count, 0);
    thrum_mesh_free(&mesh);
  }
}

static void each_type_of_numbers_is_read(void **state) {
  (void)state;
  static const char *const types[] = {"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                      "UInt32", "Int64", "UInt64", "Float32", "Float64"};
  for (size_t n = 0; n < sizeof types / sizeof *types; n++) {
    char data[200], index[40];
    snprintf(data, sizeof data, "<DataArray type=\"%s\" Name=\"region\">3 7</DataArray>", types[n]);
    snprintf(index, sizeof index, "type=\"%s\"", types[n]);
    thrum_mesh mesh = mesh_good("a.vtu", dress(&(vtu_dress){.index = index, .cell_data = data}));

    // regions are whole numbers of a whole type
    assert_int_equal(mesh.region_count, types[n][0] == 'F' ? 1 : 2);
    thrum_mesh_free(&mesh);
  }
}

/* Bits are written eight a byte, the first one the highest: 1 1 0 0 0 is 0xc0. */
static void bits_mark_a_group(void **state) {
  (void)state;
  static const char *const bits[] = {
      "<DataArray type=\"Bit\" Name=\"held\" format=\"ascii\">1 1 0 0 0</DataArray>",
      "<DataArray type=\"Bit\" Name=\"held\" format=\"binary\">AQAAAMA=</DataArray>"};
  for (int n = 0; n < 2; n++) {
    thrum_mesh mesh = mesh_good("a.vtu", dress(&(vtu_dress){.point_data = bits[n]}));
    assert_int_equal(mesh.group_count, 1);
    assert_string_equal(mesh.groups[0].name, "held");
    assert_int_equal(mesh.groups[0].count, 2);
    assert_int_equal(mesh.groups[0].vertices[1], 1);
    thrum_mesh_free(&mesh);
  }
}

static void what_is_not_done_is_refused_by_name(void **state) {
  (void)state;
  static const struct {
    vtu_dress dress;
    const char *words;
  } bad[] = {
      // the file
      {{.file = "type=\"PUnstructuredGrid\""}, "a.vtu:2: names the files of a parallel grid"},
      {{.file = "type=\"PolyData\""}, "a.vtu:2: is no UnstructuredGrid"},
      {{.file = UG "version=\"3.0\""}, "a.vtu:2: is of version 3.0, which is not known"},
      {{.file = UG "byte_order=\"Middle\""}, "a.vtu:2: byte_order is 'Middle'; expected Little"},
      {{.file = UG "header_type=\"UInt16\""}, "a.vtu:2: header_type is 'UInt16'; expected UInt32"},
      {{.file = UG "compressor=\"vtkLZ4DataCompressor\""}, "a.vtu:2: is compressed in a way"},
      {{.file = UG "compressor=\"vtkLZMADataCompressor\""}, "a.vtu:2: is compressed in a way"},

      // an array
      {{.point = THREE "format=\"base64\""}, "a.vtu:9: format is 'base64'; expected ascii"},
      {{.point = THREE "format=\"appended\"",
        .points = "",
        .behind = "<AppendedData>_" LITTLE "</AppendedData>"},
       "a.vtu:9: an appended array has no offset"},
      {{.point = SINGLE "format=\"appended\" offset=\"0\"",
        .points = "",
        .behind = "<AppendedData encoding=\"hex\">_" LITTLE "</AppendedData>"},
       "a.vtu:15: encoding is 'hex'; expected raw or base64"},
      {{.point = THREE "format=\"binary\"", .points = LITTLE},
       "a.vtu:9: an array ends within a number"},
      {{.point = "type=\"Float64\" NumberOfComponents=\"2\""}, "a.vtu:9: points must have three"},
      {{.point = "type=\"String\""}, "a.vtu:9: an array of the grid has a type that is not read"},
      {{.more_points = ARRAY("Float64", "Points", PLACES)}, "the array 'points' comes twice"},
      {{.more = ARRAY("Int64", "connectivity", "0 1 2 4 1 2 3 4")},
       "the array 'connectivity' comes twice, as of several time steps; save one of them"},

      // cells
      {{.corners = "0 1.5 2 3 1 2 3 4"},
       "array 'connectivity': expected a whole number, found '1."},
      {{.index = "type=\"Float64\"", .corners = "0 1.5 2 3 1 2 3 4"},
       "cell 0 names a point that is out of range or no whole number"},
      {{.corners = "0 1 2 3 1 2 3 4 0 1 2 4"},
       "the last cell ends at 8 of the connectivity, which has 12 numbers"},
      {{.types = "42 42"}, "cell 0 is of type 42, which is not supported"},
      {{.types = "10 71"}, "cell 1 is of type 71, which is not supported"},
      {{.cell_data = ARRAY("UInt8", "vtkGhostType", "0 1")},
       "cell 1 is a ghost or hidden ('vtkGhostType'), which is not read; save the grid without"},
      {{.cell_data = ARRAY("UInt8", "vtkGhostType", "32 0")}, "cell 0 is a ghost or hidden"},
      {{.cell_data = ARRAY("UInt8", "vtkGhostLevels", "0 2")}, "cell 1 is a ghost or hidden"},

      // data on points and cells
      {{.cell_data = ARRAY("Int32", "region", "1.5 2")}, "expected a whole number, found '1.5'"},
      {{.cell_data = ARRAY("Int32", "region", "1")},
       "a.vtu:8: array 'region' has 1 numbers, which is not 1 for each of the 2 cells"},
      {{.cell_data = ARRAY("Int32", "region", "")}, "a.vtu:8: array 'region' has 0 numbers"},
      {{.cell_data = ARRAY("Float64", "young", "1e6 1e6 1e6")}, "array 'young' has 3 numbers"},
      {{.point_data = ARRAY("Int8", "held", "1 1 0 0")},
       "a.vtu:7: array 'held' has 4 numbers, which is not 1 for each of the 5 points"},
      {{.cell_data = ARRAY("Int32", "region", "1 2") ARRAY("Int32", "region", "1 1")},
       "the array 'region' comes twice"},
      {{.point_data = ARRAY("Int8", "held", "1 1 0 0 0") ARRAY("Int8", "held", "0 0 1 0 0")},
       "the array 'held' comes twice"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++)
    mesh_bad("a.vtu", dress(&bad[n].dress), bad[n].words);
}

static void what_is_passed_over_is_said(void **state) {
  (void)state;
  static const struct {
    const char *data, *note;
  } cases[] = {
      {ARRAY("Float64", "MaterialIds", "1 2"),
       "the cell data 'MaterialIds' is not used; if it tells regions, give --regions MaterialIds"},
      {ARRAY("Int32", "layer", "1 2"),
       "the cell data 'layer' is not used; if it tells regions, give --regions layer"},
      {"<DataArray type=\"Int32\" Name=\"region\" NumberOfComponents=\"2\">1 2 3 4</DataArray>",
       "the cell data 'region' is not used: it has not one number a cell"},
      {ARRAY("Float64", "density", "1000 1000"),
       "the cell data 'density' is not used: a material is young, poisson and density"}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    thrum_mesh mesh = mesh_good("a.vtu", dress(&(vtu_dress){.cell_data = cases[n].data}));
    assert_int_equal(mesh.note_count, 1);
    if (!strstr(mesh.notes[0].text, cases[n].note))
      fail_msg("expected '%s' in: %s", cases[n].note, mesh.notes[0].text);
    assert_int_equal(mesh.region_count, 1);
    assert_false(mesh.has_material);
    thrum_mesh_free(&mesh);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_the_format_has_is_read),
      cmocka_unit_test(each_type_of_numbers_is_read),
      cmocka_unit_test(bits_mark_a_group),
      cmocka_unit_test(what_is_not_done_is_refused_by_name),
      cmocka_unit_test(what_is_passed_over_is_said),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
