/* Tests of models by name: they are found, made once, kept, and made again when damaged.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>

#include "driver/make/named_model.h"
#include "io/file.h"
#include "tests/support/model_folder.h"
#include "tests/support/test_folder.h"

static const char *const names[MODEL_NAME_COUNT] = {
#define X(name, text) #name,
    MODEL_NAME_LIST(X)
#undef X
};

static char models[128], cache[128];

static int make_models(void **state) {
  char path[192];
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;
  snprintf(models, sizeof models, "%s/models", folder);
  snprintf(cache, sizeof cache, "%s/cache", folder);
  if (mkdir(models, 0777) != 0 || setenv("THRUM_MODELS", models, 1) != 0 ||
      setenv("XDG_CACHE_HOME", cache, 1) != 0)
    return -1;
  snprintf(path, sizeof path, "%s/beam.msh", models);
  if (!write_bar(path))
    return -1;
  snprintf(path, sizeof path, "%s/beam.json", models);
  return write_bar_recipe(path, "1e6") ? 0 : -1;
}

static int remove_models(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

/* Returns the line of JSON of a run that must succeed, and whether it precomputed the model. */
static cJSON *json_of(program_result run, bool *precomputed) {
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  if (precomputed != NULL)
    *precomputed = strstr(run.err, "precomputing beam") != NULL;
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

/* Gives the path of the only file in the cache; returns how many files there are. */
static int cached_file(char path[512]) {
  char place[192];
  int count = 0;
  snprintf(place, sizeof place, "%s/thrum", cache);
  DIR *entries = opendir(place);
  if (entries == NULL)
    return 0;
  for (const struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
    if (entry->d_name[0] == '.')
      continue;
    snprintf(path, 512, "%s/%.255s", place, entry->d_name);
    count++;
  }
  closedir(entries);
  return count;
}

static void a_name_is_precomputed_once(void **state) {
  (void)state;
  char path[512];
  bool precomputed = false;
  cJSON *first = json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed);
  assert_true(precomputed);
  assert_int_equal(cached_file(path), 1);
  cJSON *second = json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed);
  assert_false(precomputed);
  assert_true(json_value(first, "rank") == 5);
  assert_string_equal(cJSON_GetObjectItem(first, "model")->valuestring, path);
  assert_string_equal(cJSON_GetObjectItem(second, "model")->valuestring, path);
  cJSON_Delete(first);
  cJSON_Delete(second);
}

static void a_damaged_cache_is_made_again(void **state) {
  (void)state;
  char path[512];
  bool precomputed = false;

  // the first run fills the cache
  cJSON_Delete(json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL));
  assert_int_equal(cached_file(path), 1);

  // a few bytes are overwritten in the middle of the file
  FILE *file = fopen(path, "r+b");
  assert_non_null(file);
  assert_int_equal(fseek(file, 900, SEEK_SET), 0);
  fputs("damage", file);
  assert_int_equal(fclose(file), 0);
  cJSON_Delete(json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed));
  assert_true(precomputed);

  // a file that is cut short is made again as well, and then kept
  assert_int_equal(truncate(path, 100), 0);
  cJSON_Delete(json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed));
  assert_true(precomputed);
  cJSON_Delete(json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed));
  assert_false(precomputed);
}

static void another_recipe_is_another_model(void **state) {
  (void)state;
  char path[192];
  bool precomputed = false;

  // the model of the recipe, and that of the recipe with four times the stiffness
  cJSON *before = json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL);
  snprintf(path, sizeof path, "%s/beam.json", models);
  assert_true(write_bar_recipe(path, "4e6"));
  cJSON *after = json_of(thrum_run(folder, "info", "beam", "--json", NULL), &precomputed);
  assert_true(precomputed);

  // four times the stiffness is twice the frequency
  const cJSON *soft = cJSON_GetObjectItem(before, "frequencies_hz");
  const cJSON *stiff = cJSON_GetObjectItem(after, "frequencies_hz");
  const double ratio =
      cJSON_GetArrayItem(stiff, 0)->valuedouble / cJSON_GetArrayItem(soft, 0)->valuedouble;
  assert_true(ratio > 2 - 1e-9 && ratio < 2 + 1e-9);

  cJSON_Delete(before);
  cJSON_Delete(after);
  assert_true(write_bar_recipe(path, "1e6"));
}

