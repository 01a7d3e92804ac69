/* Scene files as the command line takes them: a body of a scene runs as it does alone, a mistake is
 * named by file, line and path, and the run's folder is whole or not there.
 * SPDX-License-Identifier: Apache-2.0 */
#include <dirent.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "io/file.h"
#include "io/npy_file.h"
#include "tests/support/sanitized.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

#define SCENES THRUM_TEST_DATA "/../../examples/scenes"

static void put(const char *name, const char *text) {
  assert_true(text_file_write(in_folder(name), text));
}

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !precompute_beam("8x2x2@1x0.1x0.1", "5", "10"))
    return -1;

  // a second model that nothing holds, and a base motion
  program_result run = thrum_run(folder, "precompute", "beam:3x2x2@0.3x0.2x0.2,split=6", "--order",
                                 "1", "-o", "free.npz", "--modes", "4", "--rank", "8", "-q", NULL);
  put("quake.csv", "0,0,0,0\n0.1,1,0,0.5\n0.2,0,0,0\n");

  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

/* Runs the scene in `text` into `out`; the exit code must be `code`. */
static cJSON *simulate(const char *text, const char *out, int code) {
  put("scene.json", text);
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", out, "--json", "-q", NULL);
  if (run.exit_code != code)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  program_result_free(&run);
  return object;
}

static void assert_same_file(const char *left, const char *right) {
  char command[500];
  snprintf(command, sizeof command, "cmp -s %s %s", in_folder(left), in_folder(right));
  if (system(command) != 0)
    fail_msg("%s and %s differ", left, right);
}

/* The glTF file has the bodies one, two and three in their places, two at y = 2 in its colour. */
static void expect_bodies_in(const char *name) {
  void *bytes = NULL;
  size_t size = 0;
  assert_true(thrum_file_read(in_folder(name), &bytes, &size, NULL) >= 0);
  uint32_t length = 0;
  memcpy(&length, (char *)bytes + 12, sizeof length);
  cJSON *file = cJSON_ParseWithLength((char *)bytes + 20, length);
  free(bytes);

  // the first node is the one that turns all
  static const char *const names[] = {"one", "two", "three"};
  const cJSON *nodes = cJSON_GetObjectItem(file, "nodes");
  assert_int_equal(cJSON_GetArraySize(nodes), 4);
  for (int n = 0; n < 3; n++) {
    const cJSON *node = cJSON_GetArrayItem(nodes, n + 1);
    const cJSON *place = cJSON_GetObjectItem(node, "translation");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(node, "name")), names[n]);
    assert_true(cJSON_GetArrayItem(place, 1)->valuedouble == 2 * n);
    assert_int_equal(cJSON_GetObjectItem(node, "mesh")->valueint, n);
  }

  // #ff8000 of sRGB in the linear scale: 1, 0.2158605, 0
  const cJSON *material = cJSON_GetArrayItem(cJSON_GetObjectItem(file, "materials"), 1);
  const cJSON *colour =
      cJSON_GetObjectItem(cJSON_GetObjectItem(material, "pbrMetallicRoughness"), "baseColorFactor");
  static const double linear[] = {1, 0.2158605, 0, 1};
  for (int n = 0; n < 4; n++)
    assert_true(fabs(cJSON_GetArrayItem(colour, n)->valuedouble - linear[n]) < 1e-6);
  cJSON_Delete(file);
}

/* What follows is summed in another order in a scene. */
static void expect_near_rows(const char *name, const char *other) {
  double *values[2] = {NULL, NULL};
  int64_t rows[2], columns[2];
  const char *const names[] = {name, other};
  for (int n = 0; n < 2; n++)
    assert_int_equal(
        thrum_npy_read_f8(in_folder(names[n]), &values[n], &rows[n], &columns[n], NULL), 0);
  assert_true(rows[0] == rows[1] && columns[0] == columns[1]);
  for (int64_t k = 0; k < rows[0] * columns[0]; k++)
    assert_true(fabs(values[0][k] - values[1][k]) < 1e-15);
  free(values[0]);
  free(values[1]);
}

static void a_body_of_a_scene_has_the_run_of_it_alone(void **state) {
  (void)state;

  // three bodies of one model that differ in loads, rank, integrator and damping
  cJSON *object = simulate(
      "{\"time\": 0.6, \"gravity\": [0, 0.5, -9.81], \"damping\": [0.4, 0.0005],\n"
      " \"base_motion\": \"quake.csv\",\n"
      " \"bodies\": [\n"
      "  {\"name\": \"one\", \"model\": \"beam.npz\", \"loads\": [\"sine:0,0,-4@tip,f=3\",\n"
      "   \"traction:0,0,-50@top,until=0.2\"], \"start\": \"mode:2,0.01\"},\n"
      "  {\"name\": \"two\", \"model\": \"beam.npz\", \"rank\": 6,\n"
      "   \"colour\": \"#ff8000\", \"integrator\": \"newmark\", \"damping\": 0, \"position\": [0, "
      "2, 0]},\n"
      "  {\"name\": \"three\", \"model\": \"beam.npz\", \"position\": [0, 4, 0]}],\n"
      " \"outputs\": {\"accept_error\": \"100%\"}}",
      "together", 0);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "bodies")), 3);
  assert_true(json_value(object, "steps") == 200);
  cJSON_Delete(object);

  // the first body alone has the same bytes in each file
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "alone", "--time", "0.6", "--damping",
                "0.4,0.0005", "--load", "gravity:0,0.5,-9.81", "--load", "sine:0,0,-4@tip,f=3",
                "--load", "traction:0,0,-50@top,until=0.2", "--base-motion", "quake.csv", "--start",
                "mode:2,0.01", "--accept-error", "100%", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_same_file("together/one/q.npy", "alone/q.npy");
  assert_same_file("together/one/energy.csv", "alone/energy.csv");
  assert_same_file("together/one/end.npy", "alone/end.npy");

  // the second one too, with the options that the scene gives to it
  run = thrum_run(folder, "simulate", "beam.npz", "-o", "lower", "--time", "0.6", "--rank", "6",
                  "--integrator", "newmark", "--load", "gravity:0,0.5,-9.81", "--base-motion",
                  "quake.csv", "-q", "--accept-error", "100%", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  assert_same_file("together/two/energy.csv", "lower/energy.csv");
  expect_near_rows("together/two/q.npy", "lower/q.npy");

  // the folder of a body is a run that other commands read
  run = thrum_run(folder, "export", "together/two", "--glb", "two.glb", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // the whole scene leaves as one file, and by nothing that is of one body
  run = thrum_run(folder, "export", "together", "--glb", "all.glb", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  expect_bodies_in("all.glb");

  // nothing is written over what was read
  static const char *const inputs[] = {"together/scene.json", "together/one/run.json",
                                       "together/two/q.npy", "beam.npz"};
  for (int n = 0; n < 4; n++) {
    run = thrum_run(folder, "export", "together", "--glb", inputs[n], NULL);
    assert_true(run.exit_code == 1 || run.exit_code == 2);
    assert_non_null(strstr(run.err, "write to another file"));
    program_result_free(&run);
  }

  // a name in scene.json leads to no other folder
  assert_int_equal(mkdir(in_folder("forged"), 0777), 0);
  static const char *const names[] = {"../together/one", "/tmp", "..", ""};
  for (int n = 0; n < 4; n++) {
    char text[200];
    snprintf(
        text, sizeof text,
        "{\"program\": \"thrum\", \"command\": \"simulate\", \"bodies\": [{\"name\": \"%s\"}]}",
        names[n]);
    assert_true(text_file_write(in_folder("forged/scene.json"), text));
    run = thrum_run(folder, "export", "forged", "--glb", "forged.glb", NULL);
    assert_int_equal(run.exit_code, 1);
    assert_non_null(strstr(run.err, "none of a folder in the run"));
    program_result_free(&run);
  }
  run = thrum_run(folder, "export", "together", "--glb", "all.glb", "--obj", "one.obj", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "together/NAME"));
  program_result_free(&run);
}

/* Reads the last row of probes.csv, without step and time. */
static void last_probes(const char *name, int count, double *values) {
  char *text = text_file_read(in_folder(name));
  assert_non_null(text);

  // find the start of the last line
  char *line = text + strlen(text) - 1;
  while (line > text && line[-1] != '\n')
    line--;

  // pass over the step and the time
  strtod(line, &line);
  strtod(line + 1, &line);
  for (int n = 0; n < count; n++)
    values[n] = strtod(line + 1, &line);

  free(text);
}

static void a_turned_and_scaled_body_follows_its_world(void **state) {
  (void)state;

  // a quarter turn about z takes x to y, y to -x; twice as long, four times as stiff: the same time
  cJSON *object = simulate(
      "{\"time\": 0.3, \"bodies\": [\n"
      " {\"name\": \"a\", \"model\": \"beam.npz\", \"loads\": \"constant:0,3,-2@tip\"},\n"
      " {\"name\": \"b\", \"model\": \"beam.npz\", \"position\": [1, 2, 3], \"scale\": 2,\n"
      "  \"stiffness\": 4, \"rotation\": {\"axis\": [0, 0, 2], \"angle\": 90},\n"
      "  \"loads\": \"constant:-48,0,-32@tip\"}],\n"
      " \"probes\": [{\"name\": \"a\", \"body\": \"a\", \"at\": \"tip\"},\n"
      "  {\"name\": \"b\", \"body\": \"b\", \"at\": \"tip\"}]}",
      "turned", 0);
  cJSON_Delete(object);

  double x[12];
  last_probes("turned/probes.csv", 12, x);

  // forces go as stiffness times length squared, so the second body moves as the first, turned
  assert_true(fabs(x[6] - (1 - 2 * x[1])) < 1e-7);
  assert_true(fabs(x[7] - (2 + 2 * x[0])) < 1e-7);
  assert_true(fabs(x[8] - (3 + 2 * x[2])) < 1e-7);
  assert_true(fabs(x[9] + 2 * x[4]) < 1e-5);
  assert_true(fabs(x[11] - 2 * x[5]) < 1e-5);
}

static void a_free_body_drops_on_the_floor_of_the_scene(void **state) {
  (void)state;
  cJSON *object =
      simulate("{\"dt\": 0.002, \"time\": 3, \"gravity\": [0, 0, -9.81], \"damping\": 5,\n"
               " \"bodies\": [{\"name\": \"block\", \"model\": \"free.npz\", \"free\": true,\n"
               "  \"position\": [0, 0, 0.2], \"velocity\": [0.5, 0, 0]}],\n"
               " \"obstacles\": [{\"shape\": \"plane\", \"friction\": 0.8}],\n"
               " \"probes\": [{\"name\": \"all\", \"body\": \"block\", \"at\": \"all\"}]}",
               "drop", 0);
  cJSON_Delete(object);

  double x[6];
  last_probes("drop/probes.csv", 6, x);

  // it lies on the floor, and friction has stopped it after some way
  assert_true(fabs(x[2] - 0.1) < 3e-3);
  assert_true(x[0] > 0.15 && fabs(x[3]) < 1e-3);

  // the contact still acts, and has taken energy out
  char *text = text_file_read(in_folder("drop/block/run.json"));
  cJSON *run = cJSON_Parse(text);
  assert_true(json_value(cJSON_GetObjectItem(run, "contact"), "touching") > 0);
  assert_true(json_value(cJSON_GetObjectItem(run, "contact"), "lost_j") > 0);

  cJSON_Delete(run);
  free(text);
}

/* Gravity works on the fall of a free body, whose energy therefore grows; that flags nothing. */
static void a_body_that_falls_freely_is_done(void **state) {
  (void)state;
  cJSON *object = simulate("{\"time\": 0.5, \"gravity\": [0, 0, -9.81], \"damping\": 0.3,\n"
                           " \"bodies\": [{\"name\": \"block\", \"model\": \"free.npz\",\n"
                           " \"free\": true, \"spin\": [2, 3, 4]}]}",
                           "fall", 0);

  const cJSON *body = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), 0);
  assert_string_equal(cJSON_GetObjectItem(body, "status")->valuestring, "done");
  assert_true(json_value(body, "energy_last_j") > 2 * json_value(body, "energy_first_j"));
  cJSON_Delete(object);
}

