/* Each key of a scene that names vertices takes a group, vertex=N, a place and all, and means by
 * each what the C interface means by the list of these vertices. SPDX-License-Identifier:
 * Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "driver/scene/scene_run.h"
#include "driver/scene/scene_run_build.h"
#include "io/file.h"
#include "tests/support/scene_call.h"
#include "tests/support/test_folder.h"

enum { FORMS = 6 };

/* What a file says of the vertices of a side; NULL: nothing. */
static const char *const forms[FORMS] = {
    NULL, "all", "vertex=5", "right", "near:0.41,0.1,0.1", "x>0.3&z<=0"};

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  program_result run = thrum_run(folder, "precompute", "beam:4x2x2@0.4x0.1x0.1", "--order", "1",
                                 "-o", "bar.npz", "--modes", "4", "--rank", "8", "-q", NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

/* Two free bars, one turned and with further keys, and what else the scene has. */
static void open_scene(const char *keys, const char *more, const scene_request *request,
                       scene_run *run) {
  char text[1200];
  snprintf(text, sizeof text,
           "{\"time\": 0.002, \"dt\": 0.001, \"collide\": false, \"bodies\": [\n"
           "{\"name\": \"a\", \"model\": \"bar.npz\", \"free\": true},\n"
           "{\"name\": \"b\", \"model\": \"bar.npz\", \"free\": true,"
           " \"position\": [1, 0.2, 0.3], \"rotation\": [0, 0, 1, 30]%s}]%s}\n",
           keys, more);
  assert_true(text_file_write(request->path, text));
  thrum_error error = {0};
  *run = (scene_run){.request = request};
  if (scene_run_read(run, &error) < 0 || scene_run_build(run, &error) < 0)
    fail_msg("%s: %s", text, error.message);
}

/* Is vertex v one of those that the form means? */
static bool is_meant(const thrum_model *model, const char *form, int64_t v) {
  const double *x = model->vertices + 3 * v, tiny = 1e-9;
  if (strcmp(form, "vertex=5") == 0)
    return v == 4;
  if (strcmp(form, "near:0.41,0.1,0.1") == 0)
    return fabs(x[0] - 0.4) < tiny && fabs(x[1] - 0.05) < tiny && fabs(x[2] - 0.05) < tiny;
  if (strcmp(form, "x>0.3&z<=0") == 0)
    return x[0] > 0.3 && x[2] <= 0;
  return strcmp(form, "all") == 0 || x[0] > 0.4 - tiny;
}

/* The list of vertices that a form means; NULL: none is given. The caller frees it. */
static int32_t *list_of(const thrum_model *model, const char *form, int64_t *count) {
  *count = 0;
  if (form == NULL)
    return NULL;
  int32_t *list = malloc((size_t)model->vertex_count * sizeof *list);
  assert_non_null(list);
  for (int64_t v = 0; v < model->vertex_count; v++)
    if (is_meant(model, form, v))
      list[(*count)++] = (int32_t)v;
  return list;
}

/* Both ends of a link, as the file ties it and as a call does. */
static void compare_link(const char *kind, const char *at, const char *other_at, bool placed) {
  char more[400], target[40] = "", other[40] = "";
  if (at != NULL)
    snprintf(target, sizeof target, ", \"at\": \"%s\"", at);
  if (other_at != NULL)
    snprintf(other, sizeof other, ", \"other_at\": \"%s\"", other_at);
  const bool spring = strcmp(kind, "spring") == 0;
  snprintf(more, sizeof more,
           ", \"links\": [{\"kind\": \"%s\", \"body\": \"a\", \"other\": \"b\"%s%s%s%s}]", kind,
           target, other, placed ? ", \"place\": [0.5, 0.1, 0.2]" : "",
           spring ? ", \"stiffness\": 10" : "");
  const scene_request request = {.path = in_folder("links.json"), .quiet = true};
  scene_run run;
  open_scene("", more, &request, &run);

  // the same link once more, with the lists of its vertices
  const thrum_model *model = run.bodies[0].model;
  thrum_scene_link_def def = thrum_default_scene_link_def();
  int32_t *vertices = list_of(model, at, &def.count);
  int32_t *others = list_of(model, other_at, &def.other_count);
  def.kind = spring ? THRUM_LINK_SPRING : THRUM_LINK_BALL;
  def.other = 1;
  def.vertices = vertices;
  def.other_vertices = others;
  def.stiffness = spring ? 10 : 0;
  for (int axis = 0; axis < 3 && placed; axis++)
    def.place[axis] = (const double[]){0.5, 0.1, 0.2}[axis];
  MUST(thrum_scene_add_link(run.scene, &def, NULL, &failure));
  free(vertices);
  free(others);

  // the two say the same
  thrum_scene_link link[2];
  for (int32_t n = 0; n < 2; n++)
    MUST(thrum_scene_link_get(run.scene, n, &link[n], &failure));
  if (memcmp(link[0].places, link[1].places, sizeof link[0].places) != 0)
    fail_msg("a %s at %s of %s and %s%s: its other end is at x = %g in the file, %g in the call",
             kind, at ? at : "nothing", "a", other_at ? other_at : "nothing",
             placed ? ", placed" : "", link[0].places[1][0], link[1].places[1][0]);
  scene_run_close(&run);
}

static void links_are_where_their_targets_are(void **state) {
  (void)state;
  for (int n = 0; n < FORMS; n++)
    for (int other = 0; other < FORMS; other++)
      for (int placed = 0; placed < 2; placed++) {
        // a link needs one of both
        if (forms[n] == NULL && !placed)
          continue;
        compare_link("spring", forms[n], forms[other], placed);
        compare_link("ball", forms[n], forms[other], placed);
      }
}

/* The mean of the middles of the vertices that a form means, in the world. */
static void middle_of(thrum_scene *scene, const thrum_model *model, const char *form,
                      double mean[3]) {
  int64_t count = 0;
  int32_t *list = list_of(model, form, &count);
  memset(mean, 0, 3 * sizeof *mean);
  for (int64_t n = 0; n < count; n++) {
    double place[3];
    MUST(thrum_scene_body_vertex(scene, 1, list[n], place, NULL, &failure));
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += place[axis] / (double)count;
  }
  free(list);
}

static void probes_are_the_mean_of_their_targets(void **state) {
  (void)state;
  for (int n = 1; n < FORMS; n++) {
    char more[200];
    double place[3], mean[3];
    snprintf(more, sizeof more, ", \"probes\": [{\"body\": \"b\", \"at\": \"%s\"}]", forms[n]);
    const scene_request request = {.path = in_folder("probes.json"), .quiet = true};
    scene_run run;
    open_scene("", more, &request, &run);
    MUST(thrum_scene_probe_get(run.scene, 0, place, NULL, &failure));
    middle_of(run.scene, run.bodies[1].model, forms[n], mean);
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs(place[axis] - mean[axis]) < 1e-12);
    scene_run_close(&run);
  }
}