/* Writes the recipe of the short bar with an order of its tetrahedra. */
static bool write_ordered_recipe(const char *path, const char *order) {
  char text[256];
  snprintf(text, sizeof text,
           "{\"order\": %s, \"material\": {\"young\": 1e6, \"poisson\": 0.3, \"density\": 1000}, "
           "\"fix\": \"x<0.001\", \"modes\": 3, \"rank\": 5}",
           order);
  return text_file_write(path, text);
}

static void a_recipe_says_the_order_of_the_tetrahedra(void **state) {
  (void)state;
  char path[192];
  snprintf(path, sizeof path, "%s/beam.json", models);

  // a bar of linear tetrahedra in the file, and of ten nodes by its recipe
  cJSON *linear = json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL);
  assert_true(write_ordered_recipe(path, "2"));
  cJSON *ten = json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL);
  assert_true(json_value(linear, "order") == 1 && json_value(ten, "order") == 2);

  // the mesh is checked as the model is made, whose frequencies are lower
  program_result run = thrum_run(folder, "check", "beam", "--json", NULL);
  cJSON *check = json_line(run.out);
  assert_true(json_value(check, "order") == 2);
  program_result_free(&run);
  const cJSON *stiff = cJSON_GetObjectItem(linear, "frequencies_hz");
  const cJSON *right = cJSON_GetObjectItem(ten, "frequencies_hz");
  assert_true(cJSON_GetArrayItem(right, 0)->valuedouble <
              0.8 * cJSON_GetArrayItem(stiff, 0)->valuedouble);

  // an order of the user's goes before it
  cJSON *own = json_of(thrum_run(folder, "precompute", "beam", "-o", "own.npz", "--order", "1",
                                 "--quiet", "--json", NULL),
                       NULL);
  assert_true(json_value(own, "order") == 1);

  cJSON_Delete(own);
  cJSON_Delete(check);
  cJSON_Delete(ten);
  cJSON_Delete(linear);
  assert_true(write_bar_recipe(path, "1e6"));
}

static void options_of_the_user_go_before_the_recipe(void **state) {
  (void)state;

  // the recipe's own model, and one with other options
  cJSON *own =
      json_of(thrum_run(folder, "precompute", "beam", "-o", "own.npz", "--json", NULL), NULL);
  cJSON *changed = json_of(thrum_run(folder, "precompute", "beam", "-o", "changed.npz", "--rank",
                                     "4", "--young", "4e6", "--fix", "x>0.999", "--json", NULL),
                           NULL);

  // options replace the recipe's values, and the others stay
  assert_true(json_value(own, "rank") == 5 && json_value(own, "modes") == 3);
  assert_true(json_value(changed, "rank") == 4 && json_value(changed, "modes") == 3);
  // the model is held at the other end alone
  assert_true(json_value(changed, "fixed") == 4);

  // another number of modes brings the rank that goes with it
  cJSON *modes = json_of(
      thrum_run(folder, "precompute", "beam", "-o", "m.npz", "--modes", "2", "--json", NULL), NULL);
  assert_true(json_value(modes, "rank") == 4 && json_value(modes, "modes") == 2);

  cJSON_Delete(modes);
  cJSON_Delete(own);
  cJSON_Delete(changed);
}

static void a_name_is_simulated(void **state) {
  (void)state;
  cJSON *run = json_of(thrum_run(folder, "simulate", "beam", "-o", "run", "--time", "0.3", "--load",
                                 "impulse:0,0,-1@load", "--accept-error", "100%", "--json", NULL),
                       NULL);
  assert_true(json_value(run, "simulated_s") > 0.29);
  cJSON_Delete(run);
}