static void a_mistake_is_named_by_file_line_and_path(void **state) {
  (void)state;
#define BODY "{\"name\": \"a\", \"model\": \"beam.npz\""
  static const struct {
    const char *text, *message;
  } mistakes[] = {
      {"[]", "scene.json:1: a scene stands in { }"},
      {"{\"dt\": 0.01}", "scene.json:1: the key \"bodies\" is missing"},
      {"{\n\"bodies\": []}", "scene.json:2: bodies: a scene needs a body"},
      {"{\"bodies\": {}}", "scene.json:1: bodies: wants a list of objects in [ ], not an object"},
      {"{\"bodies\": [3]}", "scene.json:1: bodies[0]: wants an object"},
      {"{\"bodies\": [{}]}", "scene.json:1: bodies[0]: the key \"model\" is missing"},
      {"{\n\"bodys\": []}",
       "scene.json:2: the file has no key \"bodys\"; did you mean \"bodies\"?"},
      {"{\"bodies\": [" BODY ",\n\"rnak\": 3}]}",
       "scene.json:2: bodies[0] has no key \"rnak\"; did you mean \"rank\"?"},
      {"{\"bodies\": [" BODY ",\n\"zzz\": 3}]}",
       "scene.json:2: bodies[0] has no key \"zzz\"; its keys: name, model, "},
      {"{\"bodies\": [" BODY ",\n\"damping_ratio\": 0.01}]}",
       "scene.json:2: \"damping_ratio\" is of the modes of one model"},
      {"{\"bodies\": [" BODY ",\n\n\"rank\": 40}]}",
       "scene.json:3: bodies[0].rank: rank 40 is asked for; the model has 1 to 10"},
      {"{\"bodies\": [" BODY ",\n\"surface\": \"nothere.obj\"}]}",
       "scene.json:2: bodies[0].surface: "},
      {"{\"bodies\": [" BODY ",\n\"rank\": 2.5}]}",
       "scene.json:2: bodies[0].rank: wants a whole number from 1 to 512, not 2.5"},
      {"{\"bodies\": [" BODY ",\n\"scale\": 0}]}",
       "scene.json:2: bodies[0].scale: wants a number above 0, not 0"},
      {"{\"bodies\": [" BODY ",\n\"position\": [1, 2]}]}",
       "scene.json:2: bodies[0].position: wants a list of three numbers of m, not [1,2]"},
      {"{\"bodies\": [" BODY ",\n\"position\": [1e400, 0, 0]}]}",
       "scene.json:2: bodies[0].position: wants a list of three numbers of m, not [1e400,0,0]"},
      {"{\"bodies\": [" BODY ",\n\"position\": [1, \"a\", 0]}]}",
       "scene.json:2: bodies[0].position: wants a list of three numbers of m, not a list"},
      {"{\"bodies\": [" BODY ",\n\"rotation\": {\"axis\": [0,0,0], \"angle\": 3}}]}",
       "scene.json:2: bodies[0].rotation: wants"},
      {"{\"bodies\": [{\"model\": \"beam.npz\",\n\"name\": \"probes.csv\"}]}",
       "scene.json:2: bodies[0].name: \"probes.csv\" is a file of the run"},
      {"{\"bodies\": [" BODY ",\n\"touch\": \"sole\"}]}",
       "scene.json:2: bodies[0].touch: no group 'sole'"},
      {"{\"bodies\": [" BODY ",\n\"colour\": \"red\"}]}",
       "scene.json:2: bodies[0].colour: wants \"#rrggbb\""},
      {"{\"bodies\": [" BODY ",\n\"integrator\": \"imexw\"}]}",
       "scene.json:2: bodies[0].integrator: wants imexv, newmark"},
      {"{\"bodies\": [" BODY ",\n\"loads\": [\"constant:0,0,1@tip\",\n\"sine:0,0,1@tip\"]}]}",
       "scene.json:3: bodies[0].loads[1]: 'sine:0,0,1@tip': "},
      {"{\"bodies\": [" BODY ",\n\"loads\": \"constant:0,0,1@tap\"}]}",
       "scene.json:2: bodies[0].loads: no group 'tap'"},
      {"{\"bodies\": [" BODY ",\n\"start\": \"mode:99,1\"}]}", "scene.json:2: bodies[0].start: "},
      {"{\"bodies\": [" BODY ",\n\"split\": 3}]}",
       "scene.json:2: bodies[0].split: is of imexv, and energy steps"},
      {"{\"split_form\": \"thesis\",\n\"bodies\": [" BODY "}]}",
       "scene.json:1: split_form: is of imexv, and energy steps"},
      {"{\"bodies\": [" BODY ",\n\"fix\": \"left\"}]}",
       "scene.json:2: bodies[0].fix: is of a mesh"},
      {"{\"bodies\": [" BODY ",\n\"free\": true}]}",
       "scene.json:1: bodies[0]: a free body needs a model that nothing holds"},
      {"{\"bodies\": [" BODY ",\n\"velocity\": [0,0,0]}]}",
       "scene.json:2: bodies[0].velocity: is of a body that is free"},
      {"{\"bodies\": [" BODY ", \"self_contact\": true,\n\"condense\": 2}]}",
       "scene.json:2: bodies[0].condense: is not of a body with \"self_contact\""},
      {"{\"bodies\": [" BODY "},\n{\"name\": \"a\", \"model\": \"beam.npz\"}]}",
       "scene.json:2: bodies[1].name: \"a\" is there twice"},
      {"{\"bodies\": [{\"model\": \"beam.npz\",\n\"name\": \"../x\"}]}",
       "scene.json:2: bodies[0].name: wants letters"},
      {"{\"bodies\": [{\"name\": \"a\",\n\"model\": \"none.npz\"}]}",
       "scene.json:2: bodies[0].model: "},
      {"{\"bodies\": [" BODY "}],\n\"dt\": \"0.01\"}",
       "scene.json:2: dt: wants a number above 0 s"},
      {"{\"bodies\": [" BODY "}],\n\"time\": 1e30}", "scene.json:2: time: 1e+30 s at a dt of"},
      {"{\"bodies\": [" BODY "}],\n\"base_motion\": [\"sine:1,0,0\"]}",
       "scene.json:2: base_motion[0]: "},
      {"{\"bodies\": [" BODY "}],\n\"wind\": {\"drag\": 1}}",
       "scene.json:2: wind: the key \"velocity\" is missing"},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"ball\"}]}",
       "scene.json:2: obstacles[0].shape: wants plane, sphere, box, cylinder, capsule, "
       "height_field or mesh, not \"ball\""},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"sphere\"}]}",
       "scene.json:2: obstacles[0]: a sphere needs \"radius\""},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"plane\",\n\"size\": [1,1,1]}]}",
       "scene.json:3: obstacles[0].size: is of a box"},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"plane\",\n\"path\": []}]}",
       "scene.json:3: obstacles[0].path: is of a box that is solid"},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"mesh\",\n\"file\": \"no.obj\"}]}",
       "scene.json:3: obstacles[0].file: "},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"height_field\",\n"
       "\"heights\": [[0, 1], [2]], \"spacing\": 1}]}",
       "scene.json:3: obstacles[0].heights: row 2 has 1 numbers, the first 2"},
      {"{\"bodies\": [{\"name\": \"low\", \"model\": \"free.npz\", \"free\": true,\n"
       "\"position\": [0.5, 0.5, -0.03]}], \"obstacles\": [{\"shape\": \"height_field\", "
       "\"heights\": [[0, 0, 0], [0, 0, 0], [0, 0, 0]], \"spacing\": 0.5}]}",
       "scene.json:2: bodies[0].position: puts \"low\" 0.03 m deep into obstacles[0]"},
      {"{\"bodies\": [" BODY "}],\n\"obstacles\": [{\"shape\": \"box\", \"size\": [1, 1, 1], "
       "\"path\": [{\"time\": 1, \"centre\": [0, 0, 9]},\n{\"time\": 1, \"centre\": [0, 0, 8]}]}]}",
       "scene.json:3: obstacles[0].path[1].time: must be after the 1 s before it"},
      {"{\"bodies\": [" BODY "}],\n\"probes\": [{\"body\": \"b\", \"at\": \"tip\"}]}",
       "scene.json:2: probes[0].body: there is no body \"b\""},
      {"{\"bodies\": [" BODY "}],\n\"probes\": [{\"body\": \"a\", \"at\": \"vertex=999\"}]}",
       "scene.json:2: probes[0].at: the model has vertices 1 to"},
      {"{\"bodies\": [" BODY "}],\n\"links\": [{\"kind\": \"rope\"}]}",
       "scene.json:2: links[0].kind: wants spring, ball, hinge or weld, not \"rope\""},
      {"{\"bodies\": [" BODY "}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\"}]}",
       "scene.json:2: links[0]: a link needs \"at\" or \"place\""},
      {"{\"bodies\": [" BODY
       "}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\", \"at\": \"tip\",\n"
       "\"other\": \"b\"}]}",
       "scene.json:3: links[0].other: there is no body \"b\""},
      {"{\"bodies\": [" BODY
       "}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\", \"at\": \"tip\",\n"
       "\"stiffness\": 3}]}",
       "scene.json:3: links[0].stiffness: is of a spring"},
      {"{\"bodies\": [" BODY
       "}],\n\"links\": [{\"kind\": \"spring\", \"body\": \"a\", \"at\": \"tip\"}]}",
       "scene.json:2: links[0]: a spring needs \"stiffness\" or \"damping\""},
      {"{\"bodies\": [" BODY
       "}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\",\n\"at\": \"tap\"}]}",
       "scene.json:3: links[0].at: no group 'tap'"},
      {"{\"bodies\": [" BODY
       ", \"condense\": 3}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\", "
       "\"at\": \"tip\"}]}",
       "scene.json:2: links[0]: body 'a' is condensed"},
      {"{\"bodies\": [" BODY
       ", \"error\": 0.1}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\", "
       "\"at\": \"tip\"}]}",
       "scene.json:2: links[0]: body \"a\" has \"error\", \"budget\" or \"detail\""},
      {"{\"bodies\": [" BODY
       "}],\n\"links\": [{\"kind\": \"ball\", \"body\": \"a\", \"at\": \"tip\",\n"
       "\"file\": \"none.csv\"}]}",
       "scene.json:3: links[0].file: "},
      {"{\"bodies\": [" BODY "}],\n\"time\": 1, \"dt\": 5}",
       "scene.json:2: dt: 5 s is longer than the whole run of 1 s"},
      {"{\"bodies\": [" BODY "}],\n\"outputs\": {\"frames\": -1}}",
       "scene.json:2: outputs.frames: wants frames a second"},
      {"{\"bodies\": [" BODY ",]}", "scene.json:1: "},
  };

  // each mistake gives one line, exit code 1, and nothing on standard output
  for (size_t n = 0; n < sizeof mistakes / sizeof mistakes[0]; n++) {
    put("scene.json", mistakes[n].text);
    program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "never", "-q", NULL);
    if (run.exit_code != 1 || strstr(run.err, mistakes[n].message) == NULL ||
        !line_count_is(run.err, 1) || run.out[0] != 0)
      fail_msg("%s: exit %d, '%s' and not '%s'", mistakes[n].text, run.exit_code, run.err,
               mistakes[n].message);
    program_result_free(&run);
  }

  assert_false(file_exists(in_folder("never")));
}

