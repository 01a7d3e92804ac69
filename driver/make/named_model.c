/* The models that come with Thrum: where they lie, what their recipes say, and their cache.
 *
 * A cached file is named after a 64-bit FNV-1a hash of the mesh's bytes, the recipe and the build,
 * so that it is never out of date; it is written beside its place and renamed.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/named_model.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "config/message.h"
#include "driver/make/precompute_make.h"
#include "io/file.h"
#include "io/file_hash.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/surface_read.h"
#include "precompute/build_info.h"
#include "thrum/version.h"

#define BASIS_EDITION 2    /* counted up where the same options make another basis */
#define TOUCH_RANK_MAX 100 /* the most that the rank grows to with touch modes; none takes more */

static bool is_folder(const char *path) {
  struct stat status;
  return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

static thrum_status find_folder(const char *name, char path[NAMED_MODEL_PATH_MAX],
                                thrum_error *error) {
  const char *given = getenv("THRUM_MODELS");
  if (given != NULL && given[0] != 0) {
    if (strlen(given) < NAMED_MODEL_PATH_MAX && is_folder(given)) {
      snprintf(path, NAMED_MODEL_PATH_MAX, "%s", given);
      return THRUM_OK;
    }
    return thrum_error_set(error, THRUM_IO, "THRUM_MODELS: %.300s is not a folder", given);
  }

  // beside the installed program, else in the source tree that it was built from
  if (path_share("models", path, NAMED_MODEL_PATH_MAX) && is_folder(path))
    return THRUM_OK;
#ifdef THRUM_SOURCE_MODELS
  if (strlen(THRUM_SOURCE_MODELS) < NAMED_MODEL_PATH_MAX && is_folder(THRUM_SOURCE_MODELS)) {
    snprintf(path, NAMED_MODEL_PATH_MAX, "%s", THRUM_SOURCE_MODELS);
    return THRUM_OK;
  }
#endif

  return thrum_error_set(error, THRUM_IO,
                         "%s: there is no such file, and the folder of the models that come with "
                         "Thrum is not found; name it with --models-dir or THRUM_MODELS",
                         name);
}

/* A number that the recipe must hold. */
static bool take_number(const cJSON *object, const char *key, double *value) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
    return false;
  *value = item->valuedouble;
  return true;
}

static bool take_count(const cJSON *object, const char *key, int64_t *value) {
  double number = 0;
  if (!take_number(object, key, &number) || !(number >= 1) || !(number <= 1e6))
    return false;
  *value = (int64_t)number;
  return true;
}

static bool take_text(const cJSON *item, char text[MODEL_RECIPE_TEXT_MAX]) {
  if (!cJSON_IsString(item) || strlen(item->valuestring) >= MODEL_RECIPE_TEXT_MAX)
    return false;
  snprintf(text, MODEL_RECIPE_TEXT_MAX, "%s", item->valuestring);
  return true;
}

/* "fix": one SPEC or a list of them. */
static bool take_fixes(const cJSON *object, model_recipe *recipe) {
  const cJSON *fix = cJSON_GetObjectItemCaseSensitive(object, "fix"), *item = NULL;
  if (cJSON_IsString(fix)) {
    recipe->fix_count = 1;
    return take_text(fix, recipe->fixes[0]);
  }
  cJSON_ArrayForEach(item, fix) {
    if (recipe->fix_count == MODEL_RECIPE_FIXES_MAX ||
        !take_text(item, recipe->fixes[recipe->fix_count]))
      return false;
    recipe->fix_count++;
  }
  return recipe->fix_count > 0;
}

/* "load": {"group", "direction", "force"}, all of it optional. */
static bool take_load(const cJSON *object, model_recipe *recipe) {
  const cJSON *load = cJSON_GetObjectItemCaseSensitive(object, "load");
  const cJSON *group = cJSON_GetObjectItemCaseSensitive(load, "group");
  const cJSON *direction = cJSON_GetObjectItemCaseSensitive(load, "direction");
  snprintf(recipe->load_group, sizeof recipe->load_group, "load");

  // each key may be left out, but must be well formed where it stands
  if (group != NULL && !take_text(group, recipe->load_group))
    return false;
  if (cJSON_GetObjectItemCaseSensitive(load, "force") != NULL &&
      !take_number(load, "force", &recipe->load_force))
    return false;

  // the direction is three finite numbers
  for (int axis = 0; direction != NULL && axis < 3; axis++) {
    const cJSON *item = cJSON_GetArrayItem(direction, axis);
    if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
      return false;
    recipe->load_direction[axis] = item->valuedouble;
  }
  return true;
}

