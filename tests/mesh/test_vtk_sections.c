/* All sections that legacy VTK allows, as text and as bytes, in the old form of cells and in the
 * new one: two tetrahedra are found behind each of them, with their regions.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include "mesh/mesh_groups.h"

/* A text that grows, of numbers in words or in bytes, the highest first. */
typedef struct vtk_file {
  char data[8000];
  size_t size;
  bool binary;
} vtk_file;

static void add(vtk_file *file, const char *words) {
  const size_t length = strlen(words);
  memcpy(file->data + file->size, words, length + 1);
  file->size += length;
}

/* Adds numbers of a type: b bit, c byte, i int, l long, f float, d double. A byte of colours is a
 * share of 255 in words. */
static void numbers(vtk_file *file, char type, int count, const double *values) {
  unsigned packed = 0;
  for (int n = 0; n < count; n++) {
    const double value = values ? values[n] : n % 2;
    char word[40];
    if (!file->binary) {
      snprintf(word, sizeof word, "%.9g%s", value, n % 3 == 2 ? "\n" : " ");
      add(file, word);
      continue;
    }

    // eight bits a byte, the first one the highest
    if (type == 'b') {
      packed |= (unsigned)value << (7 - n % 8);
      if (n % 8 == 7 || n + 1 == count) {
        file->data[file->size++] = (char)packed;
        packed = 0;
      }
      continue;
    }
    const int size = type == 'c' ? 1 : type == 'i' || type == 'f' ? 4 : 8;
    const float single = (float)value;
    uint64_t bits = (uint64_t)(int64_t)value;
    uint32_t half;
    memcpy(&half, &single, sizeof half);
    if (type == 'd')
      memcpy(&bits, &value, sizeof bits);
    if (type == 'f')
      bits = half;
    for (int i = size - 1; i >= 0; i--)
      file->data[file->size++] = (char)(bits >> (8 * i));
  }
  add(file, "\n");
}

/* Two tetrahedra of five points, in the form of a version. */
static void begin(vtk_file *file, bool binary, int version) {
  static const double points[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  static const double old[10] = {4, 0, 1, 2, 3, 4, 1, 2, 3, 4}, types[2] = {10, 10};
  static const double offsets[3] = {0, 4, 8}, corners[8] = {0, 1, 2, 3, 1, 2, 3, 4};
  char line[60];
  *file = (vtk_file){.binary = binary};
  snprintf(line, sizeof line, "# vtk DataFile Version %d.%d\n\n", version, version == 5);
  add(file, line);
  add(file, binary ? "BINARY\n" : "ASCII\n");
  add(file, "DATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n");
  numbers(file, 'f', 15, points);
  if (version < 5) {
    add(file, "CELLS 2 10\n");
    numbers(file, 'i', 10, old);
  } else {
    add(file, "METADATA\nINFORMATION 1\nNAME L2 LOCATION x\nDATA 2 0 1\n\n");
    add(file, "CELLS 3 8\nOFFSETS vtktypeint64\n");
    numbers(file, 'l', 3, offsets);
    add(file, "CONNECTIVITY vtktypeint64\n");
    numbers(file, 'l', 8, corners);
  }
  add(file, "CELL_TYPES 2\n");
  numbers(file, 'i', 2, types);
}

static void each_section_is_read_and_passed(void **state) {
  (void)state;
  static const struct {
    const char *head;
    char type;
    int columns; /* of the two cells or five points */
  } sections[] = {{"SCALARS a int 1\nLOOKUP_TABLE default", 'i', 1},
                  {"SCALARS a int\nLOOKUP_TABLE colours", 'i', 1},
                  {"SCALARS a double 3", 'd', 3},
                  {"SCALARS a bit 1\nLOOKUP_TABLE default", 'b', 1},
                  {"COLOR_SCALARS a 4", 'c', 4},
                  {"VECTORS a float", 'f', 3},
                  {"NORMALS a float", 'f', 3},
                  {"TEXTURE_COORDINATES a 2 float", 'f', 2},
                  {"TENSORS a double", 'd', 9},
                  {"TENSORS6 a double", 'd', 6},
                  {"GLOBAL_IDS a vtkIdType", 'i', 1},
                  {"PEDIGREE_IDS a vtkIdType", 'i', 1},
                  {"EDGE_FLAGS a int", 'i', 1}};
  static const double regions[2] = {3, 7};
  for (size_t n = 0; n < 4 * sizeof sections / sizeof *sections; n++) {
    vtk_file file;
    char line[80];
    const size_t s = n / 4;
    begin(&file, n & 1, n & 2 ? 5 : 3);
    for (int place = 0; place < 2; place++) {
      const int rows = place == 0 ? 5 : 2;
      add(&file, place == 0 ? "POINT_DATA 5\n" : "CELL_DATA 2\n");
      snprintf(line, sizeof line, "%s\n", sections[s].head);
      add(&file, line);
      numbers(&file, sections[s].type, sections[s].columns * rows, NULL);
      add(&file, "METADATA\nCOMPONENT_NAMES\nX\nFIELD\n\nLOOKUP_TABLE colours 2\n");
      numbers(&file, 'c', 8, NULL);
      snprintf(line, sizeof line, "FIELD more 2\nb 1 %d double\n", rows);
      add(&file, line);
      numbers(&file, 'd', rows, NULL);
      add(&file, "METADATA\nINFORMATION 0\n\nc 0 0 float\n");
    }
    add(&file, "SCALARS mat_id int 1\nLOOKUP_TABLE colours\n");
    numbers(&file, 'i', 2, regions);

    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(mesh_write("a.vtk", file.data, file.size), 1, &mesh, &error) < 0)
      fail_msg("%s (%d): %s", sections[s].head, (int)n, error.message);
    assert_int_equal(mesh.tet_count, 2);
    assert_int_equal(mesh.region_count, 2);
    assert_string_equal(thrum_mesh_region_text(&mesh, 1).text, "7");
    thrum_mesh_free(&mesh);

    // cut off anywhere it is refused, or read as far as it goes, and never beyond its end
    for (size_t size = 0; size < file.size; size += 7) {
      const thrum_mesh_source source = {"a.vtk", file.data, size, NULL, false, false};
      if (thrum_mesh_parse_vtk(&source, &mesh, NULL) >= 0)
        thrum_mesh_free(&mesh);
    }
  }
}