static void options_of_one_body_are_refused(void **state) {
  (void)state;
  put("scene.json", "{\"time\": 1, \"bodies\": [" BODY "}]}");
  program_result run =
      thrum_run(folder, "simulate", "scene.json", "-o", "never", "--load", "gravity:0,0,-1", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "'--load' is of a run of one model"));
  program_result_free(&run);

  // the time and the step may be given for the whole scene
  run = thrum_run(folder, "simulate", "scene.json", "-o", "short", "--time", "0.03", "--dt",
                  "0.001", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_true(json_value(object, "steps") == 30);
  cJSON_Delete(object);
  program_result_free(&run);
}

static int count_entries(const char *name) {
  DIR *entries = opendir(in_folder(name));
  assert_non_null(entries);
  int count = 0;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries))
    count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
  closedir(entries);
  return count;
}

static void an_earlier_run_is_replaced_and_other_files_stay(void **state) {
  (void)state;

  // a scene of two bodies and a probe, with files of the user put into its folders
  cJSON_Delete(simulate("{\"time\": 0.03, \"bodies\": [" BODY "},\n"
                        "{\"name\": \"b\", \"model\": \"beam.npz\"}],\n"
                        "\"probes\": [{\"body\": \"a\", \"at\": \"tip\"}]}",
                        "again", 0));
  assert_int_equal(count_entries("again"), 4);
  put("again/notes.txt", "mine");
  put("again/b/notes.txt", "mine");

  // a run of one model lies in the folder too
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", "again/own", "--time",
                                 "0.03", "--start", "mode:1,0.01", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // a run of a scene with one of the two bodies takes the place of the first
  cJSON_Delete(simulate("{\"time\": 0.06, \"bodies\": [" BODY "}]}", "again", 0));

  // the body that is gone leaves only the user's file, the probes go, the other run stays
  assert_true(file_exists(in_folder("again/a/run.json")));
  assert_true(file_exists(in_folder("again/notes.txt")));
  assert_true(file_exists(in_folder("again/b/notes.txt")));
  assert_false(file_exists(in_folder("again/b/run.json")));
  assert_false(file_exists(in_folder("again/probes.csv")));
  assert_true(file_exists(in_folder("again/own/run.json")));
  assert_int_equal(count_entries("again"), 5);

  // a folder that is no scene's run is refused
  put("scene.json", "{\"time\": 0.03, \"bodies\": [" BODY "}]}");
  run = thrum_run(folder, "simulate", "scene.json", "-o", "again/own", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  program_result_free(&run);
}

/* A run that cannot be written is refused before a mesh is made into a model for it. */
static void a_folder_that_cannot_be_written_to_is_refused_first(void **state) {
  (void)state;
  static const char mesh[] = "beam:2x2x2@1x1x1";
  char cache[200], *kept = getenv("XDG_CACHE_HOME");
  char *before = kept != NULL ? strdup(kept) : NULL;

  // a model that were made would be kept in the cache folder
  put("taken", "a file");
  put("scene.json",
      "{\"bodies\": [{\"name\": \"a\", \"model\": \"beam:2x2x2@1x1x1\", \"free\": true}]}");
  assert_int_equal(setenv("XDG_CACHE_HOME", in_folder("cache"), 1), 0);

  // a file in place of the folder, and a folder whose parent does not exist
  static const char *const outputs[][2] = {{"taken", "taken: is a file; -o names the folder"},
                                           {"nowhere/run", "nowhere/run: cannot be created"}};
  for (int n = 0; n < 4; n++) {
    const char *output = outputs[n / 2][0];
    program_result run =
        n % 2 == 0
            ? thrum_run(folder, "simulate", "scene.json", "-o", output, NULL)
            : thrum_run(folder, "simulate", mesh, "--full", "--fix", "x<0.1", "-o", output, NULL);
    if (run.exit_code != 1 || strstr(run.err, outputs[n / 2][1]) == NULL)
      fail_msg("exit %d, '%s' and not '%s'", run.exit_code, run.err, outputs[n / 2][1]);
    program_result_free(&run);
  }

  if (before != NULL)
    setenv("XDG_CACHE_HOME", before, 1);
  else
    unsetenv("XDG_CACHE_HOME");
  free(before);

  // neither model was made, and no folder
  assert_false(file_exists(cache));
  assert_false(file_exists(in_folder("nowhere")));
}

static void frames_stand_where_the_bodies_are(void **state) {
  (void)state;
  cJSON_Delete(simulate("{\"time\": 0.06, \"bodies\": [" BODY ", \"position\": [0, 0, 7],\n"
                        "\"start\": \"mode:1,0.01\"}],\n"
                        "\"outputs\": {\"frames\": \"every-10\", \"stress\": true, "
                        "\"record_every\": 5}}",
                        "frames", 0));
  assert_true(file_exists(in_folder("frames/a/frames.pvd")));
  assert_true(file_exists(in_folder("frames/a/frames/frame_000002.vtu")));
  int64_t rows = 0;
  energy_row *energies = read_energies(in_folder("frames/a/energy.csv"), &rows);
  assert_non_null(energies);
  assert_int_equal(rows, 5);
  free(energies);
}

static void a_body_that_cannot_be_stepped_ends_the_run_and_flags_it(void **state) {
  (void)state;

  // one iteration cannot follow a large load, which begins after ten steps
  cJSON *object = simulate("{\"time\": 3, \"bodies\": [" BODY ", \"integrator\": \"newmark\",\n"
                           "\"fallback\": false, \"iterations\": 1, \"tolerance\": 1e-12,\n"
                           "\"loads\": \"constant:0,0,-1e5@tip,from=0.03\"},\n"
                           "{\"name\": \"still\", \"model\": \"beam.npz\"}]}",
                           "failed", 3);
  assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(object, "status")), "not_converged");

  const double steps = json_value(object, "steps");
  assert_true(steps >= 10 && steps < 1000);
  cJSON_Delete(object);

  // both bodies have the rows of the steps that were completed
  int64_t rows = 0, others = 0;
  energy_row *first = read_energies(in_folder("failed/a/energy.csv"), &rows);
  energy_row *second = read_energies(in_folder("failed/still/energy.csv"), &others);
  assert_true(first != NULL && second != NULL);
  assert_true(rows == (int64_t)steps + 1 && others == rows);

  free(first);
  free(second);
}

static void a_whole_turn_brings_a_free_body_back(void **state) {
  (void)state;

  // 180 degrees a second for 2 s
  cJSON_Delete(simulate("{\"dt\": 0.002, \"time\": 2, \"bodies\": [{\"name\": \"top\",\n"
                        "\"model\": \"free.npz\", \"free\": true, \"spin\": [0, 0, 180],\n"
                        "\"position\": [1, 2, 3], \"velocity\": [0, 0, 0.5]}],\n"
                        "\"probes\": [{\"body\": \"top\", \"at\": \"vertex=1\"}],\n"
                        "\"outputs\": {\"frames\": \"every-500\"}}",
                        "spun", 0));

  double x[6];
  last_probes("spun/probes.csv", 6, x);

  // vertex 1 is the corner at the mesh's origin, or one of that height
  assert_true(fabs(x[2] - 4) < 0.2 && fabs(x[5] - 0.5) < 1e-6);

  // the first and the last place of the vertex differ by the velocity times the time alone
  char command[400];
  snprintf(command, sizeof command,
           "awk -F, 'NR==2 {x=$3; y=$4; z=$5} END {d=($3-x)^2+($4-y)^2+($5-z-1)^2; "
           "exit !(d < 1e-6)}' %s/spun/probes.csv",
           folder);
  assert_int_equal(system(command), 0);
}

/* Asserts that each key of an object of the schema stands in the document. */
static void check_documented(const cJSON *schema, const char *document) {
  const cJSON *properties = cJSON_GetObjectItem(schema, "properties"), *key;
  cJSON_ArrayForEach(key, properties) {
    char written[80];
    snprintf(written, sizeof written, "| `%s` |", key->string);
    if (key->string[0] != '$' && strstr(document, written) == NULL)
      fail_msg("docs/reference/scene_keys.md does not say '%s'", written);
    check_documented(key, document);
    const cJSON *items = cJSON_GetObjectItem(key, "items");
    if (items != NULL)
      check_documented(items, document);
  }
}