/* "tests": a list of loads, which may be left out. */
static bool take_tests(const cJSON *object, model_recipe *recipe) {
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(object, "tests")) {
    if (recipe->test_count == MODEL_RECIPE_TESTS_MAX ||
        !take_text(item, recipe->tests[recipe->test_count]))
      return false;
    recipe->test_count++;
  }
  return true;
}

/* "mesh": a file beside the recipe; NAME.msh when it is not said. */
static bool take_mesh(const cJSON *object, const char *folder, model_recipe *recipe) {
  const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(object, "mesh");
  char file[MODEL_RECIPE_TEXT_MAX];
  snprintf(file, sizeof file, "%s.msh", recipe->name);
  if (mesh != NULL && (!take_text(mesh, file) || strchr(file, '/') != NULL))
    return false;
  snprintf(recipe->mesh, sizeof recipe->mesh, "%.*s/%s", NAMED_MODEL_PATH_MAX - 80, folder, file);
  return true;
}

/* "split": of the thesis, and the rank it is of; that of the model where it is not said. */
static bool take_split(const cJSON *object, model_recipe *recipe) {
  const cJSON *split = cJSON_GetObjectItemCaseSensitive(object, "split");
  recipe->thesis_rank = recipe->rank;
  return cJSON_GetObjectItemCaseSensitive(split, "rank") == NULL ||
         take_count(split, "rank", &recipe->thesis_rank);
}

/* "order": of the tetrahedra, 1 or 2; auto when it is not said. */
static bool take_order(const cJSON *object, int *order) {
  double number = 0;
  if (cJSON_GetObjectItemCaseSensitive(object, "order") == NULL)
    return true;
  if (!take_number(object, "order", &number) || (number != 1 && number != 2))
    return false;
  *order = (int)number;
  return true;
}

static const char *take_recipe(const cJSON *object, const char *folder, model_recipe *recipe) {
  const cJSON *material = cJSON_GetObjectItemCaseSensitive(object, "material");

  // what precompute is given; the first fault is the one that is said
  if (!take_mesh(object, folder, recipe))
    return "mesh wants the name of a file in the same folder";
  if (!take_order(object, &recipe->order))
    return "order wants 1 or 2";
  if (!take_number(material, "young", &recipe->material.young) ||
      !take_number(material, "poisson", &recipe->material.poisson) ||
      !take_number(material, "density", &recipe->material.density))
    return "material wants young, poisson and density";
  if (!take_fixes(object, recipe))
    return "fix wants one SPEC or a few, as --fix takes them";
  if (!take_count(object, "modes", &recipe->modes) || !take_count(object, "rank", &recipe->rank))
    return "modes and rank want whole numbers from 1";
  if (!take_split(object, recipe))
    return "the rank of split wants a whole number from 1";

  // loads for the runs of the model
  if (!take_load(object, recipe))
    return "load wants a group, a direction of three numbers and a force";
  if (!take_tests(object, recipe))
    return "tests wants a few loads, as --load takes them";
  return NULL;
}

static thrum_status read_recipe(const char *folder, model_recipe *recipe, thrum_error *error) {
  char path[NAMED_MODEL_PATH_MAX + MODEL_RECIPE_TEXT_MAX];
  snprintf(path, sizeof path, "%s/%s.json", folder, recipe->name);
  cJSON *object = NULL;
  THRUM_TRY(json_file_read(path, &object, error));

  // the first fault names the file; the texts are copied, so the object can go
  const char *wrong = object == NULL ? "it is no JSON" : take_recipe(object, folder, recipe);
  cJSON_Delete(object);
  if (wrong != NULL)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%.250s: %s", path, wrong);
  return THRUM_OK;
}

thrum_status model_recipe_find(const char *text, model_recipe *recipe, thrum_error *error) {
  char folder[NAMED_MODEL_PATH_MAX];
  model_recipe found = {0};

  // a file of that name comes first; a folder is no model, and may well be of an earlier run
  const bool file = access(text, F_OK) == 0 && !is_folder(text);
  for (int n = 0; n < MODEL_NAME_COUNT; n++)
    if (strcmp(text, model_names[n]) == 0 && !file)
      found.name = model_names[n];

  // any other text is the caller's to understand
  found.found = found.name != NULL;
  if (!found.found) {
    *recipe = found;
    return THRUM_OK;
  }

  // the caller's recipe changes only when all of it could be read
  THRUM_TRY(find_folder(text, folder, error));
  THRUM_TRY(read_recipe(folder, &found, error));
  *recipe = found;
  return THRUM_OK;
}

void model_recipe_read(const model_recipe *recipe, thrum_mesh_read_options *reading) {
  if (reading->order == 0)
    reading->order = recipe->order;
}

