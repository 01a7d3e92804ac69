/* Constructs of files by other programs that the formats leave open: assemblies, materials that
 * change, cell data of many names, compressed arrays, units. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>
#include <zlib.h>

#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_fix.h"
#include "mesh/mesh_flags.h"
#include "mesh/mesh_groups.h"
#include "platform/clock.h"

static int64_t group_count(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return mesh->groups[g].count;
  return 0;
}

/* Reads a file of the folder; returns its size, and *data is the caller's. */
static size_t read_bytes(const char *path, char **data) {
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  assert_int_equal(fseek(file, 0, SEEK_END), 0);
  const long size = ftell(file);
  rewind(file);
  *data = malloc((size_t)size + 1);
  assert_non_null(*data);
  assert_int_equal(fread(*data, 1, (size_t)size, file), (size_t)size);
  (*data)[size] = '\0';
  fclose(file);
  return (size_t)size;
}

/* --- Gmsh --------------------------------------------------------------------------------------
 */

static void binary_sections_may_end_without_a_line_of_their_own(void **state) {
  (void)state;
  thrum_mesh mesh = {0}, read = {0};
  thrum_error error = {0};
  thrum_mesh_lost lost;
  assert_int_equal(thrum_mesh_read("beam:2x1x1@1x.5x.5", 1, &mesh, NULL), THRUM_OK);
  const thrum_mesh_write_options options = {.binary = true, .msh_version = 22};
  char path[128];
  strcpy(path, mesh_write_text("a.msh", ""));
  assert_int_equal(thrum_mesh_write(path, &mesh, &options, &lost, NULL), THRUM_OK);

  // Gmsh ends data of elements and nodes so, here before and behind the elements
  static const char section[] =
      "$ElementData\n1\n\"view\"\n1\n0\n3\n0\n1\n2\n"
      "\1\0\0\0\0\0\n\0\0\0\0\1$En\2\0\0\0\0\0\0\0\0\0\0$$End$EndElementData\n";
  char *data, *whole;
  const size_t size = read_bytes(path, &data);
  whole = malloc(size + 2 * sizeof section);
  assert_non_null(whole);
  char *elements = data;
  while (memcmp(elements, "$Elements\n", 10) != 0)
    elements++;
  const size_t front = (size_t)(elements - data), length = sizeof section - 1;
  memcpy(whole, data, front);
  memcpy(whole + front, section, length);
  memcpy(whole + front + length, elements, size - front);
  memcpy(whole + size + length, section, length);

  if (thrum_mesh_read(mesh_write("a.msh", whole, size + 2 * length), 1, &read, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(thrum_mesh_hash(&read), thrum_mesh_hash(&mesh));
  thrum_mesh_free(&read);

  // a section that never ends is refused
  mesh_bad_bytes("a.msh", whole, size + 2 * length - 8, "the file ends before $EndElementData");
  free(whole);
  free(data);
  thrum_mesh_free(&mesh);
}

/* --- Abaqus ------------------------------------------------------------------------------------
 */

#define PART                                                                                       \
  "*Heading\n*Part, name=P\n*Node\n1,1,0,0\n2,2,0,0\n3,1,1,0\n4,1,0,1\n*Element, type=C3D4\n"      \
  "11,1,2,3,4\n*Nset, nset=foot\n1,3\n*Elset, elset=all\n11\n*Solid Section, elset=all, "          \
  "material=M\n,\n*End Part\n"
#define MATERIAL "*Material, name=M\n*Elastic\n2.1e5, 0.3\n*Density\n7.85e-9\n"
#define CLOSE_TO(a, b) assert_true(fabs((a) - (b)) < 1e-14)

static void an_instance_is_put_where_it_says(void **state) {
  (void)state;

  // moved by 10 along x, then turned by 90 degrees about the line through (10, 0, .) along z
  thrum_mesh mesh = mesh_good(
      "a.inp", PART
      "*Assembly, name=A\n*Instance, name=P-1, part=P\n10., 0., 0.\n"
      "10., 0., 0., 10., 0., 5., 90.\n*End Instance\n*Node\n1, 99, 99, 99\n*Nset, nset=ref\n1\n"
      "*Nset, nset=tip, instance=P-1\n2\n*Nset, nset=edge\nP-1.1, P-1.2\n*Nset, nset=both\n"
      "P-1.foot, P-1.4\n*Elset, elset=top, instance=P-1, generate\n11,11,1\n"
      "*End Assembly\n" MATERIAL);
  assert_int_equal(mesh.vertex_count, 4);
  static const double places[4][3] = {{10, 1, 0}, {10, 2, 0}, {9, 1, 0}, {10, 1, 1}};
  for (int i = 0; i < 12; i++)
    CLOSE_TO(mesh.vertices[i], places[i / 3][i % 3]);

  // sets of the part and of the assembly; the reference point is no part of the body
  assert_int_equal(group_count(&mesh, "foot"), 2);
  assert_int_equal(group_count(&mesh, "tip"), 1);
  assert_int_equal(group_count(&mesh, "edge"), 2);
  assert_int_equal(group_count(&mesh, "both"), 3);
  assert_int_equal(group_count(&mesh, "top"), 4);
  assert_int_equal(group_count(&mesh, "ref"), 0);
  assert_true(mesh.has_material && mesh.materials[0].young == 2.1e5);
  thrum_mesh_free(&mesh);

  // without lines it stays; with one it is moved, trailing zeros left out
  mesh = mesh_good("a.inp", PART "*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n"
                                 "*End Assembly\n" MATERIAL);
  CLOSE_TO(mesh.vertices[0], 1);
  thrum_mesh_free(&mesh);
  mesh = mesh_good("a.inp", PART "*Assembly, name=A\n*Instance, name=P-1, part=P\n0., -3.\n"
                                 "*End Instance\n*End Assembly\n" MATERIAL);
  CLOSE_TO(mesh.vertices[0], 1);
  CLOSE_TO(mesh.vertices[1], -3);
  thrum_mesh_free(&mesh);
}

static void several_instances_are_refused(void **state) {
  (void)state;

  // two instances of one part would be two bodies, and two parts number their nodes alike
  mesh_bad("a.inp",
           PART "*Assembly, name=A\n*Instance, name=P-1, part=P\n*End Instance\n"
                "*Instance, name=P-2, part=P\n5., 0., 0.\n*End Instance\n*End Assembly\n" MATERIAL,
           "a.inp:20: 'P-2' is a second instance beside 'P-1'");
  mesh_bad("a.inp", PART "*Part, name=Q\n*End Part\n", "a.inp:17: there are several parts");
  mesh_bad("a.inp",
           PART "*Assembly, name=A\n*Instance, name=P-1, part=P\n0.,0.,0.\n0,1,1,-0.,1,1,90\n"
                "*End Instance\n*End Assembly\n" MATERIAL,
           "turns about an axis between equal points");
  mesh_bad("a.inp",
           PART "*Assembly, name=A\n*Instance, name=P-1, part=P\n0.,0.,0.\n1,1,1,1,1,2\n"
                "*End Instance\n*End Assembly\n" MATERIAL,
           "a.inp:20: a rotation is two points of its axis and an angle");
}

static void properties_that_change_with_temperature_are_refused(void **state) {
  (void)state;
  mesh_bad("a.inp", PART "*Material, name=M\n*Elastic\n2e5, 0.3, 20\n1e5, 0.3, 500\n*Density\n1\n",
           "a.inp:20: *Elastic changes with temperature or a field");
  mesh_bad("a.inp", PART "*Material, name=M\n*Elastic\n2e5, 0.3\n*Density\n1, 20\n2, 50\n",
           "a.inp:22: *Density changes with temperature or a field");

  // a single temperature leaves nothing to choose
  thrum_mesh mesh = mesh_good("a.inp", PART "*Material, name=M\n*Elastic\n2e5, 0.3, 20\n*Density\n"
                                            "1, 20\n");
  assert_true(mesh.materials[0].young == 2e5);
  thrum_mesh_free(&mesh);
}

static void elements_of_networks_may_lack_an_end(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", PART MATERIAL "*Element, type=D, elset=pipe\n21,0,2,3\n");
  assert_int_equal(group_count(&mesh, "pipe"), 2);
  thrum_mesh_free(&mesh);
}

#define TEN_NODES                                                                                  \
  "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n8,0,0,.5\n"           \
  "9,.5,0,.5\n10,0,.5,.5\n*ELEMENT, TYPE=C3D10\n"

static void an_element_without_its_middle_nodes_is_named(void **state) {
  (void)state;

  // its numbers may go on below, so it takes those of the next one
  mesh_bad("a.inp", TEN_NODES "1,1,2,3,4,5,6,7\n2,1,2,3,4,5,6,7,8,9,10\n",
           "a.inp:14: element 1, which begins on line 13, has more than 10 nodes with this line");
  mesh_bad("a.inp", TEN_NODES "1,1,2,3,4,5,6,7\n", "element 1 has too few nodes: 7, not 10");
  mesh_bad("a.inp", TEN_NODES "1,1,2,3,4,5,6,7,8,9,10,11\n",
           "a.inp:13: unexpected '11' after the nodes");
}

static void hexahedra_of_incompatible_modes_may_name_inner_nodes(void **state) {
  (void)state;
  static const char cube[] = "*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n"
                             "7,1,1,1\n8,0,1,1\n9,0,0,0\n10,0,0,0\n11,0,0,0\n";
  char text[400];

  // without inner nodes, with them, and with them on an element that has none
  for (int inner = 0; inner < 3; inner++) {
    snprintf(text, sizeof text, "%s*ELEMENT, TYPE=%s\n1,1,2,3,4,5,6,7,8%s\n", cube,
             inner == 2 ? "C3D8" : "C3D8I", inner > 0 ? ",9,10,11," : "");
    if (inner == 2) {
      mesh_bad("a.inp", text, "unexpected '9' after the nodes");
      continue;
    }
    thrum_mesh mesh = mesh_good("a.inp", text);
    assert_int_equal(mesh.tet_count, 6);
    assert_int_equal(mesh.vertex_count, 8);
    thrum_mesh_free(&mesh);
  }
}

static void a_modified_tetrahedron_is_read_with_a_note(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "a.inp", "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,.5,0,0\n6,.5,.5,0\n7,0,.5,0\n"
               "8,0,0,.5\n9,.5,0,.5\n10,0,.5,.5\n*ELEMENT, TYPE=C3D10MH\n"
               "1,1,2,3,4,5,6,7,8,9,10\n");
  assert_int_equal(mesh.note_count, 1);
  assert_non_null(strstr(mesh.notes[0].text, "1 elements C3D10M were read as C3D10"));
  thrum_mesh_free(&mesh);
}

/* --- units -------------------------------------------------------------------------------------
 */

static void a_unit_turns_lengths_and_materials_into_those_of_si(void **state) {
  (void)state;
  static const struct {
    const char *unit;
    double length, young, density;
  } cases[] = {{NULL, 1, 2.1e5, 7.85e-9},         {"m-kg-s", 1, 2.1e5, 7.85e-9},
               {"mm-t-s", 0.001, 2.1e11, 7.85e3}, {"mm-kg-ms", 0.001, 2.1e14, 7.85},
               {"cm-g-s", 0.01, 2.1e4, 7.85e-6},  {"um-g-ms", 1e-6, 2.1e14, 7.85e6}};
  char path[128];
  strcpy(path, mesh_write_text("a.inp", PART MATERIAL));
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const thrum_mesh_read_options options = {.scale = 1, .unit = cases[i].unit};
    thrum_mesh mesh = {0};
    assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, NULL), THRUM_OK);
    assert_true(mesh.vertices[0] == cases[i].length);
    assert_true(fabs(mesh.materials[0].young / cases[i].young - 1) < 1e-15);
    assert_true(fabs(mesh.materials[0].density / cases[i].density - 1) < 1e-15);
    assert_true(mesh.materials[0].poisson == 0.3);

    // steel in tonnes by cubic millimetre is named for what it is
    char line[300];
    assert_int_equal(thrum_mesh_odd_density(&mesh), i == 2 || i == 3 ? -1 : 0);
    if (i == 0)
      assert_non_null(strstr(thrum_mesh_flag_line(&mesh, NULL, THRUM_EXAMINE_DENSITY, line),
                             "7.85e-09 kg/m^3, outside 0.5 to 30000; a file in millimetres, "
                             "tonnes and seconds needs --unit mm-t-s"));
    thrum_mesh_free(&mesh);
  }

  static const char *const bad[] = {"", "mm", "mm-t", "mm-t-s-", "in-lb-s", "mm-t-min", "-t-s"};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    const thrum_mesh_read_options options = {.scale = 1, .unit = bad[i]};
    thrum_error error = {0};
    thrum_mesh mesh = {0};
    assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, &error), THRUM_BAD_FORMAT);
    mesh_check_message(&error, "is no unit; write LENGTH-MASS-TIME");
  }
}

