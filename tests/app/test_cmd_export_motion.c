/* Runs are exported as glTF, vertex caches and .obj: each holds X + U q of the run's own q, in
 * single precision; the surface is closed and has the body's volume.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <unistd.h>

#include <cmocka.h>
#include <math.h>

#include "io/file.h"
#include "io/npy_file.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

static const thrum_model *model;
static double *q;
static int64_t rows, rank;

static int make_run(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !precompute_beam("6x2x2@1x0.2x0.3", "4", "7"))
    return -1;

  // fewer coordinates than the model has
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "run", "--time", "0.2", "-q",
                                 "--start", "mode:1,0.1", "--rank", "5", "--judge", "off", NULL);
  int code = run.exit_code;
  program_result_free(&run);

  // every row in each of the four formats
  run = thrum_run(folder, "export", "run", "--glb", "run.glb", "--pc2", "run.pc2", "--mdd",
                  "run.mdd", "--obj", "run.obj", "--fps", "0", NULL);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  code += run.exit_code;
  program_result_free(&run);

  // the tests compare with the model and the coordinates of the run
  if (code == 0 && thrum_model_load(in_folder("beam.npz"), &model, NULL) < 0)
    return -1;
  if (code == 0 && thrum_npy_read_f8(in_folder("run/q.npy"), &q, &rows, &rank, NULL) < 0)
    return -1;
  return code;
}

static int remove_run(void **state) {
  (void)state;
  thrum_model_destroy(model);
  free(q);
  test_folder_remove(folder);
  return 0;
}

static unsigned char *read_bytes(const char *name, size_t *size) {
  void *data = NULL;
  assert_true(thrum_file_read(in_folder(name), &data, size, NULL) >= 0);
  return data;
}

/* Finds the vertex of the model that lies at x. */
static int64_t find_vertex(const double x[3]) {
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *at = model->vertices + 3 * v;
    if (fabs(at[0] - x[0]) + fabs(at[1] - x[1]) + fabs(at[2] - x[2]) < 1e-6)
      return v;
  }
  fail_msg("no vertex at %g %g %g", x[0], x[1], x[2]);
  return -1;
}

/* Computes a component of X + U q. */
static double position(int64_t vertex, int axis, int64_t row) {
  double sum = model->vertices[3 * vertex + axis];
  for (int64_t n = 0; n < rank; n++)
    sum += model->basis[(3 * vertex + axis) * model->rank + n] * q[row * rank + n];
  return sum;
}

typedef struct glb_file {
  unsigned char *bytes;
  cJSON *json;
  const unsigned char *buffer;
} glb_file;

static glb_file open_glb(const char *name) {
  size_t size = 0;
  glb_file file = {.bytes = read_bytes(name, &size)};
  uint32_t head[5], chunk[2];

  // the header: magic number, version 2 and the length of the file
  memcpy(head, file.bytes, sizeof head);
  assert_memory_equal(file.bytes, "glTF", 4);
  assert_int_equal(head[1], 2);
  assert_int_equal(head[2], size);

  // the first chunk is JSON, the second is binary and ends the file
  assert_memory_equal(file.bytes + 16, "JSON", 4);
  file.json = cJSON_ParseWithLength((const char *)file.bytes + 20, head[3]);
  assert_non_null(file.json);
  memcpy(chunk, file.bytes + 20 + head[3], sizeof chunk);
  assert_memory_equal(file.bytes + 24 + head[3], "BIN", 4);
  assert_int_equal(28 + head[3] + chunk[0], size);
  file.buffer = file.bytes + 28 + head[3];
  return file;
}

static void close_glb(glb_file *file) {
  cJSON_Delete(file->json);
  free(file->bytes);
}

static double number_in(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItem(object, key);
  assert_true(cJSON_IsNumber(item));
  return item->valuedouble;
}

/* Finds an accessor's numbers, and how many elements it has. */
static const void *accessor(const glb_file *file, int index, int64_t *count) {
  const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItem(file->json, "accessors"), index);
  const cJSON *view = cJSON_GetArrayItem(cJSON_GetObjectItem(file->json, "bufferViews"),
                                         (int)number_in(item, "bufferView"));
  *count = (int64_t)number_in(item, "count");
  return file->buffer + (size_t)number_in(view, "byteOffset");
}

