/* `thrum view` makes one page that holds the models as they are, and opens its address.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <sys/stat.h>
#include <time.h>

#include "io/file.h"
#include "tests/support/base64_decode.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

#define BEGIN "<p>before <script type=\"application/octet-stream\" id=\"thrum-pack\""
#define PAGE BEGIN "></script> after</p>"

static const thrum_model *model;

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !text_file_write(in_folder("page.html"), PAGE) ||
      setenv("THRUM_VIEWER", in_folder("page.html"), 1) != 0)
    return -1;
  return precompute_beam("6x2x2@1x0.2x0.3", "4", "7") &&
                 thrum_model_load(in_folder("beam.npz"), &model, NULL) >= 0
             ? 0
             : -1;
}

static int remove_model(void **state) {
  thrum_model_destroy(model);
  return remove_folder(state);
}

/* Decodes base64 up to `end`. */
static unsigned char *decode(const char *text, const char *end, size_t *size) {
  unsigned char *bytes = malloc((size_t)(end - text) + 1);
  assert_non_null(bytes);
  *size = base64_decode(text, (uint64_t)(end - text), bytes);
  return bytes;
}

typedef struct pack {
  unsigned char *bytes;
  size_t size;
  cJSON *json;
  const unsigned char *data;
} pack;

/* Decodes the pack inside a page and reads its header. */
static pack open_pack(const char *name) {
  static const char begin[] = BEGIN ">", end[] = "</script> after</p>";
  pack p = {0};

  // the page around the archive is unchanged
  char *text = text_file_read(in_folder(name));
  assert_non_null(text);
  assert_memory_equal(text, begin, sizeof begin - 1);
  const char *stop = strstr(text, end);
  assert_non_null(stop);
  assert_string_equal(stop, end);
  p.bytes = decode(text + sizeof begin - 1, stop, &p.size);
  free(text);

  uint32_t numbers[2];
  assert_true(p.size > 16);
  assert_memory_equal(p.bytes, "THRUMPK1", 8);
  memcpy(numbers, p.bytes + 8, sizeof numbers);
  assert_int_equal(numbers[0] % 8, 0);
  assert_int_equal(numbers[1], 0);
  p.json = cJSON_ParseWithLength((const char *)p.bytes + 16, numbers[0]);
  assert_non_null(p.json);
  p.data = p.bytes + 16 + numbers[0];
  return p;
}

static void close_pack(pack *p) {
  cJSON_Delete(p->json);
  free(p->bytes);
}

static const cJSON *model_of(const pack *p, int place) {
  const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItem(p->json, "models"), place);
  assert_non_null(item);
  return item;
}

/* Finds an array of a model, which must have this many elements of this kind and lie inside the
 * pack. */
static const void *array(const pack *p, int place, const char *name, int64_t count,
                         const char *kind) {
  const cJSON *arrays = cJSON_GetObjectItem(model_of(p, place), "arrays");
  const cJSON *item = cJSON_GetObjectItem(arrays, name);
  assert_int_equal(cJSON_GetArraySize(item), 3);

  const double offset = cJSON_GetArrayItem(item, 0)->valuedouble;
  assert_true(cJSON_GetArrayItem(item, 1)->valuedouble == (double)count);
  assert_string_equal(cJSON_GetArrayItem(item, 2)->valuestring, kind);
  assert_true(fmod(offset, 8) == 0);

  const unsigned char *at = p->data + (size_t)offset;
  assert_true(at + count * (kind[1] - '0') <= p->bytes + p->size);
  return at;
}

static void view_to(const char *name, const char *first, const char *second) {
  program_result run = thrum_run(folder, "view", first, "-o", name, "-q", second, NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
}

static void a_pack_holds_the_model_bit_for_bit(void **state) {
  (void)state;
  view_to("one.html", "beam.npz", NULL);
  pack p = open_pack("one.html");
  assert_true(json_value(p.json, "format") == 1);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 1);

  const int64_t rank = model->rank;
  const cJSON *item = model_of(&p, 0);
  assert_string_equal(cJSON_GetObjectItem(item, "name")->valuestring, "beam.npz");
  assert_string_equal(cJSON_GetObjectItem(item, "title")->valuestring, "beam");
  assert_true(json_value(item, "rank") == (double)rank);
  assert_true(json_value(item, "young") == model->material[0]);
  assert_true(json_value(item, "poisson") == model->material[1]);

  // 0.06 m^3 of the default 1000 kg/m^3
  assert_true(fabs(json_value(item, "mass") - 60) < 1e-9);

  // the same bits as in the model file
  const struct {
    const char *name;
    const double *values;
    int64_t count;
  } doubles[] = {{"omega2", model->omega2, rank},
                 {"c3", model->c3, model->c3_count},
                 {"c4", model->c4, model->c4_count},
                 {"axis_mass", model->axis_mass, 3 * rank}};
  for (int n = 0; n < 4; n++)
    assert_memory_equal(array(&p, 0, doubles[n].name, doubles[n].count, "f8"), doubles[n].values,
                        (size_t)doubles[n].count * sizeof(double));
  close_pack(&p);
}