static void the_schema_is_committed_and_every_key_is_documented(void **state) {
  (void)state;
  char *committed = text_file_read(THRUM_TEST_DATA "/../../docs/schema/scene.schema.json");
  char *document = text_file_read(THRUM_TEST_DATA "/../../docs/reference/scene_keys.md");
  program_result made = thrum_run(folder, "schema", "scene", NULL);
  assert_int_equal(made.exit_code, 0);
  assert_non_null(committed);
  assert_non_null(document);

  // when this fails, run: thrum schema scene > docs/schema/scene.schema.json
  assert_string_equal(committed, made.out);

  cJSON *schema = cJSON_Parse(made.out);
  assert_non_null(schema);
  check_documented(schema, document);

  cJSON_Delete(schema);
  free(committed);
  free(document);
  program_result_free(&made);
}

/* A scene that comes with Thrum, written into the folder with linear tetrahedra where what its
 * bodies are made of is not the question, and without the judgement of its bases, which takes
 * longer than its run. Returns its name. */
static const char *write_scene(const char *name, bool linear) {
  static char file[80];
  static const char key[] = "\"model\": \"", outputs[] = "\"outputs\": {";
  static const char judged_not[] = "\"judge\": \"off\", ";
  char path[300];
  snprintf(path, sizeof path, SCENES "/%s.json", name);
  snprintf(file, sizeof file, "copy_of_%s.json", name);
  char *text = text_file_read(path);
  FILE *out = fopen(in_folder(file), "w");
  assert_true(text != NULL && out != NULL);
  const char *asked = strstr(text, outputs), *from = text;
  if (asked == NULL) {
    fprintf(out, "{%s%s},", outputs, "\"judge\": \"off\"");
    from = strchr(text, '{') + 1;
  }

  // each place as it comes: a model, or what is written
  int bodies = 0;
  for (const char *at = from; *at != 0; at++) {
    const bool model = strncmp(at, key, strlen(key)) == 0;
    if (!model && at != asked)
      continue;
    const char *behind = at + strlen(model ? key : outputs);
    fprintf(out, "%.*s%s%.*s%s", (int)(at - from), from, model && linear ? "\"order\": 1, " : "",
            (int)(behind - at), at,
            !model                             ? judged_not
            : strncmp(behind, "beam:", 5) == 0 ? ""
                                               : SCENES "/");
    bodies += model;
    from = behind;
  }
  fputs(from, out);
  assert_true(bodies > 0 && fclose(out) == 0);
  free(text);
  return file;
}

static void the_scenes_that_come_with_thrum_run(void **state) {
  (void)state;

  // quake.json has a model that takes a minute to make: the test of the README runs it
  static const char *const scenes[] = {"drop", "integrators", "wind", "detail"};
  for (size_t n = LENGTH_OF_RUN(0, 2); n < sizeof scenes / sizeof scenes[0]; n++) {
    // files, models and keys are right, and no body moves as its model cannot
    char path[300];
    snprintf(path, sizeof path, SCENES "/%s.json", scenes[n]);
    program_result run = thrum_run(folder, "simulate", n == 1 ? write_scene(scenes[n], true) : path,
                                   "-o", scenes[n], "-q", NULL);
    if (run.exit_code != 0)
      fail_msg("%s: %s", scenes[n], run.err);

    // the line of files has the account where there is one
    snprintf(path, sizeof path, "%s/%s/account.csv", folder, scenes[n]);
    assert_true(file_exists(path) == (strstr(run.out, ", account.csv") != NULL));
    program_result_free(&run);
  }
}

/* The total energy of a scene without loads changes by what contact, obstacles and damping took and
 * gave, to rounding. */
static void check_account_adds_up(const cJSON *of) {
  const cJSON *obstacles = cJSON_GetObjectItem(of, "obstacles");
  const double first = json_value(cJSON_GetObjectItem(of, "first"), "total_j");
  const double last = json_value(cJSON_GetObjectItem(of, "last"), "total_j");
  const double lost = json_value(of, "lost_j") + json_value(obstacles, "lost_j");
  const double driven = json_value(of, "driven_j") + json_value(obstacles, "driven_j") +
                        json_value(obstacles, "granted_j");
  assert_true(json_value(obstacles, "lost_j") > 0);
  assert_true(json_value(obstacles, "touching") > 0);
  assert_true(fabs(first + driven - lost - json_value(of, "dissipated_j") - last) < 1e-9 * lost);
}

/* Bodies of the scenes that collide keep their distance: no touch is as deep as the thickness, and
 * contact gives no energy but what moving obstacles bring. */
static void what_touches_in_the_scenes_keeps_its_distance(void **state) {
  (void)state;
  static const char *const scenes[] = {"shapes", "collide"};
  for (int n = 0; n < LENGTH_OF_RUN(2, 1); n++) {
    char path[300];
    snprintf(path, sizeof path, SCENES "/%s.json", scenes[n]);
    program_result run = thrum_run(folder, "simulate", n == 1 ? write_scene(scenes[n], true) : path,
                                   "-o", scenes[n], "--threads", "2", "--json", "-q", NULL);
    if (run.exit_code != 0)
      fail_msg("%s: %s", path, run.err);

    cJSON *object = json_line(run.out);
    const cJSON *of = cJSON_GetObjectItem(object, "collisions");
    const double first = json_value(cJSON_GetObjectItem(of, "first"), "total_j");
    const double last = json_value(cJSON_GetObjectItem(of, "last"), "total_j");
    print_message("%s: deepest %.2f of the thickness, %.1f J lost\n", scenes[n],
                  json_value(of, "deepest_of_thickness"), json_value(of, "lost_j"));

    // something has touched, and nothing came through
    assert_true(json_value(of, "deepest_of_thickness") > 0);
    assert_true(json_value(of, "deepest_of_thickness") < 1);
    assert_true(json_value(of, "dropped_touches") == 0);
    assert_true(last - first <= json_value(of, "driven_j"));
    check_account_adds_up(of);
    cJSON_Delete(object);
    program_result_free(&run);
  }
}

/* A plate that lands on a pole rocks and lies still. It is struck while it rocks alone: where rows
 * are left out of the sweeps that have to bear, it is thrown up time and again, some 75 times in
 * place of 20 in the mean of these starts. */
static void a_plate_on_a_pole_is_not_thrown_up_again(void **state) {
  (void)state;
  double struck = 0;
  for (int n = 0; n < 5; n++) {
    char text[700];
    snprintf(text, sizeof text,
             "{\"time\": 0.7, \"dt\": 0.002, \"gravity\": [0, 0, -9.81], \"damping\": 1,\n"
             "\"bodies\": [{\"name\": \"plate\", \"model\": \"beam:6x6x1@0.6x0.6x0.03,split=6\", "
             "\"order\": 1,\n"
             "\"material\": {\"young\": 1e7}, \"free\": true, \"position\": [%.6f, 0, 0.47]}],\n"
             "\"obstacles\": [{\"name\": \"pole\", \"shape\": \"cylinder\", \"radius\": 0.08,\n"
             "\"height\": 0.4, \"centre\": [0, 0, 0.2], \"restitution\": 0.2}]}",
             -0.3 + 1e-6 * n);
    cJSON *object = simulate(text, "pole", 0);
    const cJSON *of = cJSON_GetObjectItem(object, "collisions");
    assert_true(json_value(of, "touching") > 0);
    assert_true(json_value(of, "deepest_of_thickness") < 1);
    struck += json_value(of, "impacts");
    cJSON_Delete(object);
  }

  // the starts differ by a millionth of a metre: single runs do not say much
  print_message("%.1f impacts in the mean\n", struck / 5);
  assert_true(struck > 0 && struck < 5 * 40);
}

/* A cube that tumbles over hills, which are a few triangles of its size, keeps its distance. Where
 * its places are sought by what held it in the step before, it comes up to twice the thickness into
 * them in four of twelve starts that differ by 0.1 mm. */
static void a_cube_that_tumbles_over_hills_keeps_its_distance(void **state) {
  (void)state;
  static const int starts[] = {2, 1, 6, 10};
  for (int n = 0; n < LENGTH_OF_RUN(4, 2); n++) {
    char text[1000];
    snprintf(text, sizeof text,
             "{\"time\": 1.2, \"dt\": 0.002, \"gravity\": [0, 0, -9.81], \"damping\": 1,\n"
             "\"bodies\": [{\"name\": \"cube\", \"model\": \"beam:3x3x3@0.2x0.2x0.2\", \"free\": "
             "true,\n"
             "\"material\": {\"young\": 1e6}, \"position\": [%.17g, 1.5, 0.5],\n"
             "\"rotation\": {\"axis\": [1, 1, 0], \"angle\": 30}}],\n"
             "\"outputs\": {\"accept_error\": \"100%%\", \"monitor\": false},\n"
             "\"obstacles\": [{\"name\": \"floor\", \"shape\": \"plane\", \"friction\": 0.6, "
             "\"restitution\": 0.3},\n"
             "{\"name\": \"hills\", \"shape\": \"height_field\", \"spacing\": 0.25, \"centre\": "
             "[1.5, 1.5, 0.05],\n"
             "\"restitution\": 0.2, \"heights\": [[0, 0.1, 0, 0.1, 0], [0.1, 0, 0.1, 0, 0.1],\n"
             "[0, 0.1, 0, 0.1, 0], [0.1, 0, 0.1, 0, 0.1], [0, 0.1, 0, 0.1, 0]]}]}",
             1.4 + 1e-4 * starts[n]);
    cJSON *object = simulate(text, "tumbles", 0);
    const cJSON *of = cJSON_GetObjectItem(object, "collisions");
    const double deepest = json_value(of, "deepest_of_thickness");
    print_message("start %d: deepest %.2f of the thickness\n", starts[n], deepest);
    assert_true(deepest > 0 && deepest < 0.9);
    cJSON_Delete(object);
  }
}

