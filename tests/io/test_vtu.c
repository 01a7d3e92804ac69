/* Frames for ParaView: an independent reader of the VTK XML format, written here from its
 * description, recovers the mesh and the displacements. SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/file.h"
#include "io/npy_file.h"
#include "tests/support/base64_decode.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#include "io/vtu.h"

#define MANY_TETS 9001 /* more than two pieces of generated values, and no multiple */

/* A .vtu file in memory. */
typedef struct vtu {
  char *bytes;
  size_t size;
  unsigned char *array; /* the array that was decoded last */
} vtu;

static vtu read_vtu(const char *path) {
  vtu file = {0};
  void *bytes = NULL;
  assert_int_equal(thrum_file_read(path, &bytes, &file.size, NULL), 0);
  file.bytes = bytes;
  assert_non_null(strstr(file.bytes, "\n</VTKFile>\n"));
  return file;
}

static void free_vtu(vtu *file) {
  free(file->array);
  free(file->bytes);
}

/* The value of an attribute of the tag at `tag`, as text. */
static void attribute(const char *tag, const char *name, char value[64]) {
  char key[64];
  snprintf(key, sizeof key, " %s=\"", name);
  const char *end = strchr(tag, '>'), *at = strstr(tag, key);
  assert_true(at != NULL && end != NULL && at < end);
  at += strlen(key);
  const size_t length = strcspn(at, "\"");
  assert_true(length < 64);
  memcpy(value, at, length);
  value[length] = 0;
}

/* Characters of the base64 text of that many bytes. */
static uint64_t text_length(uint64_t bytes) {
  return (bytes + 2) / 3 * 4;
}

/* The data of the array called `name`, which must have the given type, components and bytes. */
static const void *array_data(vtu *file, const char *name, const char *type, int components,
                              uint64_t bytes) {
  char key[80], value[64];
  snprintf(key, sizeof key, "Name=\"%s\"", name);
  const char *at = strstr(file->bytes, key);
  assert_non_null(at);
  while (*at != '<')
    at--;

  // the attributes of its tag
  attribute(at, "type", value);
  assert_string_equal(value, type);
  attribute(at, "NumberOfComponents", value);
  assert_int_equal(atoi(value), components);
  attribute(at, "format", value);
  assert_string_equal(value, "binary");

  // the text of the array fills its element and begins with its size
  const char *text = strchr(at, '>') + 2;
  const uint64_t length = text_length(sizeof bytes + bytes);
  uint64_t size = 0;
  assert_memory_equal(strchr(text, '<'), "</DataArray>", 12);
  assert_true(strcspn(text, "\n") == length);
  free(file->array);
  file->array = malloc(length);
  assert_non_null(file->array);
  assert_true(base64_decode(text, length, file->array) == sizeof size + bytes);
  memcpy(&size, file->array, sizeof size);
  assert_true(size == bytes);
  return file->array + sizeof size;
}

/* A chain of tetrahedra, long enough for every loop of the writer to repeat. */
static thrum_model make_chain(double *vertices, int32_t *tets, int32_t *region, uint8_t *fixed,
                              int64_t tet_count) {
  for (int64_t n = 0; n < 3 * (tet_count + 3); n++)
    vertices[n] = 0.25 * (double)n + 1e-9;
  for (int64_t t = 0; t < tet_count; t++) {
    region[t] = (int32_t)(t % 3);
    for (int n = 0; n < 4; n++)
      tets[4 * t + n] = (int32_t)(t + n);
  }

  // all kinds of fixing
  for (int64_t v = 0; v < tet_count + 3; v++)
    fixed[v] = (uint8_t)(v % 8);
  return (thrum_model){.vertex_count = tet_count + 3,
                       .tet_count = tet_count,
                       .vertices = vertices,
                       .tets = tets,
                       .tet_region = region,
                       .fixed = fixed};
}