static void a_glb_holds_the_motion_of_the_run(void **state) {
  (void)state;
  glb_file file = open_glb("run.glb");
  int64_t vertices = 0, times = 0, weights = 0, count = 0;

  // the accessors: vertices at rest, a morph target per coordinate, triangles, times, weights
  const float *rest = accessor(&file, 0, &vertices);
  const float *time = accessor(&file, (int)rank + 2, &times);
  const float *weight = accessor(&file, (int)rank + 3, &weights);

  assert_int_equal(times, rows);
  assert_int_equal(weights, rows * rank);

  // rest plus weighted targets must be the place of the same vertex of the model
  double worst = 0, moved = 0;
  for (int64_t v = 0; v < vertices; v++) {
    const double x[3] = {(double)rest[3 * v], (double)rest[3 * v + 1], (double)rest[3 * v + 2]};
    const int64_t vertex = find_vertex(x);
    for (int64_t row = 0; row < rows; row += 7) {
      for (int axis = 0; axis < 3; axis++) {
        double sum = x[axis];
        for (int64_t n = 0; n < rank; n++) {
          const float *target = accessor(&file, (int)n + 1, &count);
          assert_true(fabsf(weight[row * rank + n]) <= 1);
          sum += (double)weight[row * rank + n] * (double)target[3 * v + axis];
        }
        worst = fmax(worst, fabs(sum - position(vertex, axis, row)));
        moved = fmax(moved, fabs(sum - x[axis]));
      }
    }
  }

  assert_true(moved > 0.05);

  // a few units of single precision at 1 m
  assert_true(worst < 3e-7);
  assert_true(time[0] == 0 && fabs((double)time[rows - 1] - 0.201) < 1e-6);
  close_glb(&file);
}

/* The flux of x / 3 through the triangles is the volume, if they close and look outwards. */
static void the_surface_is_closed_and_looks_outwards(void **state) {
  (void)state;
  glb_file file = open_glb("run.glb");
  int64_t vertices = 0, corners = 0;
  const float *x = accessor(&file, 0, &vertices);
  const uint32_t *corner = accessor(&file, (int)rank + 1, &corners);

  double volume = 0;
  for (int64_t t = 0; t < corners; t += 3) {
    const float *a = x + 3 * corner[t], *b = x + 3 * corner[t + 1], *c = x + 3 * corner[t + 2];
    volume += (double)(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0])) /
              6;
  }
  assert_true(fabs(volume - 0.06) < 1e-6);

  // 2 triangles on each of the 2 (6 2 + 6 2 + 2 2) outer faces of cells
  assert_int_equal(corners / 3, 2 * 2 * (12 + 12 + 4));

  // vertices are split at the edges of the block, where its normals jump
  int64_t places = 0;
  for (int64_t v = 0; v < vertices; v++) {
    bool known = false;
    for (int64_t other = 0; other < v && !known; other++)
      known = memcmp(x + 3 * v, x + 3 * other, 3 * sizeof *x) == 0;
    places += !known;
  }
  assert_int_equal(vertices, 2 * (7 * 3 + 7 * 3 + 3 * 3));

  // Euler's formula: one closed surface without holes
  assert_int_equal(places, 2 + corners / 6);
  close_glb(&file);
}

/* The area-weighted normal of a split vertex, of unit length, at positions x. */
static void normal_of(const float *x, const uint32_t *corner, int64_t corners, int64_t vertex,
                      double normal[3]) {
  double sum[3] = {0};
  for (int64_t t = 0; t < corners; t += 3) {
    if (corner[t] != vertex && corner[t + 1] != vertex && corner[t + 2] != vertex)
      continue;
    double side[2][3];
    for (int axis = 0; axis < 3; axis++)
      for (int n = 0; n < 2; n++)
        side[n][axis] = (double)x[3 * corner[t + n + 1] + axis] - (double)x[3 * corner[t] + axis];
    for (int axis = 0; axis < 3; axis++) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      sum[axis] += side[0][a] * side[1][b] - side[0][b] * side[1][a];
    }
  }
  const double length = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  for (int axis = 0; axis < 3; axis++)
    normal[axis] = sum[axis] / length;
}

