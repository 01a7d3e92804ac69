/* The keys "error", "budget" and "detail" of bodies: how many coordinates each of them steps.
 *
 * "error" and "budget" are answered by trial runs of the body alone (scene_run_trial.c). Bodies
 * that are the same share them, and what they found is kept in the folder of cached models, so that
 * the next run of the scene makes none. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_detail.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/progress.h"
#include "driver/make/named_model.h"
#include "driver/model/cache_trim.h"
#include "driver/model/step_cost.h"
#include "driver/scene/scene_run_refuse.h"
#include "driver/scene/scene_run_trial.h"
#include "driver/scene/scene_run_world.h"
#include "io/file.h"
#include "io/file_hash.h"
#include "platform/clock.h"

#define CACHE_BYTES (4 << 20)
#define CACHE_STAYS 60 /* [s] */
#define CACHE_LINE 80
#define SHORTFALL_SIZE 200
#define NAMED_MOST 3 /* bodies that a warning names */
#define NAMES_SIZE (NAMED_MOST * 110)

static const int64_t candidates[] = {2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32};
enum { CANDIDATES = sizeof candidates / sizeof candidates[0] };

/* --- one body --------------------------------------------------------------------------------- */

static bool is_sought(const scene_body_run *body) {
  return body->spec->error > 0 || body->spec->budget > 0;
}

/* Whether fewer coordinates would have the body pass through others unasked, or through obstacles
 * with faces. */
static bool would_pass(const scene_run *run, const scene_body_run *body) {
  return scene_run_body_meets(run, body) || scene_run_has_solids(run);
}

static const char passes[] =
    "condensed bodies touch no others and no obstacles with faces: say \"collide\": false of the "
    "body where there are no such obstacles, or leave this out";

void scene_run_warn_of_passing(scene_run *run) {
  int32_t count = 0, first = -1;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    thrum_scene_body_info info;
    thrum_scene_body(run->scene, n, &info, NULL);
    if (!info.condensed || !would_pass(run, &run->bodies[n]))
      continue;
    first = count++ == 0 ? n : first;
  }

  // one line, however many they are
  run->has_passing = count > 0;
  if (count == 1)
    config_warn("body '%.100s' is condensed: it passes through other bodies and obstacles with "
                "faces (precomputed with --touch-stepped in place of --touch or --condense it "
                "touches them)",
                run->bodies[first].spec->name);
  else if (count > 1)
    config_warn("body '%.100s' and %" PRId32 " more are condensed: they pass through other bodies "
                "and obstacles with faces (precomputed with --touch-stepped in place of --touch or "
                "--condense they touch them)",
                run->bodies[first].spec->name, count - 1);
}

/* Both go without what they find. */
static thrum_status check(const scene_run *run, const scene_body_run *body) {
  const char *key = body->spec->error > 0 ? "error" : "budget";
  thrum_error detail = {0};
  if (would_pass(run, body)) {
    thrum_error_set(&detail, THRUM_INVALID_ARGUMENT, "%s", passes);
    return scene_run_pass(run, &body->spec->settings.at, key, detail.status, &detail);
  }
  if (body->spec->rank == 0 && body->spec->condense == 0 && thrum_model_masters(body->model) == 0)
    return THRUM_OK;
  thrum_error_set(&detail, THRUM_INVALID_ARGUMENT,
                  "it finds how many coordinates are stepped, so leave out rank and condense, and "
                  "take a model that was not precomputed condensed");
  return scene_run_pass(run, &body->spec->settings.at, key, detail.status, &detail);
}

static double cost_of(const scene_body_run *body, int64_t masters) {
  const int64_t rank = body->model->rank;
  return step_cost(&body->def.state, masters > 0 ? masters : rank,
                   masters > 0 ? rank - masters : 0);
}

/* Whether so many masters may be tried: half of the coordinates at most, within the budget; of
 * those beyond every budget the least. */
static bool may_try(const scene_body_run *body, int c) {
  const int64_t masters = candidates[c];
  if (masters > body->model->rank / 2)
    return false;
  return c == 0 || !(body->spec->budget > 0) || cost_of(body, masters) <= body->spec->budget;
}