static void check_frame(int64_t tet_count) {
  static double vertices[3 * (MANY_TETS + 3)], displacement[3 * (MANY_TETS + 3)];
  static int32_t tets[4 * MANY_TETS], region[MANY_TETS];
  static uint8_t fixed[MANY_TETS + 3];
  char value[64];

  // a frame with a known displacement
  const thrum_model model = make_chain(vertices, tets, region, fixed, tet_count);
  const uint64_t points = (uint64_t)model.vertex_count, cells = (uint64_t)tet_count;
  for (uint64_t n = 0; n < 3 * points; n++)
    displacement[n] = sin((double)n);
  assert_int_equal(vtu_write(in_folder("frame.vtu"), &model, displacement, NULL, 0.1, NULL), 0);

  // the header gives the counts and the width of sizes
  vtu file = read_vtu(in_folder("frame.vtu"));
  const char *piece = strstr(file.bytes, "<Piece");
  attribute(piece, "NumberOfPoints", value);
  assert_true(strtoull(value, NULL, 10) == points);
  attribute(piece, "NumberOfCells", value);
  assert_true(strtoull(value, NULL, 10) == cells);
  attribute(strstr(file.bytes, "<VTKFile"), "header_type", value);
  assert_string_equal(value, "UInt64");

  // the arrays return to the bit
  assert_memory_equal(array_data(&file, "Points", "Float64", 3, 24 * points), vertices,
                      24 * points);
  assert_memory_equal(array_data(&file, "displacement", "Float64", 3, 24 * points), displacement,
                      24 * points);
  assert_memory_equal(array_data(&file, "connectivity", "Int32", 1, 16 * cells), tets, 16 * cells);
  assert_memory_equal(array_data(&file, "fixed", "UInt8", 1, points), fixed, points);
  assert_memory_equal(array_data(&file, "region", "Int32", 1, 4 * cells), region, 4 * cells);

  // every cell is a tetrahedron of four points
  const char *ends = array_data(&file, "offsets", "Int64", 1, 8 * cells);
  for (uint64_t t = 0; t < cells; t++) {
    int64_t end = 0;
    memcpy(&end, ends + 8 * t, sizeof end);
    assert_true(end == 4 * (int64_t)(t + 1));
  }
  const unsigned char *types = array_data(&file, "types", "UInt8", 1, cells);
  for (uint64_t t = 0; t < cells; t++)
    assert_int_equal(types[t], 10); // VTK_TETRA

  assert_true(strtod(strchr(strstr(file.bytes, "TimeValue"), '>') + 1, NULL) == 0.1);

  free_vtu(&file);
}

static void a_frame_holds_the_mesh_and_the_displacement(void **state) {
  (void)state;
  check_frame(1);
  check_frame(4096);
  check_frame(MANY_TETS);
}

static void a_frame_holds_the_stress_when_there_is_one(void **state) {
  (void)state;
  enum { TETS = 37 };
  static double vertices[3 * (TETS + 3)], displacement[3 * (TETS + 3)], centres[TETS];
  static double nodes[TETS + 3];
  static int32_t tets[4 * TETS], region[TETS];
  static uint8_t fixed[TETS + 3];

  // a frame with a known stress of each tetrahedron and each vertex
  const thrum_model model = make_chain(vertices, tets, region, fixed, TETS);
  for (int n = 0; n < TETS; n++)
    centres[n] = n * 1e5;
  for (int n = 0; n < TETS + 3; n++)
    nodes[n] = n * 2e5;
  for (int patches = 0; patches < 2; patches++) {
    const char *name = patches ? "von_mises_patch_average" : "von_mises";
    const vtu_stress stress = {nodes, centres, patches == 1};
    assert_int_equal(vtu_write(in_folder("stress.vtu"), &model, displacement, &stress, 0.1, NULL),
                     0);
    vtu file = read_vtu(in_folder("stress.vtu"));
    assert_memory_equal(array_data(&file, "von_mises_centre", "Float64", 1, 8 * TETS), centres,
                        8 * TETS);
    assert_memory_equal(array_data(&file, name, "Float64", 1, 8 * (TETS + 3)), nodes,
                        8 * (TETS + 3));

    // each is among the arrays of its kind
    char quoted[40];
    snprintf(quoted, sizeof quoted, "\"%s\"", name);
    assert_true(strstr(file.bytes, "<CellData>") < strstr(file.bytes, "von_mises_centre"));
    assert_true(strstr(file.bytes, quoted) < strstr(file.bytes, "</PointData>"));
    free_vtu(&file);
  }
}