static void a_voxel_is_a_box(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "a.vtk", "# vtk DataFile Version 2.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n"
               "0 0 0 2 0 0 0 1 0 2 1 0 0 0 1 2 0 1 0 1 1 2 1 1\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\n"
               "CELL_TYPES 1\n11\nCELL_DATA 1\nGLOBAL_IDS id int\n5\n");
  double volume = 0;
  for (int64_t t = 0; t < mesh.tet_count; t++)
    volume += thrum_mesh_tet_volume(&mesh, t);
  assert_true(volume > 2 - 1e-14 && volume < 2 + 1e-14);
  assert_int_equal(mesh.tet_count, 6);
  thrum_mesh_free(&mesh);
}

static void what_is_not_read_is_named(void **state) {
  (void)state;
  static const struct {
    const char *more, *words;
  } bad[] = {
      {"CELL_DATA 3\n", "CELL_DATA has 3 rows, but there are 2 cells"},
      {"POINT_DATA 3\n", "POINT_DATA has 3 rows, but there are 5 points"},
      {"CELL_DATA 2\nSCALARS a string 1\n", "numbers of type 'string' are not read"},
      {"CELL_DATA 2\nLOOKUP_TABLE t 99999999\n0 0 0 0\n", "is it cut short?"},
      {"CELL_DATA 2\nTEXTURE_COORDINATES t 4 float\n", "the number of columns is 4"},
      {"CELL_DATA 2\nHYPERTREES t\n", "expected a section such as POINTS or CELLS"},
      {"CELL_DATA 2\nSCALARS region int\n1 1.5\n", "expected a whole number, found '1.5'"},
      {"CELL_DATA 2\nFIELD f 1\nregion 1 3 int\n1 2 3\n",
       "array 'region' has 3 rows where the section says 2"},
      {"CELL_DATA 2\nSCALARS region int\n1 2\nSCALARS region int\n1 1\n",
       "the array 'region' comes twice"},
      {"CELL_DATA 2\nSCALARS vtkGhostType unsigned_char\n0 32\n", "cell 1 is a ghost or hidden"},
      {"POINTS 5 float\n0 0 0 2 0 0 0 2 0 0 0 2 2 2 2\n", "the array 'points' comes twice"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    vtk_file file;
    begin(&file, false, 3);
    add(&file, bad[n].more);
    mesh_bad("a.vtk", file.data, bad[n].words);
  }

#define HEAD(version)                                                                              \
  "# vtk DataFile Version " version "\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n"      \
  "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\n"
  mesh_bad("a.vtk", HEAD("3.0") "CELLS 1 6\n4 0 1 2 3 4\nCELL_TYPES 1\n10\n",
           "CELLS has 1 numbers more than its cells");
  mesh_bad("a.vtk", HEAD("3.0") "CELLS 1 5\n4 0 1 2 3 4\nCELL_TYPES 1\n10\n",
           "a.vtk:8: unexpected '4' after the numbers of an array");
  mesh_bad("a.vtk", HEAD("3.0") "CELLS 1 5\n4 0 1.5 2 3\nCELL_TYPES 1\n10\n",
           "expected a whole number, found '1.5'");
  mesh_bad("a.vtk",
           HEAD("5.1") "CELLS 2 5\nOFFSETS vtktypeint64\n1 5\nCONNECTIVITY vtktypeint64\n"
                       "0 1 2 3 4\nCELL_TYPES 1\n10\n",
           "OFFSETS must begin with 0");
  mesh_bad("a.vtk",
           HEAD("5.1") "CELLS 2 5\nOFFSETS vtktypeint64\n0 4\nCONNECTIVITY vtktypeint64\n"
                       "0 1 2 3 4\nCELL_TYPES 1\n10\n",
           "the last cell ends at 4 of the connectivity, which has 5 numbers");
  mesh_bad("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n",
           "found 'DATASET POLYDATA'; save the body as an unstructured grid");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_section_is_read_and_passed),
      cmocka_unit_test(a_voxel_is_a_box),
      cmocka_unit_test(what_is_not_read_is_named),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