/* The fewest masters that err by no more than was asked for; where none does, or nothing was asked
 * for, those of the budget that err least. */
static thrum_status try_all(scene_trial *trial, const scene_body_run *body, scene_finding *finding,
                            thrum_error *error) {
  const bool within = body->spec->budget > 0;
  double best = within ? INFINITY : body->spec->error;
  finding->error = INFINITY;
  for (int c = 0; c < CANDIDATES; c++) {
    double found = INFINITY;
    if (!may_try(body, c))
      continue;
    THRUM_TRY(scene_trial_run(trial, candidates[c], fmin(best, 1e3), &found, error));
    if (!isfinite(found))
      continue;
    best = found;
    finding->masters = candidates[c];
    finding->error = found;
    if (body->spec->error > 0 && found <= body->spec->error)
      break;
  }
  return THRUM_OK;
}

/* The most masters that the budget has room for, where no motion says more. */
static int64_t most_masters(const scene_body_run *body) {
  int64_t most = 0;
  for (int c = 0; c < CANDIDATES; c++)
    if (may_try(body, c))
      most = candidates[c];
  return most;
}

static thrum_status find(const scene_run *run, int32_t n, scene_finding *finding,
                         thrum_error *error) {
  const scene_body_run *body = &run->bodies[n];
  *finding = (scene_finding){.by = SCENE_TRIED, .error = NAN};

  // all coordinates err by nothing, where a budget has room for them
  const bool affords = body->spec->budget > 0 && cost_of(body, 0) <= body->spec->budget;
  if (affords && !(body->spec->error > 0)) {
    finding->error = 0;
    return THRUM_OK;
  }
  scene_trial trial = {0};
  thrum_status status = scene_trial_open(run, n, &trial, error);
  if (status >= 0 && !(trial.size > 0))
    finding->masters = body->spec->budget > 0 && !affords ? most_masters(body) : 0;
  else
    THRUM_THEN(status, try_all(&trial, body, finding, error));
  scene_trial_close(&trial);

  // with room for all of them, all are better than too few
  if (status >= 0 && affords && !(finding->error <= body->spec->error))
    *finding = (scene_finding){.by = SCENE_TRIED};
  return status;
}

/* --- what is found once ----------------------------------------------------------------------- */

/* The file that keeps what was found, and its folder; false where there is no folder for it. */
static bool cache_path(uint64_t hash, char folder[NAMED_MODEL_PATH_MAX],
                       char path[NAMED_MODEL_PATH_MAX]) {
  if (named_model_cache_folder(folder, NULL) < 0)
    return false;
  snprintf(path, NAMED_MODEL_PATH_MAX, "%.*s/detail-%016" PRIx64 ".txt", NAMED_MODEL_PATH_MAX - 64,
           folder, hash);
  return true;
}

/* Writes the line that keeps a finding, with its checksum at the end. Returns its length. */
static int cached_line(uint64_t hash, const scene_finding *finding, char line[CACHE_LINE]) {
  const int length =
      snprintf(line, CACHE_LINE, "%" PRId64 " %.17g", finding->masters, finding->error);
  return length + snprintf(line + length, CACHE_LINE - (size_t)length, " %016" PRIx64 "\n",
                           hash_bytes(hash, line, (size_t)length));
}

static bool read_cached(const scene_body_run *body, uint64_t hash, scene_finding *finding) {
  char folder[NAMED_MODEL_PATH_MAX], path[NAMED_MODEL_PATH_MAX], line[CACHE_LINE];
  void *data = NULL;
  size_t size = 0;
  if (!cache_path(hash, folder, path) || thrum_file_read(path, &data, &size, NULL) < 0)
    return false;

  // what would not be written so, by a bit of it, is found again
  char *end = data;
  *finding = (scene_finding){.by = SCENE_CACHED, .masters = strtoll(data, &end, 10)};
  finding->error = strtod(end, NULL);
  const bool whole = size == (size_t)cached_line(hash, finding, line) &&
                     memcmp(data, line, size) == 0 && finding->masters >= 0 &&
                     finding->masters < body->model->rank;
  free(data);
  return whole;
}