void model_recipe_apply(const model_recipe *recipe, precompute_request *request) {
  thrum_material *material = &request->material;

  // values of the user's go before the recipe's
  request->mesh_name = recipe->mesh;
  request->order_of_recipe = request->reading.order == 0 && recipe->order != 0;
  model_recipe_read(recipe, &request->reading);
  if (isnan(material->young))
    material->young = recipe->material.young;
  if (isnan(material->poisson))
    material->poisson = recipe->material.poisson;
  if (isnan(material->density))
    material->density = recipe->material.density;

  // a fixed set of the user's own replaces the recipe's
  if (request->fix_count == 0)
    for (int64_t n = 0; n < recipe->fix_count; n++)
      request->fixes[request->fix_count++] = recipe->fixes[n];

  if (!request->modes_given)
    request->options.modes = recipe->modes;
  if (recipe->thesis)
    request->options.selection = THRUM_SELECTION_MASS;
  // other modes want another rank
  if (!request->rank_given && !request->modes_given)
    request->options.rank = recipe->thesis ? recipe->thesis_rank : recipe->rank;
}

/* The hash of everything that the model file's bytes depend on. */
static thrum_status hash_recipe(const model_recipe *recipe, uint64_t *hash, thrum_error *error) {
  char text[512];
  void *mesh = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_read(recipe->mesh, &mesh, &size, error));

  // the mesh by its bytes, not by its name or date
  uint64_t value = hash_bytes(0, mesh, size);
  free(mesh);

  // versions and the compiler, because other code may round differently
  const int length = snprintf(
      text, sizeof text,
      "%s|%d.%d|%.120s|%.60s|%d|%.17g|%.17g|%.17g|%" PRId64 "|%" PRId64 "%s%s|%d", thrum_version(),
      THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR, thrum_build_compiler(),
      thrum_build_blas_core(), recipe->order, recipe->material.young, recipe->material.poisson,
      recipe->material.density, recipe->modes, recipe->thesis ? recipe->thesis_rank : recipe->rank,
      recipe->touch ? "|touch" : "", recipe->thesis ? "|thesis" : "", BASIS_EDITION);
  value = hash_bytes(value, text, (size_t)length);

  for (int64_t n = 0; n < recipe->fix_count; n++)
    value = hash_bytes(value, recipe->fixes[n], strlen(recipe->fixes[n]) + 1);
  *hash = value;
  return THRUM_OK;
}

/* Makes a folder and those above it, like mkdir -p, for the user alone, whatever the umask. */
static bool make_folders(char *path) {
  for (char *at = path + 1; *at != 0; at++) {
    if (*at != '/')
      continue;
    *at = 0;
    const bool made = mkdir(path, 0700) == 0 || errno == EEXIST;
    *at = '/';
    if (!made)
      return false;
  }
  if (mkdir(path, 0700) != 0 && errno != EEXIST)
    return false;
  chmod(path, 0700); // of an earlier version; that of another user stays as it is
  return true;
}

void named_model_keep_private(const char *path) {
  chmod(path, 0600); // that of another user stays as it is
}

thrum_status named_model_cache_folder(char path[NAMED_MODEL_PATH_MAX], thrum_error *error) {
  const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
  int length = -1;

  // the specification of XDG wants relative paths ignored
  if (cache != NULL && cache[0] == '/')
    length = snprintf(path, NAMED_MODEL_PATH_MAX, "%s/thrum", cache);
  else if (home != NULL && home[0] == '/')
    length = snprintf(path, NAMED_MODEL_PATH_MAX, "%s/.cache/thrum", home);

  // room is left for the name of a file in it
  if (length <= 0 || length >= NAMED_MODEL_PATH_MAX - 64)
    return thrum_error_set(error, THRUM_IO,
                           "there is no folder for the cache: set XDG_CACHE_HOME to a full path");

  if (!make_folders(path))
    return thrum_error_set(error, THRUM_IO,
                           "%.200s: cannot be made (%s); set XDG_CACHE_HOME to a folder that can "
                           "be written",
                           path, strerror(errno));
  return THRUM_OK;
}

static thrum_status make_cached(const model_recipe *recipe, const char *path, bool quiet,
                                thrum_error *error) {
  const char *fixes[MODEL_RECIPE_FIXES_MAX];
  bool flagged = false;
  precompute_request request = {
      .mesh_name = recipe->name,
      .output = path,
      .reading = {.scale = 1},
      .material = {NAN, NAN, NAN},
      .options = thrum_default_precompute_options(),
      .fixes = fixes,
      .touch = recipe->touch,
      .rank_max = TOUCH_RANK_MAX,
      .reproducible = true,
      .quiet = quiet,
  };

  // the first use takes a while, so the user is told why
  model_recipe_apply(recipe, &request);
  if (!quiet)
    fprintf(stderr, "thrum: precomputing %s%s, once; kept in %s\n", recipe->name,
            recipe->touch    ? " with touch modes"
            : recipe->thesis ? " with the basis of the thesis"
                             : "",
            path);
  return precompute_make(&request, NULL, &flagged, error);
}