/* --- VTK ---------------------------------------------------------------------------------------
 */

#define VTK                                                                                        \
  "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"             \
  "0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\nCELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10\n10\n"        \
  "CELL_DATA 2\n"

static void cell_data_tells_regions_by_its_name(void **state) {
  (void)state;
  char path[128];
  strcpy(path,
         mesh_write_text("a.vtk", VTK "SCALARS mat_id int 1\nLOOKUP_TABLE default\n7\n3\n"
                                      "SCALARS part int 1\nLOOKUP_TABLE default\n0\n1\n"
                                      "SCALARS load double 1\nLOOKUP_TABLE default\n0.5\n1\n"));
  thrum_mesh mesh = {0};
  thrum_mesh_read_options options = {.scale = 1};
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.region_count, 2);
  assert_string_equal(thrum_mesh_region_text(&mesh, 0).text, "3");
  assert_string_equal(thrum_mesh_region_text(&mesh, 1).text, "7");
  assert_int_equal(mesh.note_count, 1);
  assert_string_equal(mesh.notes[0].text, "the 2 regions are those of the cell data 'mat_id'");
  thrum_mesh_free(&mesh);

  // by another name it is not taken unasked, but named
  strcpy(path, mesh_write_text("a.vtk", VTK "SCALARS part int 1\nLOOKUP_TABLE default\n0\n1\n"));
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.region_count, 1);
  assert_non_null(strstr(mesh.notes[0].text, "give --regions part"));
  thrum_mesh_free(&mesh);
  options.regions = "part";
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.region_count, 2);
  assert_int_equal(mesh.note_count, 0);
  thrum_mesh_free(&mesh);

  // what is not there, is no number of a region, or another format
  thrum_error error = {0};
  options.regions = "nothing";
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, &error), THRUM_MISSING);
  mesh_check_message(&error, "there is no cell data 'nothing' of one number a cell");
  options.regions = "load";
  strcpy(path,
         mesh_write_text("a.vtk", VTK "SCALARS load double 1\nLOOKUP_TABLE default\n0.5\n1\n"));
  assert_int_equal(thrum_mesh_read_with(path, &options, &mesh, &error), THRUM_BAD_VALUE);
  mesh_check_message(&error, "cell data 'load' is 0.5 in cell 0");
  assert_int_equal(thrum_mesh_read_with("beam.msh", &options, &mesh, &error), THRUM_UNSUPPORTED);
  mesh_check_message(&error, "regions by name are cell data of .vtk and .vtu files");
}