/* A cache that cannot be written harms no run. */
static void write_cached(uint64_t hash, const scene_finding *finding) {
  char path[NAMED_MODEL_PATH_MAX], folder[NAMED_MODEL_PATH_MAX], line[CACHE_LINE];
  thrum_error ignored = {0};
  if (!cache_path(hash, folder, path))
    return;
  const int length = cached_line(hash, finding, line);
  if (thrum_file_write_atomic(path, line, (size_t)length, &ignored) >= 0)
    named_model_keep_private(path);
  cache_trim(folder, "detail-", CACHE_BYTES, CACHE_STAYS);
}

/* --- all bodies ------------------------------------------------------------------------------- */

/* A text that says what a body asked for and does not get; empty: it gets all. */
typedef char shortfall[SHORTFALL_SIZE];

/* A budget below the cheapest step. */
static void find_budget_shortfall(const scene_body_run *body, shortfall text) {
  const scene_body_spec *spec = body->spec;
  const int64_t masters = body->finding.masters;
  const double cost = cost_of(body, masters);
  if (spec->budget > 0 && cost > spec->budget)
    snprintf(text, SHORTFALL_SIZE,
             "a step of %" PRId64 " coordinates takes %.2g s by the model of costs, more than the "
             "budget of %.2g s: there is nothing cheaper",
             masters > 0 ? masters : body->model->rank, cost, spec->budget);
}

/* An error that no number of coordinates keeps, or none that the budget allows. */
static void find_error_shortfall(const scene_run *run, const scene_body_run *body, shortfall text) {
  const double seconds = scene_trial_seconds(run), asked = body->spec->error;
  const scene_finding *finding = &body->finding;
  if (!(asked > 0))
    return;

  // no error is known, none is small enough, or none within the budget is
  if (finding->masters == 0 && isnan(finding->error))
    snprintf(text, SHORTFALL_SIZE,
             "it stays at rest in the first %g s, or its run fails with all coordinates, so that "
             "no error is known: all of them are stepped",
             seconds);
  else if (finding->masters == 0 && finding->error > 0)
    snprintf(
        text, SHORTFALL_SIZE,
        "in the first %g s no number of coordinates errs by at most %g, so all of them are stepped",
        seconds, asked);
  else if (finding->masters > 0 && !(finding->error <= asked))
    snprintf(text, SHORTFALL_SIZE,
             "within its budget the least error in the first %g s is %.3g, more than the %g asked "
             "for",
             seconds, finding->error, asked);
}

/* One warning for all bodies from `first` on of the same text, which is taken out of `texts`. */
static void warn_of_same(const scene_run *run, shortfall *texts, int32_t first) {
  char names[NAMES_SIZE];
  int32_t same = 0;
  size_t length = 0;
  shortfall text;
  memcpy(text, texts[first], sizeof text);

  // the first few names tell which bodies these are
  for (int32_t n = first; n < run->spec.bodies.count; n++) {
    if (strcmp(texts[n], text) != 0)
      continue;
    texts[n][0] = 0;
    if (same++ < NAMED_MOST)
      length += (size_t)snprintf(names + length, sizeof names - length, "%s'%.100s'",
                                 length > 0 ? ", " : "", run->bodies[n].spec->name);
  }

  if (same == 1)
    config_warn("body %s: %s", names, text);
  else if (same <= NAMED_MOST)
    config_warn("bodies %s: %s", names, text);
  else
    config_warn("%" PRId32 " bodies, %s and others: %s", same, names, text);
}

/* Says each text once, and takes it out of `texts`. */
static void warn_of_each(const scene_run *run, shortfall *texts) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++)
    if (texts[n][0] != 0)
      warn_of_same(run, texts, n);
}

/* Says what bodies asked for and do not get. */
static thrum_status warn_of_shortfalls(const scene_run *run, thrum_error *error) {
  const int32_t count = (int32_t)run->spec.bodies.count;
  shortfall *texts = calloc((size_t)count, sizeof *texts);
  if (texts == NULL)
    return scene_run_no_memory(error);

  // budgets first: an error may be missed because of one
  for (int32_t n = 0; n < count; n++)
    if (is_sought(&run->bodies[n]))
      find_budget_shortfall(&run->bodies[n], texts[n]);
  warn_of_each(run, texts);

  for (int32_t n = 0; n < count; n++)
    if (is_sought(&run->bodies[n]))
      find_error_shortfall(run, &run->bodies[n], texts[n]);
  warn_of_each(run, texts);
  free(texts);
  return THRUM_OK;
}