static void a_pack_shows_the_surface_of_the_mesh(void **state) {
  (void)state;
  view_to("one.html", "beam.npz", NULL);
  pack p = open_pack("one.html");
  const int64_t vertices = (int64_t)json_value(model_of(&p, 0), "vertex_count");
  const int64_t triangles = (int64_t)json_value(model_of(&p, 0), "triangle_count");
  const int64_t rank = model->rank;
  const float *x = array(&p, 0, "positions", 3 * vertices, "f4");
  const float *basis = array(&p, 0, "basis", 3 * vertices * rank, "f4");
  const int32_t *corner = array(&p, 0, "triangles", 3 * triangles, "i4");
  const unsigned char *fixed = array(&p, 0, "fixed", vertices, "u1");

  // the five vertices on the axis inside are not shown
  assert_int_equal(vertices, model->vertex_count - 5);

  // shown vertices stand in the order of the mesh
  int64_t from = 0;
  for (int64_t v = 0; v < vertices; v++, from++) {
    while (x[3 * v] != (float)model->vertices[3 * from] ||
           x[3 * v + 1] != (float)model->vertices[3 * from + 1] ||
           x[3 * v + 2] != (float)model->vertices[3 * from + 2])
      assert_true(++from < model->vertex_count);
    assert_int_equal(fixed[v], model->fixed[from]);
    for (int64_t n = 0; n < 3 * rank; n++)
      assert_true(basis[3 * v * rank + n] == (float)model->basis[3 * from * rank + n]);
  }

  // the flux of x / 3 through triangles that close and look outwards is the volume
  double volume = 0;
  for (int64_t t = 0; t < 3 * triangles; t += 3) {
    const float *a = x + 3 * corner[t], *b = x + 3 * corner[t + 1], *c = x + 3 * corner[t + 2];
    volume += (double)(a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
                       a[2] * (b[0] * c[1] - b[1] * c[0])) /
              6;
  }
  assert_true(fabs(volume - 0.06) < 1e-6);
  close_pack(&p);
}

static void several_models_share_a_pack(void **state) {
  (void)state;
  program_result made = thrum_run(folder, "precompute", "beam:3x1x1@1x0.2x0.3", "--order", "1",
                                  "--modes", "2", "--rank", "3", "-q", "-o", "free.npz", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);

  // models keep the order in which they were named
  view_to("two.html", "free.npz", "beam.npz");
  pack p = open_pack("two.html");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 2);
  assert_memory_equal(array(&p, 1, "omega2", model->rank, "f8"), model->omega2,
                      (size_t)model->rank * sizeof(double));

  // the scene shows the first one
  const cJSON *scene = cJSON_GetObjectItem(p.json, "scene");
  assert_true(json_value(scene, "dt") == 0.003);
  const cJSON *bodies = cJSON_GetObjectItem(scene, "bodies");
  assert_int_equal(cJSON_GetArraySize(bodies), 1);
  assert_true(json_value(cJSON_GetArrayItem(bodies, 0), "model") == 0);
  assert_true(json_value(cJSON_GetArrayItem(bodies, 0), "rank") == 3);
  close_pack(&p);
}

static const cJSON *item_of(const cJSON *list, int place, const char *key) {
  const cJSON *item = cJSON_GetObjectItem(cJSON_GetArrayItem(list, place), key);
  assert_non_null(item);
  return item;
}

static void expect_numbers(const cJSON *array, const double *values, int count) {
  assert_int_equal(cJSON_GetArraySize(array), count);
  for (int n = 0; n < count; n++)
    assert_true(fabs(cJSON_GetArrayItem(array, n)->valuedouble - values[n]) < 1e-15);
}