static size_t base64(const unsigned char *bytes, size_t size, char *text) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  size_t used = 0;
  for (size_t i = 0; i < size; i += 3) {
    const unsigned a = bytes[i], b = i + 1 < size ? bytes[i + 1] : 0,
                   c = i + 2 < size ? bytes[i + 2] : 0;
    text[used++] = digits[a >> 2];
    text[used++] = digits[(a << 4 | b >> 4) & 63];
    text[used++] = i + 1 < size ? digits[(b << 2 | c >> 6) & 63] : '=';
    text[used++] = i + 2 < size ? digits[c & 63] : '=';
  }
  return used;
}

/* Compresses an array in blocks of `block` bytes, with a header of words of `word` bytes in front,
 * both in base64 where `text`; returns the size. */
static size_t compress_array(const void *array, size_t size, size_t block, size_t word, bool text,
                             char *out) {
  unsigned char header[400] = {0}, packed[2000];
  const size_t blocks = (size + block - 1) / block;
  size_t used = 0;
  const size_t words[3] = {blocks, block, size % block};
  for (size_t i = 0; i < 3; i++)
    header[i * word] = (unsigned char)words[i];
  header[word + 1] = (unsigned char)(block >> 8);
  for (size_t n = 0; n < blocks; n++) {
    const size_t length = n + 1 < blocks || size % block == 0 ? block : size % block;
    uLongf room = (uLongf)(sizeof packed - used);
    assert_int_equal(
        compress(packed + used, &room, (const unsigned char *)array + n * block, (uLong)length),
        Z_OK);
    header[(3 + n) * word] = (unsigned char)room;
    used += (size_t)room;
    assert_true(room < 256);
  }

  const size_t front = (3 + blocks) * word;
  if (text) {
    const size_t length = base64(header, front, out);
    return length + base64(packed, used, out + length);
  }
  memcpy(out, header, front);
  memcpy(out + front, packed, used);
  return front + used;
}