static void normals_follow_the_surface(void **state) {
  (void)state;
  glb_file file = open_glb("run.glb");
  int64_t vertices = 0, corners = 0, count = 0;
  const int first = (int)rank + 4;
  const float *rest = accessor(&file, 0, &vertices);
  const uint32_t *corner = accessor(&file, (int)rank + 1, &corners);
  const float *normals = accessor(&file, first, &count);
  assert_int_equal(count, vertices);

  // a sixteenth of every target at once: all bend the surface, and little enough to be linear
  const double weight = 1.0 / 16;
  float *x = calloc((size_t)vertices * 3, sizeof *x), *n = calloc((size_t)vertices * 3, sizeof *n);
  assert_true(x != NULL && n != NULL);
  for (int64_t i = 0; i < 3 * vertices; i++) {
    x[i] = rest[i];
    n[i] = normals[i];
    for (int column = 0; column < rank; column++) {
      x[i] += (float)weight * ((const float *)accessor(&file, column + 1, &count))[i];
      n[i] += (float)weight * ((const float *)accessor(&file, first + column + 1, &count))[i];
    }
  }

  // what a player makes of it is the normal of the surface where it is now, and not that at rest
  double worst = 0, turned = 0;
  for (int64_t v = 0; v < vertices; v++) {
    double still[3], moved[3], length = 0;
    normal_of(rest, corner, corners, v, still);
    normal_of(x, corner, corners, v, moved);
    for (int axis = 0; axis < 3; axis++)
      length = hypot(length, (double)n[3 * v + axis]);
    for (int axis = 0; axis < 3; axis++) {
      assert_true(fabs((double)normals[3 * v + axis] - still[axis]) < 1e-6);
      worst = fmax(worst, fabs((double)n[3 * v + axis] / length - moved[axis]));
      turned = fmax(turned, fabs(moved[axis] - still[axis]));
    }
  }
  assert_true(turned > 5e-3);
  assert_true(worst < turned / 50);
  free(x);
  free(n);
  close_glb(&file);
}

static float float_at(const unsigned char *bytes, bool swapped) {
  unsigned char order[4];
  for (int n = 0; n < 4; n++)
    order[n] = bytes[swapped ? 3 - n : n];
  float value;
  memcpy(&value, order, 4);
  return value;
}

/* Reads the vertices of run.obj as their places in the model. */
static int64_t read_obj(int64_t *places) {
  char *text = text_file_read(in_folder("run.obj"));
  assert_non_null(text);
  int64_t count = 0;
  for (char *line = strtok(text, "\n"); line != NULL; line = strtok(NULL, "\n")) {
    double x[3];
    if (sscanf(line, "v %lf %lf %lf", &x[0], &x[1], &x[2]) == 3)
      places[count++] = find_vertex(x);
  }
  free(text);
  return count;
}

static void caches_move_the_vertices_of_the_obj(void **state) {
  (void)state;
  int64_t places[200];
  const int64_t count = read_obj(places);
  for (int kind = 0; kind < 2; kind++) {
    // MDD is big-endian with the times in its header, PC2 is little-endian
    size_t size = 0;
    const bool mdd = kind == 1;
    unsigned char *bytes = read_bytes(mdd ? "run.mdd" : "run.pc2", &size);
    const size_t head = mdd ? 8 + 4 * (size_t)rows : 32;
    assert_int_equal(size, head + 12 * (size_t)(rows * count));

    for (int64_t row = 0; row < rows; row += 11)
      for (int64_t v = 0; v < count; v++)
        for (int axis = 0; axis < 3; axis++) {
          const size_t at = head + 4 * (size_t)(3 * (row * count + v) + axis);
          const double exact = position(places[v], axis, row);
          // a sum of numbers in single precision is as exact as the larger of them
          const double scale = fabs(exact) + fabs(model->vertices[3 * places[v] + axis]);
          assert_true(fabs((double)float_at(bytes + at, mdd) - exact) <= 1e-7 * scale + 1e-9);
        }

    if (mdd)
      assert_true(fabs((double)float_at(bytes + 8 + 4 * (size_t)(rows - 1), true) - 0.201) < 1e-6);
    else
      assert_memory_equal(bytes, "POINTCACHE2\0\1\0\0\0", 16);
    free(bytes);
  }
}