/* The scene of every law has a quarter of its bodies of each, and of one of them what flows. */
static void a_scene_has_bodies_of_every_law(void **state) {
  (void)state;
  static const char *const laws[] = {"stvk", "corotational", "neo-hookean"};
  program_result run = thrum_run(folder, "simulate", write_scene("laws", true), "-o", "laws",
                                 "--time", LENGTH_OF_RUN("0.1", "0.06"), "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *body = NULL;
  int counts[3] = {0}, flowed = 0;
  cJSON_ArrayForEach(body, cJSON_GetObjectItem(object, "bodies")) {
    for (int law = 0; law < 3; law++)
      counts[law] += strcmp(cJSON_GetObjectItem(body, "law")->valuestring, laws[law]) == 0;

    // only bodies that may flow lose energy by it
    const cJSON *work = cJSON_GetObjectItem(body, "plastic_work_j");
    const bool flows = cJSON_IsNumber(work) && work->valuedouble > 0;
    flowed += flows;
    assert_true(!flows ||
                strncmp(cJSON_GetObjectItem(body, "name")->valuestring, "plastic", 7) == 0);
  }
  assert_true(counts[0] == 25 && counts[1] == 50 && counts[2] == 25);
  assert_true(flowed > 0 && flowed <= 25);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* Joints of the scene that comes with Thrum stay closed, and the account has what links took and
 * what their ends did. */
static void a_scene_with_links_adds_up(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", write_scene("links", false), "-o", "linked",
                                 "--time", "0.6", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *links = cJSON_GetObjectItem(object, "links"), *link = NULL;
  double driven = 0, lost = 0;
  assert_int_equal(cJSON_GetArraySize(links), 4);
  cJSON_ArrayForEach(link, links) {
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(link, "holds")));
    assert_true(json_value(link, "largest_drift_m") < 1e-11);
    driven += json_value(link, "driven_j");
    lost += json_value(link, "lost_j");
  }

  // the handle does work, the spring takes some
  const cJSON *of = cJSON_GetObjectItem(object, "collisions");
  const double first = json_value(cJSON_GetObjectItem(of, "first"), "total_j");
  const double last = json_value(cJSON_GetObjectItem(of, "last"), "total_j");
  assert_true(driven > 0.1 && lost > 0.01);
  assert_true(fabs(first + driven - lost - last) < 1e-9 * driven);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* A stiff pendulum at a large step, whose joint cannot be closed: the run is flagged, and the
 * warning names the link. */
static void a_joint_that_stays_open_flags_the_run(void **state) {
  (void)state;
  put("scene.json", "{\"time\": 0.5, \"dt\": 0.05, \"bodies\": [\n"
                    " {\"name\": \"bar\", \"model\": \"beam:4x1x1@0.4x0.1x0.1\", \"free\": true,\n"
                    "  \"material\": {\"young\": 1e8, \"density\": 1000}}],\n"
                    " \"gravity\": [0, 0, -9.81], \"links\": [{\"name\": \"pivot\", \"kind\": "
                    "\"hinge\", \"axis\": [0, 1, 0], \"body\": \"bar\", \"place\": [0, 0, 0]}]}");
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "open", "--json", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "the joint of link 'pivot' was open by"));
  cJSON *object = json_line(run.out);
  assert_string_equal(cJSON_GetObjectItem(object, "status")->valuestring, "joints_open");
  cJSON_Delete(object);
  program_result_free(&run);
}

/* Forces of a link that grow without end stop the run, and the line says what to do. */
static void a_joint_that_no_step_can_follow_stops_the_run(void **state) {
  (void)state;
  put("scene.json", "{\"time\": 1, \"dt\": 0.2, \"bodies\": [\n"
                    " {\"name\": \"bar\", \"model\": \"beam:4x1x1@0.4x0.1x0.1\", \"free\": true,\n"
                    "  \"material\": {\"young\": 1e5, \"density\": 1000},\n"
                    "  \"velocity\": [0, 0, 3], \"spin\": [0, 9, 3]}],\n"
                    " \"gravity\": [0, 0, -9.81], \"links\": [{\"kind\": \"weld\", \"body\": "
                    "\"bar\", \"place\": [0, 0, 0]}]}");
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "apart", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.err, "use a shorter step"));
  program_result_free(&run);
}

static void a_handle_follows_a_file_and_lets_go(void **state) {
  (void)state;
  put("hand.csv", "t,x,y,z\n0,7,7,7\n0.1,7,7.02,7.03\n1,7,7.02,7.03\n");
#define PULLED(until)                                                                              \
  "{\"time\": 0.2, \"dt\": 0.002, \"bodies\": [{\"name\": \"a\", \"model\": \"beam.npz\"}],\n"     \
  " \"links\": [{\"kind\": \"ball\", \"body\": \"a\", \"at\": \"tip\", \"file\": "                 \
  "\"hand.csv\"" until "}],\n \"probes\": [{\"body\": \"a\", \"at\": \"tip\"}]}"

  // the tip goes as far as the file says, from where it is
  double held[6], free_again[6];
  cJSON_Delete(simulate(PULLED(""), "pulled", 0));
  last_probes("pulled/probes.csv", 6, held);
  assert_true(fabs(held[0] - 1) < 1e-9 && fabs(held[1] - 0.02) < 1e-9);
  assert_true(fabs(held[2] - 0.03) < 1e-9);

  // and springs back where it is let go
  cJSON *object = simulate(PULLED(", \"until\": 0.15"), "let_go", 0);
  last_probes("let_go/probes.csv", 6, free_again);
  assert_true(fabs(free_again[2] - 0.03) > 1e-3);
  const cJSON *link = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "links"), 0);
  assert_true(cJSON_IsFalse(cJSON_GetObjectItem(link, "holds")));
  cJSON_Delete(object);
}

/* Two cubes fall on the ground, one on the other: what contact.csv says of each adds up to the
 * weight above. */
static void the_forces_of_contact_are_in_a_file(void **state) {
  (void)state;
  cJSON_Delete(simulate("{\"time\": 0.4, \"dt\": 0.002, \"damping\": 20,\n"
                        " \"gravity\": [0, 0, -9.81], \"bodies\": [\n"
                        " {\"name\": \"low\", \"order\": 1, \"model\": "
                        "\"beam:2x2x2@0.1x0.1x0.1,split=6\", \"position\": [0, 0, 0.051],\n"
                        "  \"material\": {\"young\": 1e7, \"density\": 1000}, \"free\": true},\n"
                        " {\"name\": \"high\", \"order\": 1, \"model\": "
                        "\"beam:2x2x2@0.1x0.1x0.1,split=6\", \"position\": [0, 0, 0.152],\n"
                        "  \"material\": {\"young\": 1e7, \"density\": 1000}, \"free\": true}],\n"
                        " \"obstacles\": [{\"shape\": \"plane\"}]}",
                        "pressed", 0));
  char *text = text_file_read(in_folder("pressed/contact.csv"));
  assert_non_null(text);
  assert_int_equal(strncmp(text, "step,time_s,body,on,fx_n,fy_n,fz_n\n", 35), 0);

  // impulses over the whole run, of cubes of 1 kg that fell from rest and lie
  const double weight = 9.81 * 0.4;
  double ground = 0, above = 0, below = 0, step, time, f[3];
  char who[2][40];
  for (char *line = strchr(text, '\n') + 1; line != NULL && *line != '\0';) {
    assert_int_equal(sscanf(line, "%lf,%lf,%39[^,],%39[^,],%lf,%lf,%lf", &step, &time, who[0],
                            who[1], f, f + 1, f + 2),
                     7);
    double *of = strcmp(who[1], "obstacles[0]") == 0 ? &ground
                 : strcmp(who[0], "high") == 0       ? &above
                                                     : &below;
    *of += 0.002 * f[2];
    line = strchr(line, '\n');
    line = line == NULL ? NULL : line + 1;
  }
  assert_true(fabs(ground / weight - 2) < 1e-3 && fabs(above / weight - 1) < 1e-3);
  assert_true(fabs(above + below) < 1e-12 * weight);
  free(text);
}

/* A bar that starts nearer to a box than contact keeps it is told of, with what the distance is.
 * One that is as far away, or a thickness that fits, is not. */
static void a_start_within_the_thickness_is_told_of(void **state) {
  (void)state;
  static const char *const rest[] = {"[0, 0, 0.102]}], \"collisions\": {\"thickness\": 0.004}",
                                     "[0, 0, 0.1045]}], \"collisions\": {\"thickness\": 0.004}",
                                     "[0, 0, 0.102]}], \"collisions\": {\"thickness\": 0.0019}"};
  for (int n = 0; n < 3; n++) {
    char text[500];
    snprintf(
        text, sizeof text,
        "{\"time\": 0.02, \"dt\": 0.002, \"gravity\": [0, 0, -9.81],\n"
        " \"obstacles\": [{\"shape\": \"box\", \"name\": \"table\", \"centre\": [0, 0, -0.5],"
        " \"size\": [4, 4, 1]}],\n"
        " \"bodies\": [{\"name\": \"bar\", \"order\": 1, \"model\": "
        "\"beam:4x2x2@0.4x0.2x0.2,split=6\",\n"
        "  \"material\": {\"young\": 1e7, \"density\": 1000}, \"free\": true, \"position\": %s}",
        rest[n]);
    put("scene.json", text);
    program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "near", "-q", NULL);
    assert_true(run.exit_code == 0 || run.exit_code == 3); // its basis is judged too
    assert_int_equal(strstr(run.err, "start 0.002 m apart, and contact keeps 0.004 m") != NULL,
                     n == 0);
    assert_int_equal(strstr(run.err, "obstacle \"table\"") != NULL, n == 0);
    program_result_free(&run);
  }
}

/* A heavy cube sinks through a soft one, and the run says so. */
static void surfaces_that_cross_flag_the_run(void **state) {
  (void)state;
  cJSON *object =
      simulate("{\"time\": 0.1, \"dt\": 0.01, \"bodies\": [\n"
               " {\"name\": \"low\", \"order\": 1, \"model\": \"beam:2x2x2@0.2x0.2x0.2,split=6\", "
               "\"position\": [0, 0, 0.1],\n"
               "  \"material\": {\"young\": 1e4, \"density\": 1000}, \"free\": true},\n"
               " {\"name\": \"high\", \"order\": 1, \"model\": \"beam:2x2x2@0.1x0.1x0.1,split=6\", "
               "\"position\": [0, 0, 0.252],\n"
               "  \"material\": {\"young\": 1e8, \"density\": 8000}, \"velocity\": [0, 0, -10],"
               " \"free\": true}],\n"
               " \"obstacles\": [{\"shape\": \"plane\"}]}",
               "crossed", 3);
  assert_string_equal(cJSON_GetObjectItem(object, "status")->valuestring, "surfaces_crossed");
  assert_true(json_value(cJSON_GetObjectItem(object, "collisions"), "deepest_of_thickness") >= 1);
  cJSON_Delete(object);
}

/* Runs the scene in `text`, which must be flagged as surfaces_crossed; each of `words` must be in
 * the warnings. */