/* A file of one tet with compressed arrays, appended raw or inline in base64. */
static size_t make_compressed(char *file, size_t block, size_t word, bool raw) {
  static const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  static const int32_t cells[4] = {0, 1, 2, 3}, ends[1] = {4};
  static const unsigned char types[1] = {10};
  static const struct {
    const char *open, *type, *name, *close;
    const void *values;
    size_t size;
  } arrays[] = {{"<Points>", "Float64", "Points", "</Points>", points, sizeof points},
                {"<Cells>", "Int32", "connectivity", "", cells, sizeof cells},
                {"", "Int32", "offsets", "", ends, sizeof ends},
                {"", "UInt8", "types", "</Cells>", types, sizeof types}};
  char appended[4000], packed[4000];
  size_t used = 0, offset = 0;

  // the arrays in the file, or behind it
  used += (size_t)sprintf(file,
                          "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                          "byte_order=\"LittleEndian\" header_type=\"UInt%zu\" "
                          "compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid>"
                          "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\">",
                          8 * word);
  for (int i = 0; i < 4; i++) {
    const size_t size = compress_array(arrays[i].values, arrays[i].size, block, word, !raw, packed);
    used += (size_t)sprintf(file + used, "%s<DataArray type=\"%s\" Name=\"%s\" ", arrays[i].open,
                            arrays[i].type, arrays[i].name);
    if (raw)
      used += (size_t)sprintf(file + used, "format=\"appended\" offset=\"%zu\"/>", offset);
    else
      used +=
          (size_t)sprintf(file + used, "format=\"binary\">\n%.*s\n</DataArray>", (int)size, packed);
    used += (size_t)sprintf(file + used, "%s", arrays[i].close);
    memcpy(appended + offset, packed, size);
    offset += size;
  }
  used += (size_t)sprintf(file + used, "</Piece></UnstructuredGrid>");
  if (raw) {
    used += (size_t)sprintf(file + used, "<AppendedData encoding=\"raw\">_");
    memcpy(file + used, appended, offset);
    used += offset;
    used += (size_t)sprintf(file + used, "</AppendedData>");
  }
  return used + (size_t)sprintf(file + used, "</VTKFile>\n");
}