static void rows_are_thinned_to_the_rate_asked_for(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "export", "run/", "--glb", "thin.glb", "--fps", "50", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  glb_file file = open_glb("thin.glb");
  int64_t times = 0;
  const float *time = accessor(&file, (int)rank + 2, &times);

  // 0.201 s at 50 frames a second, and the last row
  assert_true(times >= 11 && times <= 12);
  for (int64_t n = 1; n < times; n++)
    assert_true(time[n] > time[n - 1]);
  assert_true(fabs((double)time[times - 1] - 0.201) < 1e-6);
  close_glb(&file);
}

static void options_and_files_that_do_not_go_together_are_refused(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x2x2@1x0.2x0.3", "--order", "1", "--fix", "x<0.001",
                "--young", "1e5", "--modes", "4", "--rank", "7", "-q", "-o", "other.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // arguments of the command, the exit code and part of the message
  static const struct {
    int code;
    const char *arguments[6], *words;
  } cases[] = {
      {2, {"beam.npz", "--glb", "x.glb"}, "name its folder"},
      {1, {"nothing", "--glb", "x.glb"}, "nothing: no such folder"},
      {2, {"beam", "--pc2", "x.pc2"}, "name its folder"},
      {2, {"run", "--matrices", "x"}, "are of a model"},
      {2, {"run"}, "say what to write"},
      {1, {"run", "--glb", "x.glb", "--model", "other.npz"}, "is not the model"},
      {1, {"run", "--glb", "x.glb", "--model", "none.npz"}, "none.npz"},
      {1, {"run", "--glb", "no/x.glb"}, "no/x.glb: cannot be created"},
      {2, {"run", "--glb", "x.glTF"}, "ends with .glb"},
      {2, {"run", "--glb", "x.glb", "--fps", "-1"}, "--fps wants"},
      {2, {"run", "--glb", "x.glb", "--obj", "./x.glb"}, "name one file"},
  };

  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    const char *const *a = cases[n].arguments;
    run = thrum_run(folder, "export", a[0], a[1], a[2], a[3], a[4], NULL);
    if (!is_refusal(&run, cases[n].code, cases[n].words))
      fail_msg("case %d: exit %d, %s", (int)n, run.exit_code, run.err);
    program_result_free(&run);
  }

  assert_false(file_exists(in_folder("x.glb")));
}

