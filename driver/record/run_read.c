/* Reads the folder of a finished run back. SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_read.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/plain_text.h"
#include "driver/make/named_model.h"
#include "driver/model/basis_estimate.h"
#include "driver/model/model_hash.h"
#include "driver/record/run_entries.h"
#include "driver/record/run_folder.h"
#include "io/json.h"
#include "io/npy_file.h"
#include "io/paths.h"
#include "io/report.h"
#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

#define FOLDERS_UP 32 /* above a run, in which files that it names are looked for */

void recorded_path_join(recorded_path path, const char *folder, const char *name) {
  snprintf(path, sizeof(recorded_path), "%.*s%s%.250s", RUN_PATH_MAX, folder,
           folder[strlen(folder) - 1] == '/' ? "" : "/", name);
}

bool recorded_folder_holds(const char *folder, const char *const *names, size_t count,
                           const char *path) {
  bool holds = false;
  for (size_t n = 0; n < count && !holds; n++) {
    recorded_path file;
    recorded_path_join(file, folder, names[n]);
    holds = path_same_file(path, file);
  }
  return holds;
}

bool is_run_folder(const char *path) {
  return run_entries_finished(path, RUN_OF_BODY);
}

thrum_status recorded_folder_check(const char *path, const char *or_else, thrum_error *error) {
  struct stat info;
  model_recipe recipe = {0};
  const bool named = model_recipe_find(path, &recipe, NULL) >= 0 && recipe.found;
  if (named || stat(path, &info) != 0 || !S_ISDIR(info.st_mode) ||
      run_entries_finished(path, RUN_OF_BODY) || run_entries_finished(path, RUN_OF_SCENE))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "%.250s is a folder without a finished run: name one that thrum simulate "
                         "wrote%s",
                         path, or_else);
}

void recorded_run_free(recorded_run *run) {
  thrum_model_destroy(run->model);
  free(run->model_path);
  free(run->times);
  free(run->q);
  free(run->energies);
  free(run->places);
  *run = (recorded_run){0};
}

bool recorded_run_holds(const char *folder, const recorded_run *run, const char *path) {
  static const char *const names[] = {RUN_JSON, "energy.csv", "q.npy", RUN_PLACEMENTS};
  return recorded_folder_holds(folder, names, sizeof names / sizeof *names, path) ||
         path_same_file(path, run->model_path);
}

/* The times and energies of energy.csv, one for each row of q. */
static thrum_status read_energies(const char *folder, recorded_run *run, thrum_error *error) {
  recorded_path path;
  thrum_text text = {0};
  recorded_path_join(path, folder, "energy.csv");
  THRUM_TRY(thrum_text_open(path, 0, ',', &text, error));

  // the times belong to the rows of q, which are counted already
  thrum_status status = thrum_reserve(&run->times, run->rows, sizeof *run->times, path, error);
  THRUM_THEN(status,
             thrum_reserve(&run->energies, 2 * run->rows, sizeof *run->energies, path, error));
  int64_t rows = 0;

  thrum_text_next_line(&text); // names

  // a time that does not ascend or a row too many means a damaged file
  while (status >= 0 && thrum_text_next_line(&text)) {
    double step = 0, time = 0, kinetic = 0, strain = 0;
    status = thrum_text_number(&text, "the step", &step);
    THRUM_THEN(status, thrum_text_number(&text, "the time", &time));
    THRUM_THEN(status, thrum_text_number(&text, "the kinetic energy", &kinetic));
    THRUM_THEN(status, thrum_text_number(&text, "the strain energy", &strain));
    if (status >= 0 && (rows == run->rows || (rows > 0 && !(time > run->times[rows - 1]))))
      status = thrum_text_fail(&text, THRUM_BAD_VALUE,
                               "the times do not go with the %" PRId64 " rows of q.npy", run->rows);
    if (status < 0)
      break;

    // energies lie in pairs: kinetic, and of strain
    run->times[rows] = time;
    run->energies[2 * rows] = kinetic;
    run->energies[2 * rows + 1] = strain;
    rows++;
  }

  // a file that ends early is damaged as well
  if (status >= 0 && rows != run->rows)
    status = thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: %" PRId64 " times, but q.npy has %" PRId64 " rows", path,
                             rows, run->rows);

  thrum_text_close(&text);
  return status;
}