static void compressed_vtu_files_are_read(void **state) {
  (void)state;
  static const size_t blocks[] = {32768, 96, 40, 7};
  char file[12000];
  for (int n = 0; n < 16; n++) {
    const size_t size = make_compressed(file, blocks[n / 4], n & 1 ? 4 : 8, n & 2);
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(mesh_write("a.vtu", file, size), 1, &mesh, &error) < 0)
      fail_msg("%d: %s", n, error.message);
    assert_int_equal(mesh.vertex_count, 4);
    assert_true(fabs(thrum_mesh_tet_volume(&mesh, 0) - 1.0 / 6) < 1e-15);
    thrum_mesh_free(&mesh);

    // damage is refused or read, and never reads beyond the file
    for (size_t at = 0; at < size && n >= 8; at++) {
      const char kept = file[at];
      file[at] = (char)(kept ^ 0x55);
      const thrum_mesh_source source = {"a.vtu", file, at % 2 ? size : at, NULL, false, false};
      if (thrum_mesh_parse_vtu(&source, &mesh, NULL) >= 0)
        thrum_mesh_free(&mesh);
      file[at] = kept;
    }
  }
  mesh_bad("a.vtu",
           "<VTKFile type=\"UnstructuredGrid\" compressor=\"vtkLZ4DataCompressor\"></VTKFile>",
           "a.vtu:1: is compressed in a way that is not read; save it with Compressor Type ZLib");
}

