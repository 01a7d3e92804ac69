/* `thrum embed` is run as it is typed and tested by its files, JSON, warnings and exit codes.
 * SPDX-License-Identifier: Apache-2.0 */
// clang-format off
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on

#include "tests/support/test_folder.h"

#include <math.h>

#include "thrum/embedding.h"

static int setup(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x2x2@1x0.2x0.2", "--order", "1", "--fix", "x<0.001",
                "--modes", "4", "--rank", "8", "-q", "-o", "beam.npz", NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

static int teardown(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

static void write_text(const char *name, const char *text) {
  assert_true(text_file_write(in_folder(name), text));
}

/* Writes a tent: three corners on the mesh's top face, one vertex `height` above it. */
static void write_tent(const char *name, double height) {
  char text[256];
  snprintf(text, sizeof text,
           "v 0.2 0 0.1\nv 0.5 0.1 0.1\nv 0.5 -0.1 0.1\nv 0.4 0 %.17g\nf 1 3 4\nf 1 4 2\nf 2 4 3\n",
           0.1 + height);
  write_text(name, text);
}

static void a_surface_is_embedded_and_loads(void **state) {
  (void)state;
  write_tent("tent.obj", 0.05);

  program_result run =
      thrum_run(folder, "embed", "beam.npz", "tent.obj", "-o", "tent.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_true(line_count_is(run.err, 1));
  assert_non_null(strstr(run.err, "warning: tent.obj: 1 vertices lie outside the mesh, vertex 4"));

  // counts are from 1, and the vertex outside is as far away as it was put
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_true(json_value(object, "vertices") == 4);
  assert_true(json_value(object, "triangles") == 3);
  assert_true(json_value(object, "outside") == 1);
  assert_true(json_value(object, "outside_vertex") == 4);
  assert_true(fabs(json_value(object, "outside_max_m") - 0.05) < 1e-12);
  cJSON_Delete(object);
  program_result_free(&run);

  // the file is that of the model's rank, and names the surface it was made from
  const thrum_embedding *e = NULL;
  thrum_error error = {0};
  if (thrum_embedding_load(in_folder("tent.npz"), &e, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(e->rank, 8);
  assert_true(e->meta_bytes > 0);

  char *meta = malloc((size_t)e->meta_bytes + 1);
  assert_non_null(meta);
  memcpy(meta, e->meta, (size_t)e->meta_bytes);
  meta[e->meta_bytes] = 0;
  cJSON *about = cJSON_Parse(meta);
  assert_string_equal(cJSON_GetObjectItem(about, "surface")->valuestring, "tent.obj");
  cJSON_Delete(about);
  free(meta);

  thrum_embedding_destroy(e);
}

static void info_knows_a_surface(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "info", "tent.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_true(json_value(object, "vertices") == 4 && json_value(object, "rank") == 8);
  assert_string_equal(cJSON_GetObjectItem(object, "made_from")->valuestring, "tent.obj");
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "info", "tent.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "made from         tent.obj, in beam.npz"));
  program_result_free(&run);
}

/* The surface is in centimetres, which --scale says or does not say. */
static void a_wrong_scale_is_flagged(void **state) {
  (void)state;
  write_text("cm.obj", "v 20 0 10\nv 50 10 10\nv 50 -10 10\nf 1 2 3\n");
  program_result run =
      thrum_run(folder, "embed", "beam.npz", "cm.obj", "-o", "cm.npz", "--scale", "0.01", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  assert_non_null(strstr(run.out, "outside the mesh  0 vertices"));
  program_result_free(&run);
  run = thrum_run(folder, "embed", "beam.npz", "cm.obj", "-o", "cm.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "is the scale right"));
  assert_non_null(strstr(run.out, "\"status\":\"flagged\""));
  program_result_free(&run);
}

static void bad_surfaces_and_models_are_refused_and_nothing_written(void **state) {
  (void)state;
  write_text("bad.obj", "v 0 0 0\nf 1 2 3\n");
  write_tent("good.obj", 0);

  static const struct {
    int code;
    const char *arguments[8], *words;
  } cases[] = {{1, {"beam.npz", "bad.obj", "-o", "no.npz"}, "bad.obj:2: a corner names vertex 2"},
               {1, {"beam.npz", "none.stl", "-o", "no.npz"}, "none.stl: cannot be read"},
               {1, {"beam.npz", "beam.npz", "-o", "no.npz"}, "unknown kind of surface"},
               {1, {"good.obj", "good.obj", "-o", "no.npz"}, "good.obj: not a model file"},
               {1, {"beam.npz", "good.obj", "-o", "none/no.npz"}, "none/no.npz"},
               {2, {"beam.npz", "good.obj"}, "-o FILE.npz"},
               {2, {"beam.npz", "-o", "no.npz"}, "MODEL SURFACE"},
               {2, {"beam.npz", "good.obj", "-o", "./beam.npz"}, "write to another file"},
               {2, {"beam.npz", "good.obj", "-o", "no.npz", "--scale", "0"}, "--scale wants"}};

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    // one line on standard error, and no file
    const char *const *a = cases[i].arguments;
    program_result run =
        thrum_run(folder, "embed", a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], NULL);
    if (!is_refusal(&run, cases[i].code, cases[i].words))
      fail_msg("wanted %d '%s', got %d '%s'", cases[i].code, cases[i].words, run.exit_code,
               run.err);
    program_result_free(&run);
    assert_false(file_exists(in_folder("no.npz")));
  }
}

static void export(const char *name, const char *surface, int64_t *size, char **bytes) {
  static const char *const options[] = {"--glb", "--pc2", "--mdd", "--obj"};
  for (int n = 0; n < 4; n++) {
    program_result run =
        surface == NULL
            ? thrum_run(folder, "export", "run", options[n], name, NULL)
            : thrum_run(folder, "export", "run", options[n], name, "--surface", surface, NULL);
    if (run.exit_code != 0 || run.err[0] != 0)
      fail_msg("%d: %s", run.exit_code, run.err);
    program_result_free(&run);

    // the bytes are kept for comparison
    FILE *file = fopen(in_folder(name), "rb");
    assert_non_null(file);
    bytes[n] = malloc(1 << 20);
    assert_non_null(bytes[n]);
    size[n] = (int64_t)fread(bytes[n], 1, 1 << 20, file);
    fclose(file);
    assert_in_range(size[n], 100, (1 << 20) - 1);
  }
}

/* The skin, embedded in its own mesh, moves as the skin: its vertices have the rows of the mesh. */
static void an_embedded_skin_is_exported_as_the_skin(void **state) {
  (void)state;

  // a run, the surface of its mesh as .obj, and that surface embedded
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "run", "--time", "0.3",
                                 "--start", "mode:1,0.05", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "export", "beam.npz", "--obj", "skin.obj", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "embed", "beam.npz", "skin.obj", "-o", "skin.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the mesh's own surface, the embedded one, and the one embedded for this export
  int64_t size[3][4];
  char *bytes[3][4];
  export("a", NULL, size[0], bytes[0]);
  export("a", "skin.npz", size[1], bytes[1]);
  export("a", "skin.obj", size[2], bytes[2]);

  // all files are equal, byte for byte
  for (int n = 0; n < 4; n++) {
    for (int other = 1; other < 3; other++) {
      assert_int_equal(size[0][n], size[other][n]);
      assert_memory_equal(bytes[0][n], bytes[other][n], (size_t)size[0][n]);
    }
    for (int k = 0; k < 3; k++)
      free(bytes[k][n]);
  }
}

static void an_export_shows_the_surface(void **state) {
  (void)state;
  write_tent("tent.obj", 0);
  program_result run = thrum_run(folder, "embed", "beam.npz", "tent.obj", "-o", "tent.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  run = thrum_run(folder, "export", "run", "--surface", "tent.npz", "--obj", "back.obj", "--pc2",
                  "tent.pc2", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the .obj has the triangles of the surface, not of the mesh
  char *text = text_file_read(in_folder("back.obj"));
  assert_non_null(text);
  assert_non_null(strstr(text, "\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"));
  free(text);

  // the first row of the cache is X + W q of the start
  unsigned char head[32 + 48];
  FILE *file = fopen(in_folder("tent.pc2"), "rb");
  assert_non_null(file);
  assert_int_equal(fread(head, 1, sizeof head, file), sizeof head);
  fclose(file);

  int32_t vertices;
  float shown[12];
  memcpy(&vertices, head + 16, sizeof vertices);
  assert_int_equal(vertices, 4);
  memcpy(shown, head + 32, sizeof shown);

  // the surface's own basis and the start of the run
  thrum_error error = {0};
  const thrum_embedding *e = NULL;
  const thrum_model *model = NULL;
  assert_int_equal(thrum_embedding_load(in_folder("tent.npz"), &e, &error), 0);
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &model, &error), 0);

  double start[64], off = 0;
  FILE *q = fopen(in_folder("run/q.npy"), "rb");
  assert_non_null(q);
  assert_int_equal(fseek(q, 128, SEEK_SET), 0);
  assert_int_equal(fread(start, 8, (size_t)e->rank, q), e->rank);
  fclose(q);

  for (int n = 0; n < 12; n++) {
    double x = e->positions[n];
    for (int64_t i = 0; i < e->rank; i++)
      x += (double)e->basis[n * e->rank + i] * start[i];
    assert_true(fabs((double)shown[n] - x) < 1e-7);
    off = fmax(off, fabs(x - e->positions[n]));
  }

  assert_true(off > 1e-3);
  thrum_embedding_destroy(e);
  thrum_model_destroy(model);
}

static void a_surface_of_another_model_is_not_shown(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:5x2x2@1x0.2x0.2", "--order", "1", "--fix", "x<0.001",
                "--modes", "4", "--rank", "8", "-q", "-o", "other.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the files of other models, and outputs that do not go with a surface
  static const struct {
    int code;
    const char *arguments[6], *words;
  } cases[] = {
      {1, {"other.npz", "--obj", "x.obj", "--surface", "tent.npz"}, "embedded in another model"},
      {1, {"beam.npz", "--obj", "x.obj", "--surface", "beam.npz"}, "'surface_format' is missing"},
      {1, {"beam.npz", "--obj", "x.obj", "--surface", "none.obj"}, "none.obj"},
      {2, {"beam.npz", "--obj", "tent.obj", "--surface", "tent.obj"}, "write to another file"},
      {2, {"beam.npz", "--matrices", "x", "--surface", "tent.npz"}, "--surface goes with"}};

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const char *const *a = cases[i].arguments;
    run = thrum_run(folder, "export", a[0], a[1], a[2], a[3], a[4], NULL);
    if (run.exit_code != cases[i].code || strstr(run.err, cases[i].words) == NULL)
      fail_msg("wanted %d '%s', got %d '%s'", cases[i].code, cases[i].words, run.exit_code,
               run.err);
    program_result_free(&run);
    assert_false(file_exists(in_folder("x.obj")));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_surface_is_embedded_and_loads),
      cmocka_unit_test(info_knows_a_surface),
      cmocka_unit_test(a_wrong_scale_is_flagged),
      cmocka_unit_test(bad_surfaces_and_models_are_refused_and_nothing_written),
      cmocka_unit_test(an_embedded_skin_is_exported_as_the_skin),
      cmocka_unit_test(an_export_shows_the_surface),
      cmocka_unit_test(a_surface_of_another_model_is_not_shown),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