static void a_file_goes_before_the_name(void **state) {
  (void)state;
  cJSON_Delete(
      json_of(thrum_run(folder, "precompute", "beam:4x1x1@1x0.2x0.2", "--order", "1", "--fix",
                        "x<0.001", "--modes", "2", "--rank", "3", "-o", "beam", "--json", NULL),
              NULL));
  cJSON *about = json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL);
  assert_true(json_value(about, "rank") == 3);
  assert_string_equal(cJSON_GetObjectItem(about, "model")->valuestring, "beam");
  cJSON_Delete(about);
  char path[192];
  snprintf(path, sizeof path, "%s/beam", folder);
  assert_int_equal(unlink(path), 0);
}

static void a_file_that_hides_a_name_and_is_no_model_is_said_to_hide_it(void **state) {
  (void)state;
  char path[192];
  snprintf(path, sizeof path, "%s/beam", folder);
  assert_true(text_file_write(path, "a program, say"));
  program_result run = thrum_run(folder, "info", "beam", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "it hides the model of that name"));
  program_result_free(&run);
  assert_int_equal(unlink(path), 0);
}

/* Such a folder is left by an earlier run: simulate beam -o beam. */
static void a_folder_of_that_name_is_no_model(void **state) {
  (void)state;
  char path[192];
  snprintf(path, sizeof path, "%s/beam", folder);
  assert_int_equal(mkdir(path, 0755), 0);
  cJSON *about = json_of(thrum_run(folder, "info", "beam", "--json", NULL), NULL);
  assert_true(json_value(about, "rank") == 5);
  cJSON_Delete(about);
  assert_int_equal(rmdir(path), 0);
}

static void the_folder_of_models_may_be_named(void **state) {
  (void)state;
  program_result none = thrum_run(folder, "--models-dir", "nowhere", "info", "beam", NULL);
  assert_int_equal(none.exit_code, 1);
  assert_non_null(strstr(none.err, "nowhere is not a folder"));
  assert_true(line_count_is(none.err, 1));
  program_result_free(&none);
  program_result other = thrum_run(folder, "--models-dir=models", "info", "beam", "--json", NULL);
  assert_int_equal(other.exit_code, 0);
  program_result_free(&other);
  program_result missing = thrum_run(folder, "info", "horse", NULL);
  assert_int_equal(missing.exit_code, 1);
  assert_non_null(strstr(missing.err, "horse.json"));
  program_result_free(&missing);
}

