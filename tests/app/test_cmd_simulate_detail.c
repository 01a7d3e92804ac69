/* The keys "budget", "error" and "detail" of a scene's bodies: what is found, that it is found
 * once, and what is said of it. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

/* A model, and a cache of its own, so that nothing is there from other runs. */
static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !precompute_beam("8x2x2@1x0.1x0.1", "6", "12"))
    return -1;
  program_result run = thrum_run(folder, "precompute", "beam:3x2x2@0.3x0.2x0.2", "--order", "1",
                                 "-o", "free.npz", "--modes", "4", "--rank", "8", "-q", NULL);
  program_result_free(&run);
  return setenv("XDG_CACHE_HOME", in_folder("cache"), 1);
}

/* Runs a scene of these bodies with more keys; its object, which the caller frees. */
static cJSON *simulate(const char *keys, const char *bodies) {
  char text[2000];
  snprintf(text, sizeof text, "{\"time\": 1, %s \"bodies\": [%s]}", keys, bodies);
  assert_true(text_file_write(in_folder("scene.json"), text));
  program_result run =
      thrum_run(folder, "simulate", "scene.json", "-o", "out", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static const cJSON *body_of(const cJSON *object, int n) {
  return cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), n);
}

static double masters_of(const cJSON *body) {
  const cJSON *condensed = cJSON_GetObjectItem(body, "condensed");
  return cJSON_IsObject(condensed) ? json_value(condensed, "masters") : 0;
}

static void assert_found_by(const cJSON *body, const char *by) {
  assert_string_equal(cJSON_GetStringValue(cJSON_GetObjectItem(body, "found_by")), by);
}

/* Exchanges one bit of the number of coordinates in each file that keeps what was found. */
static void damage_what_is_kept(void) {
  char path[100];
  int count = 0;
  DIR *dir = opendir(in_folder("cache/thrum"));
  assert_non_null(dir);

  // a digit whose lowest bit is exchanged is another digit, and the file as well-formed as before
  for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir)) {
    if (strncmp(entry->d_name, "detail-", 7) != 0)
      continue;
    snprintf(path, sizeof path, "cache/thrum/%.60s", entry->d_name);
    FILE *file = fopen(in_folder(path), "r+b");
    assert_non_null(file);
    const int digit = fgetc(file);
    rewind(file);
    assert_int_equal(fputc(digit ^ 1, file), digit ^ 1);
    assert_int_equal(fclose(file), 0);
    count++;
  }
  closedir(dir);
  assert_true(count > 0);
}

#define SWING "\"model\": \"beam.npz\", \"start\": \"mode:1,0.03\""

static void a_budget_is_kept_and_found_once(void **state) {
  (void)state;
  static const char bodies[] = "{" SWING ", \"budget\": 5.5e-7},"
                               "{" SWING ", \"budget\": 5.5e-7, \"position\": [0, 2, 0]},"
                               "{" SWING ", \"budget\": 1e-3}";
  cJSON *object = simulate("", bodies);
  const cJSON *first = body_of(object, 0), *same = body_of(object, 1), *rich = body_of(object, 2);
  const double masters = masters_of(first), error = json_value(first, "error_found");
  assert_true(masters >= 2 && masters <= 4);
  assert_true(json_value(first, "cost_s") <= 5.5e-7);
  assert_true(error > 0 && error < 1);
  assert_found_by(first, "trials");
  assert_true(masters_of(same) == masters);
  assert_found_by(same, "another body");

  // where there is room for all of them, all are stepped
  assert_true(masters_of(rich) == 0 && json_value(rich, "error_found") == 0);
  cJSON_Delete(object);

  // the next run knows it
  object = simulate("", bodies);
  assert_found_by(body_of(object, 0), "an earlier run");
  assert_true(masters_of(body_of(object, 0)) == masters);
  assert_true(json_value(body_of(object, 0), "error_found") == error);
  cJSON_Delete(object);

  // but not from a damaged file
  damage_what_is_kept();
  object = simulate("", bodies);
  assert_found_by(body_of(object, 0), "trials");
  assert_true(masters_of(body_of(object, 0)) == masters);
  cJSON_Delete(object);

  // and what acts on the body makes it another one
  object = simulate("\"gravity\": [0, 0, -1],", bodies);
  assert_found_by(body_of(object, 0), "trials");
  cJSON_Delete(object);

  // damping of what follows takes time too, here with two coordinates more than the budget
  object = simulate("", "{" SWING ", \"budget\": 5.5e-7, \"damping\": [0, 0.001]}");
  assert_true(masters_of(body_of(object, 0)) == 2);
  assert_true(json_value(body_of(object, 0), "cost_s") > 6.3e-7);
  cJSON_Delete(object);
}

static void an_error_and_a_budget_go_together(void **state) {
  (void)state;

  // the fewest that are good enough, which a budget with more room does not change
  cJSON *object = simulate("", "{" SWING ", \"error\": 0.2},"
                               "{" SWING ", \"error\": 0.2, \"budget\": 5.7e-7}");
  const double masters = masters_of(body_of(object, 0));
  assert_true(masters >= 2 && json_value(body_of(object, 0), "error_found") <= 0.2);
  assert_true(masters_of(body_of(object, 1)) == masters);
  cJSON_Delete(object);

  // an error that no number within the budget has: the least there is, with a warning
  assert_true(text_file_write(in_folder("scene.json"), "{\"time\": 1, \"bodies\": [{" SWING
                                                       ", \"error\": 1e-6, \"budget\": 4.8e-7}]}"));
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "out", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  if (strstr(run.err, "within its budget the least error") == NULL)
    fail_msg("%s", run.err);

  // the table says how many coordinates are stepped
  assert_non_null(strstr(run.out, "2 of 12"));
  program_result_free(&run);
}