/* A file that cannot be read may be the one: who asked reads it again, and says why it fails. */
static bool has_hash(const char *path, const model_hash *hash) {
  bool same = false;
  return model_hash_matches(path, NULL, hash, &same, NULL) < 0 || same;
}

/* Is it there, and no folder? */
static bool is_file(const char *path) {
  struct stat info;
  return stat(path, &info) == 0 && !S_ISDIR(info.st_mode);
}

/* Whether two paths are those of one folder; so are those at which there is none. */
static bool same_folder(const char *left, const char *right) {
  struct stat one, other;
  return stat(left, &one) != 0 || stat(right, &other) != 0 ||
         (one.st_dev == other.st_dev && one.st_ino == other.st_ino);
}

/* Where a run's file may be, and what is found there. */
typedef struct file_search {
  const model_hash *hash; /* NULL: of any file */
  recorded_path first;
  char *path;
} file_search;

/* Looks at the file in `path`: true where it is the one. The first with another hash is kept. */
static bool is_found(file_search *of) {
  if (!is_file(of->path))
    return false;
  if (of->hash == NULL || has_hash(of->path, of->hash))
    return true;
  if (of->first[0] == 0)
    memcpy(of->first, of->path, sizeof of->first);
  return false;
}

const char *recorded_run_find(const char *folder, const char *name, const model_hash *hash,
                              recorded_path path) {
  if (is_file(name) && (hash == NULL || has_hash(name, hash)))
    return name;

  // the run was made in one of the folders above its own, where its path is a relative one
  file_search of = {.hash = hash, .path = path};
  recorded_path above, next;
  snprintf(above, sizeof above, "%s", folder);
  for (int up = 0; up <= FOLDERS_UP && name[0] != '/'; up++) {
    const int length = snprintf(path, sizeof(recorded_path), "%s/%s", above, name);
    if (length < (int)sizeof(recorded_path) && is_found(&of))
      return path;
    if (snprintf(next, sizeof next, "%s/..", above) >= (int)sizeof next || same_folder(above, next))
      break;
    memcpy(above, next, sizeof above);
  }

  // or it was moved together with what it names
  const int length = snprintf(path, sizeof(recorded_path), "%s/../%s", folder, path_basename(name));
  if (length < (int)sizeof(recorded_path) && is_found(&of))
    return path;

  // what has the name and is not the one is for the caller to refuse
  if (is_file(name) || of.first[0] == 0)
    return name;
  memcpy(path, of.first, sizeof of.first);
  return path;
}

/* Finds the model that the run names; `path` has room for where it is. */
static thrum_status find_model(const char *folder, const char **name, const model_hash *hash,
                               recorded_path path, thrum_error *error) {
  const char *found = recorded_run_find(folder, *name, hash, path);
  model_recipe recipe = {0};
  const bool ours = model_recipe_find(found, &recipe, NULL) >= 0 && recipe.found;
  if (thrum_mesh_is_named(found))
    return thrum_error_set(error, THRUM_MISSING,
                           "%.150s is a run of the mesh %.150s, and the model that was made of it "
                           "is not known: simulate again",
                           folder, found);
  if (!is_file(found) && !ours)
    return thrum_error_set(error, THRUM_MISSING,
                           "%.150s was made with the model %.150s, which is neither here nor above "
                           "the run nor beside it: put it there",
                           folder, found);
  *name = found;
  return THRUM_OK;
}

