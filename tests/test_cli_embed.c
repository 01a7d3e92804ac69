/* `thrum embed` as it is typed: files, JSON, warnings, exit codes. SPDX-License-Identifier:
 * Apache-2.0 */
// clang-format off
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on

#include "tests/cli_support.h"

#include <math.h>

#include "thrum/embedding.h"

static char folder[64];

static int setup(void **state) {
  (void)state;
  if (cli_make_folder(folder) == NULL)
    return -1;
  cli_result run = thrum_run(folder, "precompute", "beam:6x2x2@1x0.2x0.2", "--fix", "x<0.001",
                             "--modes", "4", "--rank", "8", "-q", "-o", "beam.npz", NULL);
  const int code = run.exit_code;
  cli_result_free(&run);
  return code;
}

static int teardown(void **state) {
  (void)state;
  cli_remove_folder(folder);
  return 0;
}

static const char *in_folder(const char *name) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return path;
}

static void write_text(const char *name, const char *text) {
  assert_true(cli_write_text(in_folder(name), text));
}

/* A tent: three corners on the mesh's top face, one vertex `height` above it. */
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
  cli_result run =
      thrum_run(folder, "embed", "beam.npz", "tent.obj", "-o", "tent.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_true(cli_line_count_is(run.err, 1));
  assert_non_null(strstr(run.err, "warning: tent.obj: 1 vertices lie outside the mesh, vertex 4"));
  cJSON *object = cli_json_line(run.out);
  assert_non_null(object);
  assert_true(cli_json_get(object, "vertices") == 4);
  assert_true(cli_json_get(object, "triangles") == 3);
  assert_true(cli_json_get(object, "outside") == 1);
  assert_true(cli_json_get(object, "outside_vertex") == 4);
  assert_true(fabs(cli_json_get(object, "outside_max_m") - 0.05) < 1e-12);
  cJSON_Delete(object);
  cli_result_free(&run);
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
  thrum_embedding_free(e);
}

/* In centimetres, and said so or not. */
static void a_wrong_scale_is_flagged(void **state) {
  (void)state;
  write_text("cm.obj", "v 20 0 10\nv 50 10 10\nv 50 -10 10\nf 1 2 3\n");
  cli_result run =
      thrum_run(folder, "embed", "beam.npz", "cm.obj", "-o", "cm.npz", "--scale", "0.01", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  assert_non_null(strstr(run.out, "outside the mesh  0 vertices"));
  cli_result_free(&run);
  run = thrum_run(folder, "embed", "beam.npz", "cm.obj", "-o", "cm.npz", "--json", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "is the scale right"));
  assert_non_null(strstr(run.out, "\"status\":\"flagged\""));
  cli_result_free(&run);
}

static void what_cannot_be_embedded_is_refused_and_nothing_written(void **state) {
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
    const char *const *a = cases[i].arguments;
    cli_result run =
        thrum_run(folder, "embed", a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], NULL);
    if (run.exit_code != cases[i].code || strstr(run.err, cases[i].words) == NULL ||
        !cli_line_count_is(run.err, 1) || run.out[0] != 0)
      fail_msg("wanted %d '%s', got %d '%s'", cases[i].code, cases[i].words, run.exit_code,
               run.err);
    cli_result_free(&run);
    assert_false(cli_file_exists(in_folder("no.npz")));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_surface_is_embedded_and_loads),
      cmocka_unit_test(a_wrong_scale_is_flagged),
      cmocka_unit_test(what_cannot_be_embedded_is_refused_and_nothing_written),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