/* The run's folder and its model may be moved together. */
static void a_run_finds_its_model_beside_it(void **state) {
  (void)state;
  program_result run = thrum_run("/", "export", in_folder("run"), "--obj", "/dev/null/x.obj", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "/dev/null/x.obj"));
  program_result_free(&run);
  char path[200];
  snprintf(path, sizeof path, "%s/moved.obj", folder);
  run = thrum_run("/", "export", in_folder("run"), "--obj", path, NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

/* Exports the surface of the run; the exit code and a part of the message are these. */
static void expect_export(int code, const char *words) {
  program_result run = thrum_run(folder, "export", "run", "--obj", "again.obj", NULL);
  if (run.exit_code != code || strstr(run.err, words) == NULL)
    fail_msg("exit %d, %s", run.exit_code, run.err);
  program_result_free(&run);
}

/* Formats that are not written are answered with what makes them, and no file has a wrong name. */
static void formats_that_are_not_written_are_refused(void **state) {
  (void)state;
  static const char *const cases[][3] = {{"--glb", "x.usdc", "a name that ends with .glb"},
                                         {"--glb", "x.gltf", "a name that ends with .glb"},
                                         {"--usd", "x.usd", "of which Blender makes both"},
                                         {"--alembic", "x.abc", "of which Blender makes both"}};
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result run = thrum_run(folder, "export", "run", cases[n][0], cases[n][1], NULL);
    if (run.exit_code != 2 || strstr(run.err, cases[n][2]) == NULL)
      fail_msg("exit %d, %s", run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    assert_true(access(in_folder(cases[n][1]), F_OK) != 0);
    program_result_free(&run);
  }
}

/* Writes a report again without a key, as earlier versions did. */
static void leave_out(const char *name, const char *key) {
  size_t length = 0;
  unsigned char *text = read_bytes(name, &length);
  cJSON *report = cJSON_ParseWithLength((const char *)text, length);
  cJSON_DeleteItemFromObject(report, key);
  char *left = cJSON_PrintUnformatted(report);
  assert_true(text_file_write(in_folder(name), left));
  cJSON_free(left);
  cJSON_Delete(report);
  free(text);
}

/* A model that is made again has other bytes, the times of its making, and is the same model. */
static void a_model_made_again_serves_earlier_runs(void **state) {
  (void)state;
  size_t size = 0, other_size = 0;
  unsigned char *bytes = read_bytes("beam.npz", &size);
  assert_true(precompute_beam("6x2x2@1x0.2x0.3", "4", "7"));
  unsigned char *others = read_bytes("beam.npz", &other_size);
  assert_false(size == other_size && memcmp(bytes, others, size) == 0);
  expect_export(0, "");

  // an earlier version noted the hash of the file's bytes alone, and these bytes are others
  size_t length = 0;
  unsigned char *text = read_bytes("run/run.json", &length);
  leave_out("run/run.json", "model_arrays_hash");
  expect_export(1, "is not the model that run was made with");
  assert_true(thrum_file_write_atomic(in_folder("beam.npz"), bytes, size, NULL) >= 0);
  expect_export(0, "");

  // a model whose mesh differs in one number is another model
  assert_true(thrum_file_write_atomic(in_folder("run/run.json"), text, length, NULL) >= 0);
  assert_true(precompute_beam("6x2x2@1x0.2x0.31", "4", "7"));
  expect_export(1, "made again from the same mesh by the same options it is the same");
  assert_true(thrum_file_write_atomic(in_folder("beam.npz"), bytes, size, NULL) >= 0);
  free(bytes);
  free(others);
  free(text);
}

/* The run of a mesh names the model that was made of it. */
static void the_run_of_a_mesh_is_exported_too(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "simulate", "beam:4x1x1@1x0.2x0.2", "--full", "--fix", "x<0.001", "-o",
                "whole", "--time", "0.01", "--start", "mode:1,0.01", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "info", "whole", NULL);
  assert_non_null(strstr(run.out, "\nmodel             beam:4x1x1@1x0.2x0.2\n"));
  assert_non_null(strstr(run.out, "view whole, which plays it"));
  program_result_free(&run);
  run = thrum_run(folder, "export", "whole", "--glb", "whole.glb", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // that of an earlier version does not
  leave_out("whole/run.json", "model_file");
  run = thrum_run(folder, "info", "whole", NULL);
  assert_non_null(strstr(run.out, "missing           whole is a run of the mesh beam:4x1x1"));
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "export", "whole", "--glb", "whole.glb", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "simulate again\n"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_glb_holds_the_motion_of_the_run),
      cmocka_unit_test(the_surface_is_closed_and_looks_outwards),
      cmocka_unit_test(normals_follow_the_surface),
      cmocka_unit_test(caches_move_the_vertices_of_the_obj),
      cmocka_unit_test(rows_are_thinned_to_the_rate_asked_for),
      cmocka_unit_test(options_and_files_that_do_not_go_together_are_refused),
      cmocka_unit_test(a_run_finds_its_model_beside_it),
      cmocka_unit_test(formats_that_are_not_written_are_refused),
      cmocka_unit_test(a_model_made_again_serves_earlier_runs),
      cmocka_unit_test(the_run_of_a_mesh_is_exported_too),
  };
  return cmocka_run_group_tests(tests, make_run, remove_run);
}