/* A file of one tet in which one array, appended raw, is one block of `size` zeros. */
static size_t make_swollen(char *file, size_t room, const char *array, size_t size,
                           int64_t points) {
  char *zeros = calloc(size, 1);
  assert_non_null(zeros);
  size_t used = (size_t)sprintf(
      file,
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt32\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid><Piece "
      "NumberOfPoints=\"%lld\" NumberOfCells=\"1\">%s</Piece></UnstructuredGrid><AppendedData "
      "encoding=\"raw\">_",
      (long long)points, array);
  uLongf packed = (uLongf)(room - used - 16);
  assert_int_equal(compress((Bytef *)file + used + 16, &packed, (const Bytef *)zeros, (uLong)size),
                   Z_OK);
  const uint32_t header[4] = {1, (uint32_t)size, 0, (uint32_t)packed};
  memcpy(file + used, header, sizeof header);
  free(zeros);
  return used + 16 + (size_t)packed;
}

#define APPENDED "format=\"appended\" offset=\"0\"/>"

/* No array is blown up beyond what its points and cells need. */
static void a_compressed_array_is_no_larger_than_its_points_need(void **state) {
  (void)state;
  enum { SIZE = 1 << 26, ROOM = 1 << 18 };
  static const char *const arrays[] = {
      "<Points><DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" " APPENDED
      "</Points>",
      "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" " APPENDED "</Cells>",
      "<Cells><DataArray type=\"Int64\" Name=\"offsets\" " APPENDED "</Cells>",
      "<Cells><DataArray type=\"UInt8\" Name=\"types\" " APPENDED "</Cells>",
      "<PointData><DataArray type=\"Int8\" Name=\"a\" " APPENDED "</PointData>",
      "<CellData><DataArray type=\"Float32\" Name=\"b\" " APPENDED "</CellData>"};
  char *file = malloc(ROOM);
  assert_non_null(file);
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++) {
    const size_t size = make_swollen(file, ROOM, arrays[n], SIZE, 4);
    const thrum_mesh_source source = {"a.vtu", file, size, NULL, false, false};
    const double before = clock_peak_mb();
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    assert_int_equal(thrum_mesh_parse_vtu(&source, &mesh, &error), THRUM_BAD_FORMAT);
    mesh_check_message(&error, "has 67108864 bytes, more than 4 points and 1 cells need");
    assert_true(clock_peak_mb() - before < 16);
  }

  // data of more columns than a tensor, however many, is not blown up at all
  static const char vectors[] = "<PointData><DataArray type=\"Float64\" Name=\"v\" "
                                "NumberOfComponents=\"1000000\" " APPENDED "</PointData>";
  const size_t wide = make_swollen(file, ROOM, vectors, SIZE, 100);
  const thrum_mesh_source wide_source = {"a.vtu", file, wide, NULL, false, false};
  const double before = clock_peak_mb();
  thrum_mesh none = {0};
  assert_int_equal(thrum_mesh_parse_vtu(&wide_source, &none, NULL), THRUM_MISSING);
  assert_true(clock_peak_mb() - before < 16);

  // nor do points count that the file has no room to name
  const size_t size = make_swollen(file, ROOM, arrays[0], SIZE, SIZE / 24);
  const thrum_mesh_source source = {"a.vtu", file, size, NULL, false, false};
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_mesh_parse_vtu(&source, &mesh, &error), THRUM_BAD_FORMAT);
  mesh_check_message(&error, "names more points or cells than a file of its size can hold");
  free(file);
}

/* --- lists and beams ---------------------------------------------------------------------------
 */