static void expect_crossed(const char *text, const char *const words[], int count) {
  put("scene.json", text);
  program_result run =
      thrum_run(folder, "simulate", "scene.json", "-o", "crossed", "--json", "-q", NULL);
  cJSON *object = json_line(run.out);
  assert_int_equal(run.exit_code, 3);
  assert_string_equal(cJSON_GetObjectItem(object, "status")->valuestring, "surfaces_crossed");
  for (int n = 0; n < count; n++)
    if (strstr(run.err, words[n]) == NULL)
      fail_msg("no '%s' in: %s", words[n], run.err);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* A condensed body touches none: what falls through it flags the run, and what passes by does not.
 */
static void what_falls_into_a_condensed_body_flags_the_run(void **state) {
  (void)state;
  static const char *const words[] = {"passes through other bodies", "is in body \"low\" at",
                                      "--touch-stepped"};
  static const char falls[] = "{\"dt\": 0.002, \"time\": 0.02, \"bodies\": [\n"
                              " {\"name\": \"low\", \"model\": \"beam.npz\", \"condense\": 3},\n"
                              " {\"name\": \"high\", \"model\": \"free.npz\", \"free\": true, "
                              "\"position\": [0.3, %s, 0.25],\n"
                              "  \"velocity\": [0, 0, %s]}]}";
  char text[500];
  snprintf(text, sizeof text, falls, "0", "-10");
  expect_crossed(text, words, 3);

  // at 4 m a step it is never in it
  snprintf(text, sizeof text, falls, "0", "-2000");
  expect_crossed(text, words, 3);
  snprintf(text, sizeof text, falls, "1", "-2000");
  cJSON *object = simulate(text, "beside", 0);
  cJSON_Delete(object);
}

/* At 1 m a step a bullet goes through a plate, and at 2 m through a cylinder, where contact cannot
 * be solved for; the bodies are apart again when the step ends. */
static void a_body_that_passes_another_within_a_step_flags_the_run(void **state) {
  (void)state;
  static const char *const plate[] = {
      "surfaces went through each other, of body \"plate\" and body \"bullet\" at first",
      "shorter dt"};
  static const char *const solid[] = {"contact was given up in 1 step of \"bullet\"",
                                      "surfaces went through each other"};

  // another body
  expect_crossed(
      "{\"dt\": 0.002, \"time\": 0.012, \"bodies\": [\n"
      " {\"name\": \"plate\", \"model\": \"beam:10x10x1@0.5x0.5x0.02,split=6\", \"order\": 1, "
      "\"free\": "
      "true,\n"
      "  \"material\": {\"young\": 1e9}},\n"
      " {\"name\": \"bullet\", \"model\": \"beam:2x2x2@0.05x0.05x0.05,split=6\", \"order\": 1, "
      "\"free\": "
      "true,\n"
      "  \"position\": [0.225, 0, 0.3], \"velocity\": [0, 0, -500], \"material\": {\"young\": "
      "1e9}}]}",
      plate, 2);

  // and a solid
  expect_crossed(
      "{\"dt\": 0.002, \"time\": 0.02, \"bodies\": [\n"
      " {\"name\": \"bullet\", \"model\": \"beam:2x2x2@0.05x0.05x0.05,split=6\", \"order\": 1, "
      "\"free\": true,\n"
      "  \"position\": [-0.01, -0.005, 0.33], \"velocity\": [0, 0, -1000],"
      " \"material\": {\"young\": 1e9}}],\n"
      " \"obstacles\": [{\"shape\": \"cylinder\", \"radius\": 0.01, \"height\": 0.6}]}",
      solid, 2);
}

/* A cube of 5 cm comes down on a sphere, which its vertices alone touch: at 1,000 m/s it goes over
 * one of 10 cm within a step, and at 1 m/s one of 1 cm goes into it between its vertices. At 10 m/s
 * it bounces off the larger one. */
static void a_sphere_that_goes_through_a_body_flags_the_run(void **state) {
  (void)state;
  static const double cases[][2] = {{0.1, 1000}, {0.01, 1}, {0.1, 10}};
  static const char *const words[] = {"body 'bullet' went over obstacles[0], a sphere", "capsule"};
  for (int n = 0; n < 3; n++) {
    char text[440];

    // it reaches the sphere, and has 20 ms more
    snprintf(
        text, sizeof text,
        "{\"time\": %g, \"dt\": 0.002, \"bodies\": [\n"
        " {\"name\": \"bullet\", \"model\": \"beam:2x2x2@0.05x0.05x0.05,split=6\", \"order\": 1, "
        "\"free\": true,"
        " \"position\": [-0.02, -0.005, 0.33], \"velocity\": [0, 0, %g],\n"
        "  \"material\": {\"young\": 1e9}}],\n"
        " \"obstacles\": [{\"shape\": \"sphere\", \"radius\": %g}]}",
        0.31 / cases[n][1] + 0.02, -cases[n][1], cases[n][0]);
    if (n < 2)
      expect_crossed(text, words, 2);
    else
      cJSON_Delete(simulate(text, "bounced", 0));
  }
}

/* Two bars that overlap by half of their length stay so when their joint lets go. The touches know
 * of less than two thicknesses; the run says how deep the bars are. */
static void bars_that_a_joint_held_in_each_other_are_said(void **state) {
  (void)state;
  static const char *const stay[] = {"surfaces went through each other", "m deep in body \"",
                                     "is 0.05"};
  expect_crossed("{\"dt\": 0.002, \"time\": 0.03, \"bodies\": [\n"
                 " {\"name\": \"a\", \"model\": \"beam:4x2x2@0.4x0.1x0.1\", \"free\": true},\n"
                 " {\"name\": \"b\", \"model\": \"beam:4x2x2@0.4x0.1x0.1\", \"free\": true,"
                 " \"position\": [0.2, 0, 0]}],\n"
                 " \"links\": [{\"kind\": \"weld\", \"body\": \"a\", \"place\": [0.3, 0, 0],"
                 " \"other\": \"b\", \"until\": 0.01}]}",
                 stay, 3);
}

/* A coupled bar whose basis bends it and hardly stretches it is warned of, one with the modes that
 * stretch it, or one that hardly turns, is not. */
static void a_spin_that_the_basis_cannot_show_is_warned_of(void **state) {
  (void)state;
  static const char *const modes[] = {"4", "10"};
  for (int n = 0; n < 3; n++) {
    program_result made = thrum_run(folder, "precompute", "beam:40x2x2@1x0.05x0.05,split=6",
                                    "--order", "1", "--young", "1e6", "--poisson", "0", "--density",
                                    "1000", "--modes", modes[n == 1], "-o", "bar.npz", "-q", NULL);
    assert_int_equal(made.exit_code, 0);
    program_result_free(&made);

    // 4 rad/s across the axis, or a degree a second
    char text[300];
    snprintf(text, sizeof text,
             "{\"time\": 0.02, \"dt\": 0.002, \"bodies\": [\n"
             " {\"name\": \"bar\", \"model\": \"bar.npz\", \"free\": true, \"coupled\": true,"
             " \"spin\": [0, 0, %s]}]}",
             n == 2 ? "1" : "229");
    put("scene.json", text);

    // the run is done all the same
    program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "spun", "-q", NULL);
    const char *found = strstr(run.err, "of what its spin stretches the mesh by");
    if (run.exit_code != 0 || (found != NULL) != (n == 0))
      fail_msg("%d: exit code %d: %s", n, run.exit_code, run.err);
    program_result_free(&run);
  }
}

/* The lowest frequency of free.npz [Hz]. */
static double lowest_frequency(void) {
  program_result run = thrum_run(folder, "info", "free.npz", "--json", NULL);
  cJSON *object = json_line(run.out);
  const double f =
      cJSON_GetArrayItem(cJSON_GetObjectItem(object, "basis_frequencies_hz"), 0)->valuedouble;
  cJSON_Delete(object);
  program_result_free(&run);
  return f;
}

/* Spin and shape of a free body act on each other where nothing is said and it begins to turn at a
 * 50th of its lowest frequency or faster, which a scaled body has others of. The run says so, and
 * `false` leaves it out. What steps otherwise is not coupled and, where it turns fast, is warned
 * of: also where a load has turned it. */
static void fast_bodies_are_coupled_by_default(void **state) {
  (void)state;
  const double f = 360 * lowest_frequency(); // of its lowest frequency, as degrees a second
  static const struct {
    double share;
    const char *more;
    int coupled, by_default;
    bool warned;
  } cases[] = {
      {0.019, "", 0, 0, false},
      {0.021, "", 1, 1, false},
      {0.3, "", 1, 1, false},
      {0.3, ", \"coupled\": false", 0, 0, false},
      {0.01, ", \"coupled\": true", 1, 0, false},
      {0.03, ", \"scale\": 0.5", 0, 0, false},
      {0.03, ", \"stiffness\": 0.25, \"scale\": 0.5", 1, 1, false},
      {0.05, ", \"integrator\": \"newmark\"", 0, 0, false},
      {0.3, ", \"integrator\": \"newmark\"", 0, 0, true},
      {0.3, ", \"condense\": 2", 0, 0, true},
      {0, ", \"loads\": \"impulse:0,0,3e5@vertex=1\"", 0, 0, true},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char text[400];
    snprintf(text, sizeof text,
             "{\"time\": 0.02, \"dt\": 0.0005, \"bodies\": [\n"
             " {\"name\": \"it\", \"model\": \"free.npz\", \"free\": true%s,"
             " \"spin\": [0, %.17g, 0]}]}",
             cases[n].more, cases[n].share * f);
    put("scene.json", text);
    program_result run =
        thrum_run(folder, "simulate", "scene.json", "-o", "turning", "-q", "--json", NULL);
    cJSON *object = json_line(run.out);
    const cJSON *body = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), 0);
    if (cJSON_IsTrue(cJSON_GetObjectItem(body, "coupled")) != cases[n].coupled ||
        cJSON_IsTrue(cJSON_GetObjectItem(body, "coupled_by_default")) != cases[n].by_default ||
        (strstr(run.err, "without what spin and shape do to each other") != NULL) !=
            cases[n].warned)
      fail_msg("%d: %s%s", (int)n, run.out, run.err);
    cJSON_Delete(object);
    program_result_free(&run);

    // people read it as a line
    run = thrum_run(folder, "simulate", "scene.json", "-o", "turning", "-q", NULL);
    assert_int_equal(strstr(run.out, "coupled      it: it begins to turn at ") != NULL,
                     cases[n].by_default);
    program_result_free(&run);
  }
}

/* The warnings of a scene that is stepped for a moment; the caller frees them with free(). */
static char *warnings_of(const char *text) {
  put("scene.json", text);
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "idle", "-q", NULL);
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  char *said = strdup(run.err);
  assert_non_null(said);
  program_result_free(&run);
  return said;
}

/* What a scene says and what has no effect is named by its line; the same in a scene where it has
 * one is not. */