static void a_frame_without_a_mesh_is_refused(void **state) {
  (void)state;
  thrum_error error = {0};
  const thrum_model model = {.rank = 1};
  assert_int_equal(vtu_write(in_folder("none.vtu"), &model, NULL, NULL, 0, &error), THRUM_MISSING);
  assert_true(error.message[0] != 0);
  assert_false(file_exists(in_folder("none.vtu")));
}

static void a_frame_that_cannot_be_written_is_an_error(void **state) {
  (void)state;
  static double vertices[12], displacement[12];
  static int32_t tets[4], region[1];
  static uint8_t fixed[4];
  const thrum_model model = make_chain(vertices, tets, region, fixed, 1);
  assert_int_equal(vtu_write("/nonexistent/frame.vtu", &model, displacement, NULL, 0, NULL),
                   THRUM_IO);
  assert_int_equal(vtu_write("/dev/full", &model, displacement, NULL, 0, NULL), THRUM_IO);
}

/* Runs the particle with frames, checks each, and returns how many the .pvd file lists. */
static int64_t run_frames(const char *frames, double stride) {
  // a run whose coordinates are recorded at every step
  char name[100], value[64];
  program_result run =
      thrum_run(folder, "simulate", "particle.npz", "-o", "run", "--time", "0.3", "--dt", "0.003",
                "--load", "constant:0,0,1@tip", "--frames", frames, "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);

  // read the coordinates of the run, and the list of its frames
  double *q = NULL;
  int64_t rows = 0, columns = 0, count = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder("run/q.npy"), &q, &rows, &columns, NULL), 0);
  char *pvd = text_file_read(in_folder("run/frames.pvd"));
  assert_non_null(pvd);

  // each frame is taken at the step that its stride asks for
  for (const char *at = strstr(pvd, "<DataSet"); at != NULL; at = strstr(at + 1, "<DataSet")) {
    attribute(at, "timestep", value);
    const double time = strtod(value, NULL);
    const int64_t step = (int64_t)floor((double)count * stride + 0.5);
    assert_true(fabs(time - 0.003 * (double)step) < 1e-12 && step < rows);
    attribute(at, "file", value);
    snprintf(name, sizeof name, "run/%s", value);

    // and holds the displacement U q of that step
    vtu file = read_vtu(in_folder(name));
    const char *data = array_data(&file, "displacement", "Float64", 3, 96);
    for (int n = 0; n < 12; n++) {
      double u = 0;
      memcpy(&u, data + 8 * n, sizeof u);
      const double expected =
          particle_basis[2 * n] * q[2 * step] + particle_basis[2 * n + 1] * q[2 * step + 1];
      assert_true(fabs(u - expected) <= 1e-15);
    }
    free_vtu(&file);
    count++;
  }

  assert_true(json_value(object, "frames") == (double)count);

  cJSON_Delete(object);
  program_result_free(&run);
  free(pvd);
  free(q);
  return count;
}

static void a_run_lists_its_frames_with_their_times(void **state) {
  (void)state;
  assert_true(save_particle(in_folder("particle.npz"), 0, 0));
  // 100 steps give the frames 0, 10, ..., 100; 1000 per second is more than one per step
  assert_int_equal(run_frames("every-10", 10), 11);
  assert_int_equal(run_frames("1000", 1), 101);
  assert_true(file_exists(in_folder("run/frames/frame_000100.vtu")));
  assert_int_equal(run_frames("30", 1 / (30 * 0.003)), 10);
  // frames of the earlier run that this one does not have
  assert_false(file_exists(in_folder("run/frames/frame_000100.vtu")));
  assert_false(file_exists(in_folder("run/frames/frame_000010.vtu")));
  assert_true(file_exists(in_folder("run/frames/frame_000009.vtu")));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_frame_holds_the_mesh_and_the_displacement),
      cmocka_unit_test(a_frame_holds_the_stress_when_there_is_one),
      cmocka_unit_test(a_frame_without_a_mesh_is_refused),
      cmocka_unit_test(a_frame_that_cannot_be_written_is_an_error),
      cmocka_unit_test(a_run_lists_its_frames_with_their_times),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