static thrum_status load_cached(const model_recipe *recipe, bool quiet, const thrum_model **model,
                                char path[NAMED_MODEL_PATH_MAX], thrum_error *error) {
  uint64_t hash = 0;
  char folder[NAMED_MODEL_PATH_MAX];
  THRUM_TRY(hash_recipe(recipe, &hash, error));
  THRUM_TRY(named_model_cache_folder(folder, error));

  // the hash in the name makes a file of another build or mesh a different file
  snprintf(path, NAMED_MODEL_PATH_MAX, "%.*s/%s-%016" PRIx64 ".npz", NAMED_MODEL_PATH_MAX - 64,
           folder, recipe->name, hash);

  // the reader checks every byte, so a file that was cut short or damaged is made again
  const bool there = access(path, F_OK) == 0;
  if (there && thrum_model_load(path, model, NULL) >= 0)
    return THRUM_OK;
  if (there && !quiet)
    config_warn("%s is damaged and is made again", path);

  THRUM_TRY(make_cached(recipe, path, quiet, error));
  named_model_keep_private(path);
  return thrum_model_load(path, model, error);
}

/* A model file of the user's. Opening a pipe would wait for its other end, so it is refused first.
 */
static thrum_status load_file(const char *path, const thrum_model **model, thrum_error *error) {
  struct stat status;
  if (stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode))
    return thrum_error_set(error, THRUM_IO, "%.300s: is not a regular file", path);
  return thrum_model_load(path, model, error);
}

#define X(name, text) " " #name
static const char known_names[] = MODEL_NAME_LIST(X);
#undef X

/* Guesses the meaning of a text that names no model file; "" when nothing is plain. */
static void advise(const char *text, char *advice, size_t size) {
  const bool there = access(text, F_OK) == 0;
  const char *nearest = config_nearest(path_basename(text), model_names, MODEL_NAME_COUNT);
  advice[0] = 0;

  // what is there but is no model, or hides one
  if (there && nearest != NULL && strcmp(text, nearest) == 0)
    snprintf(advice, size,
             "; it hides the model of that name that comes with Thrum: move it, or work in another "
             "folder");
  else if (there && thrum_surface_mesh_is_named(text))
    snprintf(advice, size,
             "; it is a surface: fill it with thrum mesh, and make a model of that with thrum "
             "precompute");
  else if (thrum_mesh_is_named(text) && (there || strncmp(text, "beam:", 5) == 0))
    snprintf(advice, size, "; it is a mesh: make a model of it with thrum precompute");

  // what is not there is a name with a slip, or one that is not known
  else if (!there && nearest != NULL)
    snprintf(advice, size, "; did you mean '%s'?", nearest);
  else if (!there && strpbrk(text, "/.") == NULL)
    snprintf(advice, size, "; the models that come with Thrum are:%s", known_names);
}

/* What of a named model is wanted. */
typedef enum variant { USUAL, WITH_TOUCH, OF_THESIS } variant;

static thrum_status load(const char *text, variant wanted, bool quiet, const thrum_model **model,
                         named_model_file *file, thrum_error *error) {
  model_recipe recipe;
  THRUM_TRY(model_recipe_find(text, &recipe, error));
  recipe.touch = wanted == WITH_TOUCH;
  recipe.thesis = wanted == OF_THESIS;
  file->path = recipe.found ? file->cached : text;
  if (recipe.found)
    return load_cached(&recipe, quiet, model, file->cached, error);

  // a file that is no model, or is not there, is often a mistake that can be named
  thrum_error reason = {0};
  const thrum_status status = load_file(text, model, &reason);
  if (status >= 0)
    return status;
  char advice[160];
  advise(text, advice, sizeof advice);
  return thrum_error_set(error, status, "%.*s%s", advice[0] != 0 ? 239 : 399, reason.message,
                         advice);
}

thrum_status named_model_load(const char *text, bool quiet, const thrum_model **model,
                              named_model_file *file, thrum_error *error) {
  named_model_file own;
  return load(text, USUAL, quiet, model, file != NULL ? file : &own, error);
}

thrum_status named_model_load_touch(const char *text, bool quiet, const thrum_model **model,
                                    thrum_error *error) {
  named_model_file own;
  return load(text, WITH_TOUCH, quiet, model, &own, error);
}

thrum_status named_model_load_thesis(const char *text, bool quiet, const thrum_model **model,
                                     thrum_error *error) {
  named_model_file own;
  return load(text, OF_THESIS, quiet, model, &own, error);
}