/* Refuses the model of another run, or the same name; `model` is what was loaded from the file. */
static thrum_status check_model(const char *folder, const char *path, const thrum_model *model,
                                const model_hash *hash, thrum_error *error) {
  bool same = false;
  THRUM_TRY(model_hash_matches(path, model, hash, &same, error));
  if (same)
    return THRUM_OK;
  return thrum_error_set(
      error, THRUM_BAD_VALUE,
      "%.150s is not the model that %.150s was made with: put that one beside the run (%s); thrum "
      "export takes it by --model FILE as well",
      path, folder,
      hash->arrays != 0 ? "made again from the same mesh by the same options it is the same"
                        : "made again with precompute --reproducible it is the same");
}

thrum_status recorded_model_load(const char *folder, const char *name, const model_hash *hash,
                                 bool given, const thrum_model **model, char **model_path,
                                 thrum_error *error) {
  recorded_path path;
  named_model_file file;
  if (!given)
    THRUM_TRY(find_model(folder, &name, hash, path, error));
  THRUM_TRY(named_model_load(name, true, model, &file, error));
  *model_path = strdup(file.path);
  if (*model_path == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.200s", file.path);

  // a model of that name that is another one would show another motion
  return check_model(folder, file.path, *model, hash, error);
}

/* The texts of run.json that matter here; the object is the caller's to delete. */
static thrum_status read_json(const char *folder, cJSON **object, const char **model,
                              model_hash *hash, thrum_error *error) {
  recorded_path path;
  recorded_path_join(path, folder, RUN_JSON);
  THRUM_TRY(json_file_read(path, object, error));
  // a mesh is named beside the model that was made of it
  *model = json_text_of(*object, "model_file");
  *model = *model != NULL ? *model : json_text_of(*object, "model");
  if (*model == NULL || !model_hash_read(*object, hash))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: not the run.json of a `thrum simulate`", path);
  return THRUM_OK;
}

/* The coordinates, a row for each time; run.json, the object, says how many were recorded. */
static thrum_status read_q(const char *folder, const cJSON *object, recorded_run *run,
                           thrum_error *error) {
  recorded_path path;
  recorded_path_join(path, folder, "q.npy");
  THRUM_TRY(thrum_npy_read_f8(path, &run->q, &run->rows, &run->rank, error));

  // a file with other columns is not the one that this run wrote
  const cJSON *rank = cJSON_GetObjectItemCaseSensitive(object, "rank");
  if (cJSON_IsNumber(rank) && rank->valuedouble != (double)run->rank)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.200s has %" PRId64 " columns, but the run recorded %g coordinates: "
                           "simulate again",
                           path, run->rank, rank->valuedouble);

  // the rank of the model is at least that of the run, which may have stepped fewer coordinates
  if (run->rows < 1 || run->rank < 1 || run->rank > run->model->rank)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.200s: %" PRId64 " x %" PRId64 " do not go with a model of rank %d",
                           path, run->rows, run->rank, (int)run->model->rank);

  for (int64_t n = 0; n < run->rows * run->rank; n++) {
    if (!isfinite(run->q[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "%.200s: row %" PRId64 " is not finite", path,
                             n / run->rank + 1);
  }
  return THRUM_OK;
}

/* "at least 12 % of the motion is wrong by the basis", or why that is not known. */
static void read_error(const cJSON *object, recorded_run *run) {
  static const char wrong[] = BASIS_ESTIMATE_WRONG " is wrong by the basis" BASIS_ESTIMATE_WITHIN;
  static const char unknown[] = "the basis is not judged: {error_estimate.why}";
  if (!report_text(object, NULL, wrong, run->error, sizeof run->error) &&
      !report_text(object, NULL, unknown, run->error, sizeof run->error))
    run->error[0] = 0;
  thrum_plain_text(run->error);
}

thrum_status recorded_run_read(const char *path, const char *model, recorded_run *run,
                               thrum_error *error) {
  // a light grey where the run names no colour
  recorded_run read = {.place = {.colour = {0.81, 0.85, 0.9}}};
  cJSON *object = NULL;
  const char *named = NULL;
  model_hash hash = {0};
  thrum_status status = read_json(path, &object, &named, &hash, error);

  // the model that run.json names, or another that the caller gives
  if (status >= 0)
    status = recorded_model_load(path, model != NULL ? model : named, &hash, model != NULL,
                                 &read.model, &read.model_path, error);

  // "imexv, switched to energy after 24 steps"
  const char *stepped_by = json_text_of(object, "stepped_by");
  snprintf(read.stepped_by, sizeof read.stepped_by, "%s", stepped_by != NULL ? stepped_by : "");

  read_error(object, &read);

  const cJSON *options = cJSON_GetObjectItemCaseSensitive(object, "options");
  read.full = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(options, "full"));
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const cJSON *loads = cJSON_GetObjectItemCaseSensitive(work, "load_j");
  read.load_work = cJSON_IsNumber(loads) ? loads->valuedouble : NAN;

  // a body of a scene may be placed, and may move as a whole
  const cJSON *placement = cJSON_GetObjectItemCaseSensitive(object, "placement");
  const bool moves = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(placement, "free"));
  THRUM_THEN(status, run_placement_read(path, object, &read.place, error));

  // the series: coordinates, times and places
  if (status >= 0 && read.model->basis == NULL)
    status = thrum_error_set(error, THRUM_MISSING,
                             "the model has no basis, so nothing can be "
                             "shown");
  THRUM_THEN(status, read_q(path, object, &read, error));
  cJSON_Delete(object);
  THRUM_THEN(status, read_energies(path, &read, error));
  recorded_path places;
  recorded_path_join(places, path, RUN_PLACEMENTS);
  if (status >= 0 && moves)
    status = run_placements_read(places, read.rows, &read.places, error);

  if (status < 0)
    recorded_run_free(&read);
  else
    *run = read;
  return status;
}