#define SCENE                                                                                      \
  "{\"dt\": 0.002, \"gravity\": [0, 0, -9.81], \"damping\": 0.5, \"bodies\": [\n"                  \
  "{\"name\": \"left\", \"model\": \"beam.npz\", \"rank\": 5, \"position\": [1, 2, 3],\n"          \
  " \"rotation\": {\"axis\": [0, 0, 2], \"angle\": 90}, \"stiffness\": 3, \"colour\": "            \
  "\"#01a0ff\"},\n"                                                                                \
  "{\"name\": \"right\", \"model\": \"beam.npz\", \"integrator\": \"newmark\",\n"                  \
  " \"damping\": [0.5, 0.001], \"start\": \"mode:1,0.01\",\n"                                      \
  " \"loads\": [\"sine:0,0,2@vertex=3,f=2,until=1\", \"gravity:1,0,0\"]}],\n"                      \
  "\"wind\": {\"velocity\": [1, 0, 0]}, \"base_motion\": \"sine:0.5,0,0,f=2\",\n"                  \
  "\"obstacles\": [{\"shape\": \"sphere\", \"centre\": [0, 1, 0], \"radius\": 0.25}]}\n"

static void expect_effects(const cJSON *scene) {
  static const double wind[3] = {1, 0, 0}, ground[3] = {0.5, 0, 0};
  const cJSON *bodies = cJSON_GetObjectItem(scene, "bodies");
  const cJSON *base_motions = cJSON_GetObjectItem(scene, "base_motion");
  const cJSON *loads = item_of(bodies, 1, "loads");

  // wind and base motion stand as they were given; a motion without an end has no end
  expect_numbers(cJSON_GetObjectItem(cJSON_GetObjectItem(scene, "wind"), "velocity"), wind, 3);
  assert_int_equal(cJSON_GetArraySize(base_motions), 1);
  expect_numbers(item_of(base_motions, 0, "amplitude"), ground, 3);
  assert_true(item_of(base_motions, 0, "frequency")->valuedouble == 2);
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(base_motions, 0), "until"));

  // a start is packed as coordinates, for the body that has one
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(bodies, 0), "q"));
  assert_int_equal(cJSON_GetArraySize(item_of(bodies, 1, "q")), model->rank);

  // gravity is packed as a reduced load, a force at a vertex is not
  assert_int_equal(cJSON_GetArraySize(loads), 2);
  assert_true(item_of(loads, 0, "until")->valuedouble == 1);
  assert_int_equal(cJSON_GetArraySize(item_of(loads, 1, "reduced")), model->rank);
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(loads, 1), "parts"));
}

static void a_scene_file_is_packed_with_its_models(void **state) {
  (void)state;
  static const double place[3] = {1, 2, 3},
                      turn[4] = {0.70710678118654752, 0, 0, 0.70710678118654752};

  assert_true(text_file_write(in_folder("scene.json"), SCENE));
  program_result run = thrum_run(folder, "view", "scene.json", "-o", "scene.html", NULL);
  assert_int_equal(run.exit_code, 0);

  // a setting that the viewer does not have is named
  assert_non_null(
      strstr(run.err, "scene.json: the viewer leaves out damping that grows with stiffness\n"));
  program_result_free(&run);

  // the two bodies share one model
  pack p = open_pack("scene.html");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 1);

  const cJSON *scene = cJSON_GetObjectItem(p.json, "scene");
  assert_true(json_value(scene, "dt") == 0.002 && json_value(scene, "damping") == 0.5);

  // each setting of a body is that of the file, or its default
  const cJSON *bodies = cJSON_GetObjectItem(scene, "bodies");
  assert_int_equal(cJSON_GetArraySize(bodies), 2);
  expect_numbers(item_of(bodies, 0, "position"), place, 3);
  expect_numbers(item_of(bodies, 0, "rotation"), turn, 4);
  assert_string_equal(item_of(bodies, 0, "colour")->valuestring, "#01a0ff");
  assert_true(item_of(bodies, 0, "rank")->valuedouble == 5);
  assert_true(item_of(bodies, 0, "stiffness")->valuedouble == 3);
  assert_true(item_of(bodies, 1, "rank")->valuedouble == (double)model->rank);
  assert_true(item_of(bodies, 1, "model")->valuedouble == 0);
  assert_string_equal(item_of(bodies, 1, "integrator")->valuestring, "newmark");

  expect_effects(scene);

  const cJSON *obstacles = cJSON_GetObjectItem(scene, "obstacles");
  assert_string_equal(item_of(obstacles, 0, "kind")->valuestring, "sphere");
  assert_true(item_of(obstacles, 0, "radius")->valuedouble == 0.25);
  close_pack(&p);
}