/* Finds how many coordinates one body needs: it takes them from an earlier body that is the same,
 * or from an earlier run, or finds them by trial runs. */
static thrum_status find_one(scene_run *run, int32_t n, uint64_t *hashes, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  THRUM_TRY(check(run, body));
  hashes[n] = scene_trial_hash(run, n);
  for (int32_t m = 0; m < n; m++)
    if (is_sought(&run->bodies[m]) && hashes[m] == hashes[n]) {
      body->finding = run->bodies[m].finding;
      body->finding.by = SCENE_SHARED;
      return THRUM_OK;
    }
  if (read_cached(body, hashes[n], &body->finding))
    return THRUM_OK;
  THRUM_TRY(find(run, n, &body->finding, error));
  write_cached(hashes[n], &body->finding);
  return THRUM_OK;
}

static thrum_status find_all(scene_run *run, thrum_error *error) {
  const int32_t count = (int32_t)run->spec.bodies.count;
  const double began = clock_seconds();
  config_progress progress = config_progress_make(run->request->quiet);

  // bodies of one hash share what was found for the first of them
  uint64_t *hashes = calloc((size_t)count, sizeof *hashes);
  thrum_status status = hashes != NULL ? THRUM_OK : scene_run_no_memory(error);
  for (int32_t n = 0; n < count && status >= 0; n++) {
    scene_body_run *body = &run->bodies[n];
    if (!is_sought(body))
      continue;
    status = find_one(run, n, hashes, error);
    config_progress_update(&progress, "coordinates of bodies", (n + 1.0) / count);
    if (status < 0 || body->finding.masters == 0)
      continue;
    body->request.condense = body->finding.masters;
    status = thrum_scene_set_condensed(run->scene, n, body->finding.masters, error);
  }
  config_progress_end(&progress, status >= 0);
  free(hashes);

  // warnings come after the bar of progress, which they would break
  THRUM_THEN(status, warn_of_shortfalls(run, error));
  run->seconds_find = clock_seconds() - began;
  return status;
}

/* The levels of detail, over how the bodies are stepped near. */
static thrum_status set_details(scene_run *run) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_detail_spec *spec = &run->bodies[n].spec->detail;
    thrum_error detail = {0};
    if (spec->at.node == NULL)
      continue;
    if (!(spec->beyond > 0) && !(spec->still > 0)) {
      thrum_error_set(&detail, THRUM_INVALID_ARGUMENT,
                      "it says neither \"beyond\" nor \"still\", so it would never act");
      return scene_run_pass(run, &spec->at, NULL, THRUM_INVALID_ARGUMENT, &detail);
    }

    thrum_scene_body_info info;
    thrum_scene_body(run->scene, n, &info, NULL);
    if (would_pass(run, &run->bodies[n]) && !info.condensed) {
      thrum_error_set(&detail, THRUM_INVALID_ARGUMENT, "%s", passes);
      return scene_run_pass(run, &spec->at, NULL, THRUM_INVALID_ARGUMENT, &detail);
    }

    // a body that steps no more than that already has nothing to leave out
    if (is_sought(&run->bodies[n]) && info.rank <= spec->condense)
      continue;
    const thrum_scene_detail level = {spec->condense, spec->beyond, spec->still, spec->jump};
    const thrum_status status = thrum_scene_set_detail(run->scene, n, &level, &detail);
    THRUM_TRY(scene_run_pass(run, &spec->at, NULL, status, &detail));
    run->has_detail = true;
  }
  return THRUM_OK;
}

thrum_status scene_run_find_detail(scene_run *run, thrum_error *error) {
  bool sought = false;
  for (int32_t n = 0; n < run->spec.bodies.count; n++)
    sought = sought || is_sought(&run->bodies[n]);
  if (sought)
    THRUM_TRY(find_all(run, error));
  if (sought)
    THRUM_TRY(thrum_scene_reset(run->scene, error));
  return set_details(run);
}