static void what_has_no_effect_is_named(void **state) {
  (void)state;
  static const char bodies[] = "\"bodies\": [\n {\"name\": \"a\", \"model\": \"beam.npz\"%s}]";
  static const struct {
    const char *scene, *body, *said; /* NULL: nothing */
  } cases[] = {
      {"", ", \"loads\": [\"constant:0,0,0@tip\"]",
       "scene.json:2: body 'a': \"loads\": 'constant:0,0,0@tip' moves nothing"},
      {"", ", \"loads\": [\"constant:0,0,1@vertex=1\"]", "moves nothing"},
      {"", ", \"loads\": [\"constant:0,0,1@tip\"]", NULL},
      {"", ", \"loads\": [\"constant:0,0,1@tip,from=2\"]",
       "begins at 2 s and has no effect: the run ends at 0.02 s"},
      {"\"newmark\": [0.3, 0.6],", "", "scene.json:1: \"newmark\" has no effect: it is of newmark"},
      {"\"newmark\": [0.3, 0.6],", ", \"integrator\": \"newmark\"", NULL},
      {"", ", \"integrator\": \"verlet\", \"iterations\": 9",
       "scene.json:2: body 'a': \"iterations\" has no effect"},
      {"\"adaptive\": false,", "", "\"adaptive\" has no effect"},
      {"\"eye\": [1, 0, 0],", "", "\"eye\" has no effect"},
      {"", ", \"touch_stiffness\": 1e6", "\"touch_stiffness\" has no effect: the scene has no"},
      {"\"obstacles\": [{\"shape\": \"plane\", \"centre\": [0, 0, -1]}],",
       ", \"touch_stiffness\": 1e6", NULL},
      {"\"obstacles\": [{\"shape\": \"plane\", \"centre\": [0, 0, -1]}],", ", \"touch\": \"none\"",
       "\"obstacles\" has no effect"},
      {"\"collisions\": {\"friction\": 0.3},", "", "\"collisions\" has no effect"},
      {"\"wind\": {\"velocity\": [1, 0, 0], \"drag\": 0},", "", "\"wind\" has no effect"},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char body[400], text[900];
    snprintf(body, sizeof body, bodies, cases[n].body);
    snprintf(text, sizeof text, "{\"time\": 0.02, \"dt\": 0.002, %s %s}", cases[n].scene, body);
    char *said = warnings_of(text);
    const char *effect = strstr(said, "has no effect");
    if (cases[n].said != NULL ? strstr(said, cases[n].said) == NULL
                              : effect != NULL || strstr(said, "moves nothing") != NULL)
      fail_msg("%d: %s", (int)n, said);
    free(said);
  }

  // a free body that the scene does not let go, and one that it does
  for (int n = 0; n < 2; n++) {
    char text[200];
    snprintf(text, sizeof text,
             "{\"time\": 0.02, \"gravity\": [0, 0, -9.81],\n \"bodies\": [{\"model\": "
             "\"free.npz\"%s}]}",
             n == 0 ? "" : ", \"free\": true");
    char *said = warnings_of(text);
    if ((strstr(said, "add \"free\": true to let it fall") != NULL) != (n == 0) ||
        strstr(said, "a period of mode") != NULL)
      fail_msg("%d: %s", n, said);
    free(said);
  }

  // a base that moves and nothing that it holds
  char *said = warnings_of("{\"time\": 0.02, \"dt\": 0.002, \"base_motion\": \"sine:0,0,1,f=2\",\n"
                           " \"bodies\": [{\"model\": \"free.npz\", \"free\": true}]}");
  assert_non_null(strstr(said, "\"base_motion\" has no effect: nothing holds any of the bodies"));
  free(said);
}

/* Steps of a period of each mode that moves are counted: a mode that no load or start moves does
 * not count, nor one that dies out at once, and energy is right to shorter periods. */
static void steps_that_are_coarse_are_named(void **state) {
  (void)state;
  program_result info = thrum_run(folder, "info", "beam.npz", "--json", NULL);
  cJSON *object = json_line(info.out);
  const cJSON *list = cJSON_GetObjectItem(object, "basis_frequencies_hz");
  // sideways it bends by the second mode
  const double second = cJSON_GetArrayItem(list, 1)->valuedouble;
  const double third = cJSON_GetArrayItem(list, 2)->valuedouble;
  cJSON_Delete(object);
  program_result_free(&info);
  assert_true(third > 2 * second);
  const struct {
    double dt;
    const char *more;
    bool said;
    int steps;
  } cases[] = {
      {1 / (7 * second), "", false, 20}, // right by energy
      {1 / (6 * second), "", true, 20},
      {1 / (6 * second), ", \"frequency_matching\": false", true, 20},
      {1 / (7 * second), ", \"integrator\": \"newmark\"", true, 20},
      {1 / (9 * second), ", \"integrator\": \"newmark\"", false, 20}, // two periods
      {1 / (9 * second), ", \"integrator\": \"newmark\"", true, 90},
      {1 / (9 * second), ", \"integrator\": \"newmark\", \"damping\": 100", false, 90},
      {1 / (9 * second), "", false, 90},
      {1 / (21 * second), ", \"integrator\": \"newmark\"", false, 400},
      {1 / (6 * second), ", \"integrator\": \"fox-goodwin\"", false, 20},
      {1 / (4 * second), ", \"integrator\": \"fox-goodwin\"", true, 20},
      {1 / (4 * second), ", \"stiffness\": 0.25", false, 20}, // half of the frequency
      {1 / (4 * third), ", \"start\": \"mode:1,0.001\"", false, 20},
      {1 / (4 * third), ", \"start\": \"mode:3,0.001\"", true, 20},
      {1 / (1.3 * third), ", \"start\": \"mode:3,0.001\"", true, 20}, // also of less than two steps
      {1 / (4 * second), ", \"damping\": 1000", false, 20},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char text[400];
    const bool starts = strstr(cases[n].more, "start") != NULL;
    snprintf(text, sizeof text,
             "{\"time\": %.17g, \"dt\": %.17g, \"outputs\": {\"monitor\": false}, \"bodies\": [\n"
             " {\"model\": \"beam.npz\"%s%s}]}",
             cases[n].steps * cases[n].dt, cases[n].dt, cases[n].more,
             starts ? "" : ", \"loads\": \"constant:0,1,0@tip\"");
    char *said = warnings_of(text);
    const char *found = strstr(said, "a period of mode ");
    if ((found != NULL) != cases[n].said ||
        (found != NULL && strstr(found, "lower \"dt\"") == NULL))
      fail_msg("%d: %s", (int)n, said);
    free(said);
  }

  // the step that is proposed is none that is named: it has 20 in a period of the first mode,
  // which holds most, and so more than 10 in one of the second
  char text[300], *end;
  snprintf(text, sizeof text,
           "{\"time\": 1, \"dt\": %.17g, \"bodies\": [\n"
           " {\"model\": \"beam.npz\", \"loads\": \"constant:0,1,0@tip\"}]}",
           1 / (3 * second));
  char *said = warnings_of(text);
  const char *to = strstr(said, ", to ");
  assert_non_null(to);
  const double dt = strtod(to + 5, &end);
  assert_true(dt > 0 && dt * second <= 0.1);
  free(said);
}

/* A cube falls on a plane in steps of 1 s, each of which takes it through: it is deeper in the
 * plane than its size. With a stiffness that the file gives, depth is what was asked for. */
static void a_body_deep_in_a_plane_flags_the_run(void **state) {
  (void)state;
  static const char *const deep[] = {"body 'c' was 0.", "m deep in an obstacle", "shorter dt"};
  expect_crossed("{\"dt\": 1, \"time\": 5, \"gravity\": [0, 0, -9.81], \"bodies\": [\n"
                 " {\"name\": \"c\", \"model\": \"beam:4x4x4@0.2x0.2x0.2\", \"free\": true,"
                 " \"position\": [0, 0, 0.6]}],\n"
                 " \"obstacles\": [{\"shape\": \"plane\"}]}",
                 deep, 3);

  // a plate is below the floor as a whole where it is deeper than it is thick
  static const char *const below[] = {"body 'p' was 0.", "m deep in an obstacle",
                                      "is 0.02 m thick"};
  expect_crossed("{\"dt\": 0.02, \"time\": 0.6, \"gravity\": [0, 0, -9.81], \"bodies\": [\n"
                 " {\"name\": \"p\", \"model\": \"beam:6x6x1@0.5x0.5x0.02\", \"order\": 1,"
                 " \"free\": true, \"position\": [0, 0, 1.25], \"velocity\": [0, 0, -10],"
                 " \"material\": {\"young\": 1.2e5}}],\n"
                 " \"obstacles\": [{\"shape\": \"plane\"}]}",
                 below, 3);
  cJSON_Delete(simulate("{\"dt\": 0.01, \"time\": 1, \"gravity\": [0, 0, -9.81], \"bodies\": [\n"
                        " {\"model\": \"free.npz\", \"free\": true, \"position\": [0, 0, 0.2]}],\n"
                        " \"obstacles\": [{\"shape\": \"plane\", \"stiffness\": 1e5}]}",
                        "soft", 0));
}

/* A bar turns by 270 degrees as its angles say, and hits a block at 45 degrees; the short way back
 * by 90 it would not. */
static void a_path_turns_as_far_as_its_angles_say(void **state) {
  (void)state;
  static const char *const turns[] = {"270", "-270", "720"};
  for (int n = 0; n < 3; n++) {
    char text[600];
    snprintf(text, sizeof text,
             "{\"time\": 0.6, \"dt\": 0.002, \"gravity\": [0, 0, 0], \"bodies\": [\n"
             " {\"name\": \"hit\", \"model\": \"free.npz\", \"scale\": 0.2,"
             " \"position\": [0.2, %s, 0], \"free\": true}],\n"
             " \"obstacles\": [{\"shape\": \"box\", \"size\": [0.8, 0.02, 0.2], \"path\": [\n"
             "  {\"time\": 0, \"centre\": [0, 0, 0]},\n"
             "  {\"time\": 0.6, \"centre\": [0, 0, 0],"
             " \"rotation\": {\"axis\": [0, 0, 1], \"angle\": %s}}]}]}",
             n == 1 ? "-0.2" : "0.2", turns[n]);
    cJSON *object = simulate(text, "turned", 0);
    assert_true(json_value(cJSON_GetObjectItem(object, "collisions"), "driven_j") > 0);
    cJSON_Delete(object);
  }

  // more turns than a path has room for
  put("scene.json",
      "{\"time\": 0.6, \"bodies\": [{\"model\": \"free.npz\", \"free\": true}],\n"
      " \"obstacles\": [{\"shape\": \"box\", \"size\": [0.8, 0.02, 0.2], \"path\": [\n"
      "  {\"time\": 0, \"centre\": [0, 0, 9]},\n"
      "  {\"time\": 1, \"centre\": [0, 0, 9], \"rotation\": {\"axis\": [0, 0, 1], \"angle\": "
      "1e300}}"
      "]}]}");
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "turns", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "turns too often"));
  program_result_free(&run);
}