static void bodies_that_lack_the_same_share_a_warning(void **state) {
  (void)state;
  static const char scene[] = "{\"time\": 0.2, \"bodies\": ["
                              "{\"name\": \"a\", " SWING ", \"error\": 1e-6},"
                              "{\"name\": \"b\", " SWING ", \"error\": 1e-6},"
                              "{\"name\": \"c\", " SWING ", \"error\": 2e-6},"
                              "{\"name\": \"d\", " SWING ", \"error\": 1e-6},"
                              "{\"name\": \"e\", " SWING ", \"error\": 1e-6}]}";
  assert_true(text_file_write(in_folder("scene.json"), scene));
  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "out", "-q", NULL);

  // four that ask for the same, and one that asks for something else
  const bool grouped = text_count(run.err, "no number of coordinates") == 2 &&
                       strstr(run.err, "warning: 4 bodies, 'a', 'b', 'd' and others: in the") &&
                       strstr(run.err, "warning: body 'c': in the first");
  if (!grouped)
    fail_msg("%s", run.err);
  program_result_free(&run);
}

static void a_level_of_detail_is_recorded(void **state) {
  (void)state;
  cJSON *object =
      simulate("\"eye\": [-5, 0, 0], \"eye_velocity\": [10, 0, 0], \"damping\": [3, 0],",
               "{" SWING ", \"detail\": {\"beyond\": 3, \"jump\": 0.003}},"
               "{\"model\": \"beam.npz\", \"loads\": \"impulse:0,0,-30@tip,from=0.9\","
               " \"detail\": {\"condense\": 3, \"still\": 0.01, \"jump\": 0.003}}");
  const cJSON *passed = cJSON_GetObjectItem(body_of(object, 0), "detail"),
              *struck = cJSON_GetObjectItem(body_of(object, 1), "detail");

  // far, near, far again; and at rest until it is struck
  assert_true(json_value(passed, "changes") >= 2);
  assert_true(json_value(passed, "largest_jump_m") <= 0.003);
  assert_true(json_value(passed, "reduced_steps") > 50);
  assert_true(json_value(struck, "changes") == 2);
  assert_true(json_value(struck, "condense") == 3);
  assert_true(json_value(struck, "reduced_steps") > 50);
  assert_true(json_value(struck, "reduced_steps") < json_value(object, "steps"));
  cJSON_Delete(object);

  program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "out", "-q", NULL);
  assert_non_null(strstr(run.out, "2 coordinates in"));
  assert_non_null(strstr(run.out, "(at most 0.003 m)"));
  program_result_free(&run);
}

static void what_cannot_be_is_refused_by_its_line(void **state) {
  (void)state;
  static const char *const cases[][2] = {
      {"\"budget\": 1e-6, \"rank\": 4", "bodies[0].budget: it finds how many coordinates"},
      {"\"error\": 0.1, \"condense\": 4", "bodies[0].error: it finds how many coordinates"},
      {"\"budget\": 0", "bodies[0].budget"},
      {"\"detail\": {\"beyond\": 3}", "bodies[0].detail"},
      {"\"detail\": {\"jump\": 0.1}", "neither \"beyond\" nor \"still\""},
      {"\"detail\": {\"jump\": 0.1, \"beyond\": 3, \"condense\": 12}", "the body steps 12"},
      {"\"detail\": {\"jump\": 0.1, \"beyond\": 3}}, {\"model\": \"free.npz\", \"free\": true, "
       "\"position\": [0, 2, 0]",
       "condensed bodies touch no others"},
      {"\"error\": 0.1}, {\"model\": \"free.npz\", \"free\": true, \"position\": [0, 2, 0]",
       "bodies[0].error: condensed"},
      {"\"error\": 0.1}], \"obstacles\": [{\"shape\": \"box\", \"size\": [1, 1, 1], \"centre\": "
       "[0, 0, -9]",
       "bodies[0].error: condensed bodies touch no others and no obstacles with faces"},
      {"\"error\": 0.1, \"collide\": false}, {\"model\": \"free.npz\", \"free\": true, "
       "\"position\": [0, 2, 0]",
       NULL},
      {"\"rank\": 4, \"detail\": {\"jump\": 0.1, \"beyond\": 3}", NULL},
  };
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    char text[400];
    snprintf(text, sizeof text,
             "{\"time\": 0.1, \"bodies\": [{" SWING ", %s}], \"outputs\": {\"accept_error\": 1}}",
             cases[n][0]);
    assert_true(text_file_write(in_folder("scene.json"), text));
    program_result run = thrum_run(folder, "simulate", "scene.json", "-o", "none", "-q", NULL);

    // a lower rank is a model of its own, whose coordinates may follow
    assert_int_equal(run.exit_code, cases[n][1] != NULL ? 1 : 0);
    if (cases[n][1] != NULL && strstr(run.err, cases[n][1]) == NULL)
      fail_msg("case %zu: %s", n, run.err);
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_budget_is_kept_and_found_once),
      cmocka_unit_test(an_error_and_a_budget_go_together),
      cmocka_unit_test(bodies_that_lack_the_same_share_a_warning),
      cmocka_unit_test(a_level_of_detail_is_recorded),
      cmocka_unit_test(what_cannot_be_is_refused_by_its_line),
  };
  return cmocka_run_group_tests(tests, make_model, remove_folder);
}