static void a_recipe_that_is_none_is_refused(void **state) {
  (void)state;

  // texts that are empty, no object, incomplete, of wrong types or out of range
  static const char *const wrong[] = {
      "",
      "[1]",
      "{\"material\": {\"young\": 1}}",
      "{\"material\": {\"young\": 1e6, \"poisson\": 0.3, \"density\": 1000}, "
      "\"fix\": [], \"modes\": 3, \"rank\": 5}",
      "{\"material\": {\"young\": 1e6, \"poisson\": 0.3, \"density\": 1000}, "
      "\"fix\": \"x<0.1\", \"modes\": 0, \"rank\": 5}",
      "{\"order\": 3, \"material\": {\"young\": 1e6, \"poisson\": 0.3, \"density\": 1000}, "
      "\"fix\": \"x<0.1\", \"modes\": 3, \"rank\": 5}"};

  // each is refused in one line that names the file
  char path[192];
  snprintf(path, sizeof path, "%s/heart.json", models);
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    assert_true(text_file_write(path, wrong[n]));
    program_result run = thrum_run(folder, "precompute", "heart", "-o", "heart.npz", NULL);
    assert_int_equal(run.exit_code, 1);
    assert_non_null(strstr(run.err, "heart.json"));
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

/* Reads NAME.json of the source tree. */
static cJSON *source_recipe(const char *name) {
  char path[512];
  void *text = NULL;
  size_t size = 0;
  snprintf(path, sizeof path, "%s/../../models/%s.json", THRUM_TEST_DATA, name);
  assert_int_equal(thrum_file_read(path, &text, &size, NULL), THRUM_OK);
  cJSON *recipe = cJSON_ParseWithLength(text, size);
  assert_non_null(recipe);
  free(text);
  return recipe;
}

static void every_model_of_ours_is_what_its_recipe_says(void **state) {
  (void)state;

  // the recipes of the source tree, not those of this test
  assert_int_equal(unsetenv("THRUM_MODELS"), 0);

  // each recipe is precomputed
  for (int n = 0; n < MODEL_NAME_COUNT; n++) {
    const char *name = names[n];
    cJSON *recipe = source_recipe(name);
    const cJSON *split = cJSON_GetObjectItem(recipe, "split");
    cJSON *made = json_of(
        thrum_run(folder, "precompute", name, "-o", "ours.npz", "--quiet", "--json", NULL), NULL);

    // the model has the sizes and the time step of its recipe
    assert_string_equal(cJSON_GetObjectItem(recipe, "name")->valuestring, name);
    assert_true(json_value(made, "modes") == json_value(recipe, "modes"));
    assert_true(json_value(made, "rank") == json_value(recipe, "rank"));
    assert_true(json_value(made, "dt") == json_value(recipe, "dt"));
    const cJSON *order = cJSON_GetObjectItem(recipe, "order");
    assert_true(json_value(made, "order") == (order != NULL ? order->valuedouble : 1));
    cJSON_Delete(made);

    // with the basis of the thesis it splits as there
    char rank[16];
    snprintf(rank, sizeof rank, "%.0f", json_value(split, "rank"));
    made = json_of(thrum_run(folder, "precompute", name, "--selection", "mass", "--rank", rank,
                             "-o", "ours.npz", "--quiet", "--json", NULL),
                   NULL);
    assert_true(json_value(made, "explicit_modes") == json_value(split, "explicit"));
    assert_true(json_value(made, "implicit_modes") == json_value(split, "implicit"));

    cJSON_Delete(recipe);
    cJSON_Delete(made);
  }
  assert_int_equal(setenv("THRUM_MODELS", models, 1), 0);
}

/* Whatever the umask: the folder and the models in it are for the user alone. */
static void the_cache_is_of_the_user_alone(void **state) {
  (void)state;
  char path[512];
  struct stat status;
  snprintf(path, sizeof path, "%s/thrum", cache);
  assert_int_equal(stat(path, &status), 0);
  assert_int_equal(status.st_mode & 0777, 0700);

  // each file in it
  int files = 0;
  DIR *all = opendir(path);
  assert_non_null(all);
  for (const struct dirent *entry = readdir(all); entry != NULL; entry = readdir(all)) {
    snprintf(path, sizeof path, "%s/thrum/%s", cache, entry->d_name);
    if (stat(path, &status) != 0 || !S_ISREG(status.st_mode))
      continue;
    files++;
    if ((status.st_mode & 0777) != 0600)
      fail_msg("%s has the mode %o", path, (unsigned)status.st_mode & 0777);
  }
  closedir(all);
  assert_true(files > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_name_is_precomputed_once),
      cmocka_unit_test(a_damaged_cache_is_made_again),
      cmocka_unit_test(another_recipe_is_another_model),
      cmocka_unit_test(a_recipe_says_the_order_of_the_tetrahedra),
      cmocka_unit_test(options_of_the_user_go_before_the_recipe),

      // where a name is taken as one, and what is refused
      cmocka_unit_test(a_name_is_simulated),
      cmocka_unit_test(a_file_goes_before_the_name),
      cmocka_unit_test(a_file_that_hides_a_name_and_is_no_model_is_said_to_hide_it),
      cmocka_unit_test(a_folder_of_that_name_is_no_model),
      cmocka_unit_test(the_folder_of_models_may_be_named),
      cmocka_unit_test(a_recipe_that_is_none_is_refused),

      cmocka_unit_test(every_model_of_ours_is_what_its_recipe_says),
      cmocka_unit_test(the_cache_is_of_the_user_alone),
  };
  return cmocka_run_group_tests(tests, make_models, remove_models);
}