static void a_mesh_may_be_of_another_law(void **state) {
  (void)state;
  cJSON *object = simulate("{\"time\": 0.06, \"gravity\": [0, 0, -9.81], \"bodies\": ["
                           "{\"model\": \"beam:3x1x1@0.3x0.1x0.1\", \"fix\": [\"x<0.001\"],"
                           " \"material\": {\"young\": 2e4}},"
                           "{\"model\": \"beam:3x1x1@0.3x0.1x0.1\", \"fix\": [\"x<0.001\"],"
                           " \"material\": {\"young\": 2e4, \"law\": \"neo-hookean\"}}]}",
                           "laws", 0);

  // bodies that differ in their law alone are of two models
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const cJSON *usual = cJSON_GetArrayItem(bodies, 0), *other = cJSON_GetArrayItem(bodies, 1);
  assert_string_equal(cJSON_GetObjectItem(usual, "law")->valuestring, "stvk");
  assert_string_equal(cJSON_GetObjectItem(other, "law")->valuestring, "neo-hookean");
  assert_true(json_value(usual, "energy_last_j") != json_value(other, "energy_last_j"));
  cJSON_Delete(object);
}

static void a_body_may_flow_and_says_what_it_lost(void **state) {
  (void)state;
#define BEAM                                                                                       \
  "{\"model\": \"beam:3x1x1@0.3x0.1x0.1\", \"fix\": [\"x<0.001\"], \"material\": {\"young\": "     \
  "2e4, "
  cJSON *object = simulate("{\"time\": 0.2, \"gravity\": [0, 0, -9.81], \"bodies\": [" BEAM
                           "\"law\": \"corotational\"}}, " BEAM
                           "\"law\": \"corotational\", \"yield\": 0.02}}]}",
                           "flows", 0);

  // one of them loses to the flow
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const cJSON *elastic = cJSON_GetArrayItem(bodies, 0), *other = cJSON_GetArrayItem(bodies, 1);
  assert_true(json_value(elastic, "plastic_work_j") == 0);
  const double lost = json_value(other, "plastic_work_j");
  assert_true(lost > 0.01 * json_value(other, "energy_max_j"));
  cJSON_Delete(object);
  char *text = text_file_read(in_folder("flows/body2/run.json"));
  object = cJSON_Parse(text);
  free(text);
  const cJSON *work = cJSON_GetObjectItem(object, "work");
  assert_true(json_value(work, "dissipated_j") == lost);
  assert_true(fabs(json_value(work, "balance_j")) < 1e-9 * json_value(work, "load_j"));
  cJSON_Delete(object);

  // refused, each with its line
  static const char *const cases[][2] = {
      {BEAM "\"yield\": 0.02}}", "needs \"law\""},
      {BEAM "\"law\": \"corotational\", \"creep\": 2}}", "is needed: beyond it"},
      {BEAM "\"law\": \"corotational\", \"yield\": -1}}", "above 0"},
      {"{\"model\": \"beam.npz\", \"material\": {\"yield\": 0.1}}", "cannot flow"},
      {"{\"model\": \"beam.npz\", \"material\": {\"young\": 1e5}}", "is of a mesh"},
  };
  for (int n = 0; n < 5; n++) {
    char scene[400];
    snprintf(scene, sizeof scene, "{\"time\": 0.1, \"bodies\": [%s]}", cases[n][0]);
    put("scene.json", scene);
    program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "none", "-q", NULL);
    assert_int_equal(run.exit_code, 1);
    if (!strstr(run.err, cases[n][1]))
      fail_msg("%s", run.err);
    program_result_free(&run);
  }
#undef BEAM
}

/* Refusals and warnings name keys of the scene and their place. They name no options of a command,
 * except those that make a model beforehand. */
static void scenes_are_answered_in_their_own_words(void **state) {
  (void)state;
#define MESH "\"model\": \"beam:4x1x1@1x0.1x0.1\", \"fix\": \"x<0.001\""
  static const struct {
    const char *body, *says;
  } cases[] = {
      {MESH ", \"material\": {\"regions\": [\"9:1e6,0.3,1000\"]}",
       "scene.json:2: bodies[0].material.regions: '9' is no region; the only region is 1\n"},
      {"\"model\": \"bare.mesh\"", "bodies[0].model: bare.mesh does not say what it is made of: "
                                   "give \"young\", \"poisson\" and \"density\"\n"},
      {"\"model\": \"beam:4x1x1@1x0.1x0.1\", \"fix\": \"nothing\"",
       "bodies[0].fix: 'nothing' is neither"},
      {MESH ", \"order\": 1",
       "scene.json:2: body 'a': beam:4x1x1@1x0.1x0.1: its linear tetrahedra are too stiff"},
      {MESH ", \"order\": 1", "; make the model with thrum precompute --order 2\n"},
      {MESH ", \"order\": 3", "bodies[0].order: wants auto, 1 or 2"},
      {"\"model\": \"beam.npz\", \"order\": 2", "bodies[0].order: is of a mesh"},
      {MESH ", \"material\": {\"regions\": [\"1:corotational,0.1\"]}",
       "outputs.stress: body 'a': is of a material that does not flow"},
      {MESH ", \"free\": true", "bodies[0].fix: holds the body"},
      {MESH ", \"integrator\": \"imexv\", \"split\": 99",
       "bodies[0].split: is 99; it must be 0 to"},
      {MESH ", \"condense\": 99", "bodies[0].condense: "},
      {"\"model\": \"beam.npz\", \"material\": {\"yield\": 0.1}",
       "bodies[0].material.yield: is 0.1, and this model cannot flow"},
      {MESH ", \"integrator\": \"newmark\", \"loads\": \"square:0,0,-1e9@tip\", \"iterations\": 1, "
            "\"fallback\": false",
       "or allow more iterations\n"},
  };

  // a mesh that does not say what it is made of
  program_result run = thrum_run(folder, "convert", "beam:4x1x1@1x0.1x0.1", "bare.mesh", NULL);
  program_result_free(&run);

  // the body stands on the second line
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char scene[500];
    const bool stress = strstr(cases[n].says, "stress") != NULL;
    snprintf(
        scene, sizeof scene,
        "{\"time\": 0.01, \"outputs\": {\"stress\": %s}, \"bodies\": [\n{\"name\": \"a\", %s}]}",
        stress ? "true" : "false", cases[n].body);
    put("scene.json", scene);
    run = thrum_run(folder, "simulate", "scene.json", "-o", "answered", "-q", NULL);
    if (strstr(run.err, cases[n].says) == NULL)
      fail_msg("case %d: %s", (int)n, run.err);
    const char *option = strstr(run.err, " --");
    assert_true(option == NULL || strncmp(option - 10, "precompute --", 13) == 0);
    program_result_free(&run);
  }
#undef MESH
}

/* The scene of two regions: a soft pad below the block gives way. */
static void a_pad_gives_way_below_its_block(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", write_scene("padded", true), "-o", "padded",
                                 "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *bodies = cJSON_GetObjectItem(object, "bodies");
  const double padded = json_value(cJSON_GetArrayItem(bodies, 0), "peak_displacement_m");
  const double plain = json_value(cJSON_GetArrayItem(bodies, 1), "peak_displacement_m");
  assert_true(padded > 5 * plain && plain > 0);
  cJSON_Delete(object);
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_body_may_flow_and_says_what_it_lost),
      cmocka_unit_test(a_mesh_may_be_of_another_law),
      cmocka_unit_test(a_body_of_a_scene_has_the_run_of_it_alone),
      cmocka_unit_test(a_turned_and_scaled_body_follows_its_world),
      cmocka_unit_test(a_free_body_drops_on_the_floor_of_the_scene),
      cmocka_unit_test(a_body_that_falls_freely_is_done),

      // mistakes, and folders that cannot be used
      cmocka_unit_test(a_mistake_is_named_by_file_line_and_path),
      cmocka_unit_test(scenes_are_answered_in_their_own_words),
      cmocka_unit_test(options_of_one_body_are_refused),
      cmocka_unit_test(an_earlier_run_is_replaced_and_other_files_stay),
      cmocka_unit_test(a_folder_that_cannot_be_written_to_is_refused_first),

      // what is written, and how runs end
      cmocka_unit_test(frames_stand_where_the_bodies_are),
      cmocka_unit_test(a_whole_turn_brings_a_free_body_back),
      cmocka_unit_test(a_body_that_cannot_be_stepped_ends_the_run_and_flags_it),
      cmocka_unit_test(the_schema_is_committed_and_every_key_is_documented),
      cmocka_unit_test(the_scenes_that_come_with_thrum_run),
      cmocka_unit_test(a_scene_has_bodies_of_every_law),
      cmocka_unit_test(a_pad_gives_way_below_its_block),
      cmocka_unit_test(what_touches_in_the_scenes_keeps_its_distance),
      cmocka_unit_test(a_plate_on_a_pole_is_not_thrown_up_again),
      cmocka_unit_test(a_cube_that_tumbles_over_hills_keeps_its_distance),
      cmocka_unit_test(a_scene_with_links_adds_up),
      cmocka_unit_test(a_joint_that_stays_open_flags_the_run),
      cmocka_unit_test(a_joint_that_no_step_can_follow_stops_the_run),
      cmocka_unit_test(a_handle_follows_a_file_and_lets_go),
      cmocka_unit_test(the_forces_of_contact_are_in_a_file),
      cmocka_unit_test(a_start_within_the_thickness_is_told_of),
      cmocka_unit_test(surfaces_that_cross_flag_the_run),
      cmocka_unit_test(what_falls_into_a_condensed_body_flags_the_run),
      cmocka_unit_test(a_body_that_passes_another_within_a_step_flags_the_run),
      cmocka_unit_test(a_sphere_that_goes_through_a_body_flags_the_run),
      cmocka_unit_test(bars_that_a_joint_held_in_each_other_are_said),
      cmocka_unit_test(a_spin_that_the_basis_cannot_show_is_warned_of),
      cmocka_unit_test(fast_bodies_are_coupled_by_default),
      cmocka_unit_test(what_has_no_effect_is_named),
      cmocka_unit_test(steps_that_are_coarse_are_named),
      cmocka_unit_test(a_body_deep_in_a_plane_flags_the_run),
      cmocka_unit_test(a_path_turns_as_far_as_its_angles_say),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