/* A model shown by two surfaces is two models of the pack; files lie beside the scene file. */
/* A bar whose spin and shape are coupled hangs on a hinge and is tied to a held beam until 0.5 s.
 */
#define LINKED                                                                                     \
  "{\"bodies\": [{\"name\": \"held\", \"model\": \"beam.npz\", \"position\": [0, 3, 0]},"          \
  " {\"name\": \"bar\", \"model\": \"beam:3x2x2@0.3x0.1x0.1\", \"free\": true, \"coupled\": true," \
  "  \"position\": [1, 2, 3]}],"                                                                   \
  " \"links\": [{\"name\": \"pin\", \"kind\": \"hinge\", \"body\": \"bar\", \"place\": [1, 2, 3]," \
  "  \"axis\": [0, 2, 0]},"                                                                        \
  " {\"kind\": \"spring\", \"body\": \"bar\", \"place\": [1.3, 2, 3], \"other\": \"held\", "       \
  "\"until\": 0.5,"                                                                                \
  "  \"stiffness\": 7}]}\n"

static void links_and_coupled_bodies_are_packed_ready(void **state) {
  (void)state;
  static const double origin[3] = {0, 0, 0}, along[3] = {0, 1, 0};
  assert_true(text_file_write(in_folder("linked.json"), LINKED));
  program_result run = thrum_run(folder, "view", "linked.json", "-o", "linked.html", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_null(strstr(run.err, "leaves out"));
  program_result_free(&run);

  // in the axes of the bar its pin is at the origin, and its first direction along y
  pack p = open_pack("linked.html");
  const cJSON *scene = cJSON_GetObjectItem(p.json, "scene");
  const cJSON *links = cJSON_GetObjectItem(scene, "links");
  const int rank = (int)json_value(model_of(&p, 1), "rank");
  assert_int_equal(cJSON_GetArraySize(links), 2);
  assert_string_equal(item_of(links, 0, "kind")->valuestring, "hinge");
  const cJSON *rest = item_of(links, 0, "rest");
  assert_int_equal(cJSON_GetArraySize(rest), 12);
  for (int axis = 0; axis < 3; axis++) {
    assert_true(fabs(cJSON_GetArrayItem(rest, axis)->valuedouble - origin[axis]) < 1e-12);
    assert_true(fabs(cJSON_GetArrayItem(rest, 3 + axis)->valuedouble - along[axis]) < 1e-12);
  }
  assert_int_equal(cJSON_GetArraySize(item_of(links, 0, "rows")), 12 * rank);
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(links, 0), "other"));
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(links, 0), "other_rows"));
  assert_false(cJSON_HasObjectItem(cJSON_GetArrayItem(links, 0), "until"));

  // the spring has two sides, and the length that it has at the start
  assert_int_equal(cJSON_GetArraySize(item_of(links, 1, "other_rows")), 12 * (int)model->rank);
  assert_true(item_of(links, 1, "other")->valuedouble == 0);
  assert_true(item_of(links, 1, "until")->valuedouble == 0.5);
  assert_true(item_of(links, 1, "stiffness")->valuedouble == 7);
  assert_true(item_of(links, 1, "length")->valuedouble == 0);

  // modes are orthonormal in the pairs of the inertia, which no other model has
  const double *pairs =
      (const double *)array(&p, 1, "inertia", 9 + 9 * rank * (rank + 1), "f8") + 9 + 9 * rank;
  for (int j = 0; j < rank; j++)
    for (int i = 0; i < rank; i++) {
      const double *moment = pairs + 9 * (j * rank + i);
      assert_true(fabs(moment[0] + moment[4] + moment[8] - (i == j)) < 1e-9);
    }
  assert_false(cJSON_HasObjectItem(cJSON_GetObjectItem(model_of(&p, 0), "arrays"), "inertia"));
  assert_true(cJSON_IsTrue(item_of(cJSON_GetObjectItem(scene, "bodies"), 1, "coupled")));
  close_pack(&p);
}