/* Refuses a series that is not there. */
static thrum_status check_series(const char *folder, const char *name, thrum_error *error) {
  recorded_path path;
  recorded_path_join(path, folder, name);
  if (is_file(path) && access(path, R_OK) == 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "%.300s is not there, or cannot be read: simulate again", path);
}

thrum_status recorded_run_check(const char *folder, thrum_error *error) {
  recorded_path path;
  cJSON *object = NULL;
  const char *model = NULL;
  model_hash hash = {0};
  thrum_status status = read_json(folder, &object, &model, &hash, error);
  THRUM_THEN(status, check_series(folder, "q.npy", error));
  THRUM_THEN(status, check_series(folder, "energy.csv", error));
  const cJSON *placement = cJSON_GetObjectItemCaseSensitive(object, "placement");
  if (cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(placement, "free")))
    THRUM_THEN(status, check_series(folder, RUN_PLACEMENTS, error));

  // a model that comes with Thrum is made where it is needed, and a file is there or not
  THRUM_THEN(status, find_model(folder, &model, &hash, path, error));
  if (status >= 0 && is_file(model))
    status = check_model(folder, model, NULL, &hash, error);
  cJSON_Delete(object);
  return status;
}

bool recorded_run_keeps(const recorded_run *run, int64_t n, int64_t kept, double rate) {
  return n + 1 >= run->rows || run->times[n] >= run->times[0] + (double)kept / rate * (1 - 1e-9);
}

void recorded_run_thin(recorded_run *run, double rate) {
  if (!(rate > 0))
    return;
  int64_t kept = 0;
  for (int64_t n = 0; n < run->rows; n++) {
    if (!recorded_run_keeps(run, n, kept, rate))
      continue;

    // kept rows move to the front of each series
    run->times[kept] = run->times[n];
    memmove(run->q + kept * run->rank, run->q + n * run->rank, (size_t)run->rank * sizeof *run->q);
    memmove(run->energies + 2 * kept, run->energies + 2 * n, 2 * sizeof *run->energies);
    if (run->places != NULL)
      memmove(run->places + RUN_PLACEMENT_COLUMNS * kept, run->places + RUN_PLACEMENT_COLUMNS * n,
              RUN_PLACEMENT_COLUMNS * sizeof *run->places);
    kept++;
  }

  run->rows = kept;
}