static void an_empty_list_holds_nothing(void **state) {
  (void)state;
  static const char *const texts[] = {"", "\n\n", "# free\n"};
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read("beam:1x1x1@1x1x1", 1, &mesh, NULL), THRUM_OK);
  for (int n = 0; n < 3; n++) {
    uint8_t fixed[8] = {0};
    int64_t count = -1;
    assert_int_equal(thrum_mesh_fix(&mesh, mesh_write_text("a.bou", texts[n]), fixed, &count, NULL),
                     THRUM_OK);
    assert_int_equal(count, 0);
  }
  thrum_mesh_free(&mesh);
}

static void cells_of_a_beam_may_be_cut_in_three_ways(void **state) {
  (void)state;
  static const struct {
    const char *beam;
    int tets;
  } cases[] = {{"beam:4x3x2@1x.3x.2,split=5", 5},
               {"beam:4x3x2@1x.3x.2,split=6", 6},
               {"beam:4x3x2@1x.3x.2", 6}};
  thrum_mesh mesh = {0};
  uint64_t hashes[3];
  for (int n = 0; n < 3; n++) {
    thrum_mesh_examined examined;
    assert_int_equal(thrum_mesh_read(cases[n].beam, 1, &mesh, NULL), THRUM_OK);
    assert_int_equal(thrum_mesh_examine(&mesh, &examined, NULL), THRUM_OK);
    hashes[n] = thrum_mesh_hash(&mesh);

    // neighbours fit, nothing was wound the other way, and nothing is lost
    assert_int_equal(mesh.tet_count, cases[n].tets * 24);
    assert_int_equal(mesh.flipped_tets, 0);
    assert_int_equal(examined.surface_triangles, 2 * 2 * (12 + 8 + 6));
    assert_int_equal(examined.genus, 0);
    assert_true(fabs(examined.volume - 0.06) < 1e-15);
    thrum_mesh_free(&mesh);
  }
  assert_true(hashes[1] != hashes[2]);

  // regions along the beam, of cells as they are cut
  assert_int_equal(thrum_mesh_read("beam:5x2x1@1x.3x.2,hex,parts=2", 1, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.region_count, 2);
  assert_string_equal(mesh.region_names[1], "part2");
  for (int64_t t = 0; t < mesh.tet_count; t++)
    assert_int_equal(mesh.tet_region[t], t < 3 * 12 ? 0 : 1);
  thrum_mesh_free(&mesh);

  static const char *const bad[] = {"beam:1x1x1@1x1x1,split=4",  "beam:1x1x1@1x1x1,",
                                    "beam:1x1x1@1x1x1,split=55", "beam:1x1x1@1x1x1x",
                                    "beam:1x1x1@1x1x1,parts=0",  "beam:1x1x1@1x1x1,parts=2",
                                    "beam:2x1x1@1x1x1,parts=2x"};
  for (int n = 0; n < 7; n++)
    assert_int_equal(thrum_mesh_read(bad[n], 1, &mesh, NULL), THRUM_BAD_FORMAT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // binary Gmsh, Abaqus, units, VTK, supports and beams
      cmocka_unit_test(binary_sections_may_end_without_a_line_of_their_own),
      cmocka_unit_test(an_instance_is_put_where_it_says),
      cmocka_unit_test(several_instances_are_refused),
      cmocka_unit_test(properties_that_change_with_temperature_are_refused),
      cmocka_unit_test(elements_of_networks_may_lack_an_end),
      cmocka_unit_test(an_element_without_its_middle_nodes_is_named),
      cmocka_unit_test(hexahedra_of_incompatible_modes_may_name_inner_nodes),
      cmocka_unit_test(a_modified_tetrahedron_is_read_with_a_note),
      cmocka_unit_test(a_unit_turns_lengths_and_materials_into_those_of_si),
      cmocka_unit_test(cell_data_tells_regions_by_its_name),
      cmocka_unit_test(compressed_vtu_files_are_read),
      cmocka_unit_test(a_compressed_array_is_no_larger_than_its_points_need),
      cmocka_unit_test(an_empty_list_holds_nothing),
      cmocka_unit_test(cells_of_a_beam_may_be_cut_in_three_ways),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