static void a_body_is_shown_by_its_own_surface(void **state) {
  (void)state;
  assert_int_equal(mkdir(in_folder("beside"), 0700), 0);

  assert_true(text_file_write(in_folder("beside/sheet.obj"),
                              "v 0.2 0 0\nv 0.6 0 0\nv 0.4 0.05 0.02\nf 1 2 3\n"));
  assert_true(
      text_file_write(in_folder("beside/scene.json"),
                      "{\"bodies\": [{\"model\": \"../beam.npz\"},\n"
                      "{\"model\": \"../beam.npz\", \"surface\": \"sheet.obj\"},\n"
                      "{\"model\": \"../beam.npz\", \"surface\": \"sheet.obj\", \"rank\": 3}]}\n"));

  program_result run = thrum_run(folder, "view", "beside/scene.json", "-o", "own.html", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);

  // the mesh's own surface and the triangle, which two bodies share
  pack p = open_pack("own.html");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 2);
  assert_true(json_value(model_of(&p, 1), "vertex_count") == 3);
  assert_true(json_value(model_of(&p, 0), "vertex_count") > 8);

  const cJSON *bodies = cJSON_GetObjectItem(cJSON_GetObjectItem(p.json, "scene"), "bodies");
  for (int n = 0; n < 3; n++)
    assert_true(item_of(bodies, n, "model")->valuedouble == (n > 0));
  close_pack(&p);
}

/* A run of a scene keeps each model once, its obstacles, and the rows of each body. */
static void a_run_is_packed_with_its_rows(void **state) {
  (void)state;
  assert_true(text_file_write(
      in_folder("fall.json"),
      "{\"dt\": 0.01, \"time\": 0.5, \"bodies\": [\n"
      "{\"name\": \"a\", \"model\": \"beam.npz\"},\n"
      "{\"name\": \"b\", \"model\": \"beam.npz\", \"position\": [0, 2, 0]}],\n"
      "\"obstacles\": [{\"shape\": \"sphere\", \"radius\": 1, \"centre\": [0, 9, 0]}]}\n"));
  program_result run = thrum_run(folder, "simulate", "fall.json", "-o", "fall", "-q", NULL);
  program_result_free(&run);
  run = thrum_run(folder, "view", "fall", "-o", "fall.html", "--fps", "20", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);

  // two bodies of one model, and the obstacle
  pack p = open_pack("fall.html");
  const cJSON *scene = cJSON_GetObjectItem(p.json, "scene");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 1);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(scene, "obstacles")), 1);
  assert_true(
      item_of(cJSON_GetObjectItem(scene, "bodies"), 1, "position")->child->next->valuedouble == 2);

  // what the run says of its bases, for the page
  assert_string_equal(item_of(cJSON_GetObjectItem(scene, "bodies"), 0, "error")->valuestring,
                      "the basis is not judged: nothing has moved");

  // 20 rows a second of half a second, and the first
  const cJSON *recording = cJSON_GetObjectItem(p.json, "recording");
  assert_int_equal(cJSON_GetArraySize(recording), 2);
  const cJSON *times = cJSON_GetObjectItem(item_of(recording, 1, "arrays"), "times");
  assert_true(cJSON_GetArrayItem(times, 1)->valuedouble == 11);
  close_pack(&p);
}

/* A curve keeps the motions of all coordinates, and what is said of each. */
static void a_curve_is_packed_with_its_motions(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "response", "beam.npz", "--load", "sine:0,0,0.1@vertex=40",
                                 "--damping-ratio", "0.1", "--condense", "2", "--harmonics", "3",
                                 "-o", "curve", "--no-check", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  run = thrum_run(folder, "view", "curve", "-o", "curve.html", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  pack p = open_pack("curve.html");
  const cJSON *curve = cJSON_GetObjectItem(p.json, "curve");
  const cJSON *arrays = cJSON_GetObjectItem(curve, "arrays");
  const double rows = cJSON_GetArrayItem(cJSON_GetObjectItem(arrays, "frequency"), 1)->valuedouble;
  assert_true(rows > 5);
  assert_true(json_value(curve, "harmonics") == 6);
  assert_string_equal(cJSON_GetObjectItem(curve, "target")->valuestring, "vertex=40");
  assert_true(cJSON_GetArrayItem(cJSON_GetObjectItem(arrays, "motion"), 1)->valuedouble ==
              rows * 13 * (double)model->rank);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(p.json, "models")), 1);
  close_pack(&p);
}