/* The load of a force in the file is that of the call. */
static void forces_act_on_their_targets(void **state) {
  (void)state;
  for (int n = 1; n < FORMS; n++) {
    char keys[200];
    snprintf(keys, sizeof keys, ", \"loads\": [\"constant:0,2,3@%s\"]", forms[n]);
    const scene_request request = {.path = in_folder("loads.json"), .quiet = true};
    scene_run run;
    open_scene(keys, "", &request, &run);

    // the same once more
    thrum_scene_load_def load = {.cookie = sizeof load,
                                 .kind = THRUM_SCENE_FORCE,
                                 .vector = {0, 2, 3},
                                 .course = {.shape = THRUM_LOAD_CONSTANT, .until = INFINITY}};
    int32_t *list = list_of(run.bodies[1].model, forms[n], &load.count);
    load.vertices = list;
    MUST(thrum_scene_add_load(run.scene, 1, &load, &failure));
    free(list);

    // of a free body a load has a part for each axis of the body and of the world
    thrum_scene_load_def in[2];
    const int64_t last = thrum_scene_load_count(run.scene, 1) - 1;
    for (int k = 0; k < 2; k++)
      MUST(thrum_scene_load_get(run.scene, 1, last - 1 + k, &in[k], &failure));
    for (int64_t i = 0; i < 9 * run.bodies[1].model->rank; i++)
      assert_true(fabs(in[0].parts[i] - in[1].parts[i]) <= 1e-12);
    for (int i = 0; i < 9; i++)
      assert_true(fabs(in[0].moments[i] - in[1].moments[i]) <= 1e-12);
    scene_run_close(&run);
  }
}

/* As many vertices of a bar of 45, 42 of them on its surface, may touch a floor as "touch" names.
 */
static void what_may_touch_is_what_the_key_names(void **state) {
  (void)state;
  static const struct {
    const char *form;
    int64_t count;
  } cases[] = {{"surface", 42}, {"all", 45}, {"right", 9}, {"vertex=5", 1}, {"none", 0}};
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char keys[200];
    snprintf(keys, sizeof keys, ", \"touch\": \"%s\"", cases[n].form);
    const scene_request request = {.path = in_folder("touch.json"), .quiet = true};
    scene_run run;
    open_scene(keys, ", \"obstacles\": [{\"shape\": \"plane\", \"centre\": [0, 0, -1]}]", &request,
               &run);
    assert_int_equal(run.bodies[1].def.touch_count, cases[n].count);
    scene_run_close(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(links_are_where_their_targets_are),
      cmocka_unit_test(probes_are_the_mean_of_their_targets),
      cmocka_unit_test(forces_act_on_their_targets),
      cmocka_unit_test(what_may_touch_is_what_the_key_names),
  };
  return cmocka_run_group_tests(tests, make_model, remove_folder);
}