/* Names in the run's folder are those of the command that made it, which was called in `folder`. */
static void a_run_is_shown_from_any_folder(void **state) {
  (void)state;
  assert_int_equal(mkdir(in_folder("runs"), 0700), 0);
  assert_int_equal(mkdir(in_folder("runs/far"), 0700), 0);
  assert_int_equal(mkdir(in_folder("elsewhere"), 0700), 0);
  program_result run =
      thrum_run(folder, "simulate", "fall.json", "-o", "runs/far/fall", "-q", NULL);
  program_result_free(&run);

  // the model and the scene file with its obstacle are found above the run, and a file that has the
  // model's name from here is passed over, as it has other bytes
  assert_true(text_file_write(in_folder("elsewhere/beam.npz"), "another model"));
  char elsewhere[160];
  snprintf(elsewhere, sizeof elsewhere, "%s", in_folder("elsewhere"));
  run = thrum_run(elsewhere, "view", "../runs/far/fall", "-o", "../far.html", NULL);
  if (run.exit_code != 0 || run.err[0] != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  pack p = open_pack("far.html");
  const cJSON *scene = cJSON_GetObjectItem(p.json, "scene");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(scene, "bodies")), 2);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(scene, "obstacles")), 1);
  close_pack(&p);

  // without the model the run is named with it, in one line
  assert_int_equal(rename(in_folder("beam.npz"), in_folder("hidden.npz")), 0);
  assert_int_equal(remove(in_folder("elsewhere/beam.npz")), 0);
  run = thrum_run(elsewhere, "view", "../runs/far/fall", "-o", "../gone.html", NULL);
  assert_int_equal(rename(in_folder("hidden.npz"), in_folder("beam.npz")), 0);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "was made with the model beam.npz, which is neither here"));
  assert_true(line_count_is(run.err, 1));
  program_result_free(&run);
}

/* The page steps a model without its flow, and plays a run that flowed as it was. */
static void flow_is_left_out_where_the_page_steps(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", "beam:4x1x1@1x0.15x0.15", "--order", "1",
                                 "--fix", "x<0.001", "--modes", "3", "--rank", "6", "--cubature",
                                 "--cubature-points", "6", "--cubature-error", "1", "--material",
                                 "1:corotational,0.01", "-o", "flows.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "flows.npz", "-o", "flowed", "--time", "0.1", "--start",
                  "mode:1,0.3", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // model and run
  const char *const shown[] = {"flows.npz", "flowed"};
  for (int n = 0; n < 2; n++) {
    run = thrum_run(folder, "view", shown[n], "-o", "flows.html", NULL);
    assert_int_equal(run.exit_code, 0);
    assert_int_equal(strstr(run.err, "leaves out plastic flow") != NULL, n == 0);
    program_result_free(&run);
  }
}

static void expect_refusal(program_result run, int code, const char *words) {
  if (!is_refusal(&run, code, words))
    fail_msg("exit %d, %s", run.exit_code, run.err);
  program_result_free(&run);
}

static void missing_inputs_and_wrong_options_are_refused(void **state) {
  (void)state;

  // files that are missing or no model, and an output in the place of an input
  expect_refusal(thrum_run(folder, "view", "none.npz", "-o", "x.html", NULL), 1, "none.npz");
  expect_refusal(thrum_run(folder, "view", "page.html", "-o", "x.html", NULL), 1, "page.html");
  expect_refusal(thrum_run(folder, "view", "beam.npz", "-o", "beam.npz", NULL), 2, "is what");

  // a mesh, a surface and a place that need something else first
  expect_refusal(thrum_run(folder, "view", "beam:4x1x1@1x1x1", NULL), 2, "thrum precompute");
  expect_refusal(thrum_run(folder, "view", "skin.obj", NULL), 2, "--surface");
  assert_int_equal(mkdir(in_folder("empty"), 0700), 0);
  expect_refusal(thrum_run(folder, "view", "empty", NULL), 1, "a folder without a finished run");
  program_result unwritten = thrum_run(folder, "view", "beam.npz", "-o", "no/x.html", NULL);
  assert_true(unwritten.exit_code == 1 && strstr(unwritten.err, "no/x.html") != NULL);
  program_result_free(&unwritten);

  // combinations that do not go together
  expect_refusal(thrum_run(folder, "view", "scene.json", "beam.npz", "-o", "x.html", NULL), 2,
                 "one scene");
  expect_refusal(thrum_run(folder, "view", "none.json", "-o", "x.html", NULL), 1, "none.json");
  expect_refusal(thrum_run(folder, "view", "beam.npz", "free.npz", "--surface", "a.obj", NULL), 2,
                 "one model");
  expect_refusal(thrum_run(folder, "view", "fall", "beam.npz", NULL), 2, "one run");
  expect_refusal(thrum_run(folder, "view", "curve", "beam.npz", NULL), 2, "one run or curve");
  expect_refusal(thrum_run(folder, "view", "beam.npz", "--fps", "0", NULL), 2, "--fps");
  expect_refusal(thrum_run(folder, "view", "beam.npz", "-o", "k.txt", NULL), 2,
                 "give 'k.txt' a name that ends with .html");
  expect_refusal(thrum_run(folder, "view", "fall", "-o", "fall/b/q.npy", NULL), 2, ".html");
  assert_false(file_exists(in_folder("k.txt")));

  // the model of a run may have any name
  void *bytes = NULL;
  size_t size = 0;
  assert_true(thrum_file_read(in_folder("beam.npz"), &bytes, &size, NULL) >= 0);
  assert_true(thrum_file_write_atomic(in_folder("odd.html"), bytes, size, NULL) >= 0);
  free(bytes);
  program_result run =
      thrum_run(folder, "simulate", "odd.html", "-o", "odd", "-q", "--time", "0.03", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  expect_refusal(thrum_run(folder, "view", "odd", "-o", "odd.html", NULL), 1, "belongs");

  assert_false(file_exists(in_folder("x.html")));
}

static void a_run_whose_coordinates_are_of_another_run_is_refused(void **state) {
  (void)state;

  // a run of all coordinates, and rows of two
  static const double few[2 * 18] = {0};
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "all", "--time", "0.05", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_true(save_npy(in_folder("all/q.npy"), few, 18, 2));

  expect_refusal(thrum_run(folder, "view", "all", "-o", "x.html", NULL), 1,
                 "has 2 columns, but the run recorded 7");
  assert_false(file_exists(in_folder("x.html")));
}

/* Files of other curves, or that are cut, and another model. */
static void a_curve_whose_files_do_not_go_together_is_refused(void **state) {
  (void)state;
  static const double few[2 * 91] = {0};
  char *rows = text_file_read(in_folder("curve/response.csv"));
  assert_non_null(rows);
  rows[strlen(rows) - 40] = 0;
  *strrchr(rows, '\n') = 0;
  assert_true(text_file_write(in_folder("curve/response.csv"), rows));
  expect_refusal(thrum_run(folder, "view", "curve", "-o", "x.html", NULL), 1, "motions");
  strcpy(strchr(strchr(rows, '\n') + 1, ','), ",knot,1,0");
  assert_true(text_file_write(in_folder("curve/response.csv"), rows));
  expect_refusal(thrum_run(folder, "view", "curve", "-o", "x.html", NULL), 1, "response.csv:2");
  free(rows);
  assert_true(save_npy(in_folder("curve/motions.npy"), few, 2, 90));
  expect_refusal(thrum_run(folder, "view", "curve", "-o", "x.html", NULL), 1, "no motions");
  assert_int_equal(rename(in_folder("beam.npz"), in_folder("kept.npz")), 0);
  program_result run = thrum_run(folder, "precompute", "beam:5x1x1@1x0.2x0.3", "--fix", "x<0.001",
                                 "--modes", "2", "--rank", "5", "-o", "beam.npz", "-q", NULL);
  program_result_free(&run);
  expect_refusal(thrum_run(folder, "view", "curve", "-o", "x.html", NULL), 1, "is not the model");
  assert_int_equal(rename(in_folder("kept.npz"), in_folder("beam.npz")), 0);
  assert_true(text_file_write(in_folder("curve/response.json"), "{}"));
  expect_refusal(thrum_run(folder, "view", "curve", "-o", "x.html", NULL), 1,
                 "find the curve again");
  assert_false(file_exists(in_folder("x.html")));
}

static void a_page_without_a_place_for_a_pack_is_refused(void **state) {
  (void)state;
  char page[160];
  snprintf(page, sizeof page, "%s/other.html", folder);
  assert_true(text_file_write(page, "<p>not the viewer</p>"));
  setenv("THRUM_VIEWER", page, 1);
  expect_refusal(thrum_run(folder, "view", "beam.npz", "-o", "x.html", NULL), 1, "other.html");
  setenv("THRUM_VIEWER", "/nowhere/viewer.html", 1);
  expect_refusal(thrum_run(folder, "view", "beam.npz", "-o", "x.html", NULL), 1, "/nowhere");
  assert_false(file_exists(in_folder("x.html")));
  setenv("THRUM_VIEWER", in_folder("page.html"), 1);
}

/* Waits for the text that the stand-in for xdg-open leaves; NULL when none comes in time. */
static char *opened_address(int tenths) {
  for (int n = 0; n < tenths; n++) {
    if (file_exists(in_folder("opened")))
      return text_file_read(in_folder("opened"));
    nanosleep(&(struct timespec){.tv_nsec = 100000000}, NULL);
  }
  return NULL;
}

static void without_a_name_the_page_is_opened_where_there_is_a_display(void **state) {
  (void)state;
  char path[4200], before[4096], url[256];
  snprintf(before, sizeof before, "%s", getenv("PATH"));
  snprintf(path, sizeof path, "%s/a b:%s", folder, before);

  // a stand-in for xdg-open leaves the address that it is given
  assert_int_equal(mkdir(in_folder("a b"), 0700), 0);
  assert_true(text_file_write(in_folder("a b/xdg-open"),
                              "#!/bin/sh\nprintf %s \"$1\" >part && mv part ../opened\n"));
  assert_int_equal(chmod(in_folder("a b/xdg-open"), 0700), 0);
  assert_int_equal(setenv("PATH", path, 1), 0);

  // it is not called with a name, nor with --no-open, nor without a display
  setenv("DISPLAY", ":99", 1);
  char beside[96];
  snprintf(beside, sizeof beside, "%s/a b", folder);
  for (int n = 0; n < 2; n++) {
    program_result run = n == 0 ? thrum_run(beside, "view", "../beam.npz", "-o", "x.html", NULL)
                                : thrum_run(beside, "view", "../beam.npz", "--no-open", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
  }

  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  program_result alone = thrum_run(beside, "view", "../beam.npz", NULL);
  assert_int_equal(alone.exit_code, 0);
  assert_non_null(strstr(alone.err, "no display was found"));
  program_result_free(&alone);
  assert_null(opened_address(5));

  // a display without xdg-open is said as well
  setenv("DISPLAY", ":99", 1);
  setenv("PATH", folder, 1);
  program_result lone = thrum_run(beside, "view", "../beam.npz", NULL);
  assert_int_equal(lone.exit_code, 0);
  assert_non_null(strstr(lone.err, "there is no xdg-open"));
  program_result_free(&lone);
  setenv("PATH", path, 1);

  // the blank of the folder is escaped in the address
  setenv("DISPLAY", ":99", 1);
  program_result run = thrum_run(beside, "view", "../beam.npz", "--json", NULL);
  setenv("PATH", before, 1);
  unsetenv("DISPLAY");

  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  char *opened = opened_address(100);

  snprintf(url, sizeof url, "file://%s/a%%20b/thrum_view.html", folder);
  assert_string_equal(cJSON_GetObjectItem(object, "file")->valuestring, "thrum_view.html");
  assert_string_equal(cJSON_GetObjectItem(object, "url")->valuestring, url);
  assert_non_null(opened);
  assert_string_equal(opened, url);
  assert_true(file_exists(in_folder("a b/thrum_view.html")));

  free(opened);
  cJSON_Delete(object);
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_pack_holds_the_model_bit_for_bit),
      cmocka_unit_test(a_pack_shows_the_surface_of_the_mesh),
      cmocka_unit_test(several_models_share_a_pack),
      cmocka_unit_test(a_scene_file_is_packed_with_its_models),
      cmocka_unit_test(links_and_coupled_bodies_are_packed_ready),
      cmocka_unit_test(a_body_is_shown_by_its_own_surface),
      cmocka_unit_test(a_run_is_packed_with_its_rows),
      cmocka_unit_test(a_run_is_shown_from_any_folder),
      cmocka_unit_test(a_curve_is_packed_with_its_motions),
      cmocka_unit_test(flow_is_left_out_where_the_page_steps),

      // the browser, and what is refused
      cmocka_unit_test(without_a_name_the_page_is_opened_where_there_is_a_display),
      cmocka_unit_test(missing_inputs_and_wrong_options_are_refused),
      cmocka_unit_test(a_run_whose_coordinates_are_of_another_run_is_refused),
      cmocka_unit_test(a_curve_whose_files_do_not_go_together_is_refused),
      cmocka_unit_test(a_page_without_a_place_for_a_pack_is_refused),
  };
  return cmocka_run_group_tests(tests, make_model, remove_model);
}
