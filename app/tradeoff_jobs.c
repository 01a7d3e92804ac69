/* See tradeoff_jobs.h. SPDX-License-Identifier: Apache-2.0 */
#include "app/tradeoff_jobs.h"

#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "driver/make/full_motion_kept.h"
#include "driver/spec/job_list.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/allocate.h"
#include "precompute/build_info.h"

/* --- results as JSON -------------------------------------------------------------------------- */

/* The members of a struct that are numbers, counts or flags, by their keys. */
typedef struct member {
  const char *key;
  enum { MEMBER_NUMBER, MEMBER_COUNT, MEMBER_FLAG } kind;
  size_t at;
} member;
#define NUMBER(type, field)                                                                        \
  { #field, MEMBER_NUMBER, offsetof(type, field) }
#define COUNT(type, field)                                                                         \
  { #field, MEMBER_COUNT, offsetof(type, field) }
#define FLAG(type, field)                                                                          \
  { #field, MEMBER_FLAG, offsetof(type, field) }
#define MEMBERS_END                                                                                \
  { NULL, MEMBER_NUMBER, 0 }

static const member basis_members[] = {COUNT(tradeoff_basis, recipe.modes),
                                       COUNT(tradeoff_basis, recipe.rank),
                                       COUNT(tradeoff_basis, recipe.masters),
                                       FLAG(tradeoff_basis, recipe.single),
                                       FLAG(tradeoff_basis, recipe.trained),
                                       NUMBER(tradeoff_basis, recipe.cubature_error),
                                       COUNT(tradeoff_basis, points),
                                       NUMBER(tradeoff_basis, cubature_range),
                                       NUMBER(tradeoff_basis, force_error),
                                       COUNT(tradeoff_basis, rank),
                                       NUMBER(tradeoff_basis, error.displacement),
                                       NUMBER(tradeoff_basis, error.velocity),
                                       NUMBER(tradeoff_basis, error.energy),
                                       NUMBER(tradeoff_basis, projection),
                                       NUMBER(tradeoff_basis, tight_dt),
                                       NUMBER(tradeoff_basis, precompute_seconds),
                                       MEMBERS_END};

static const member run_members[] = {COUNT(tradeoff_run, basis),
                                     NUMBER(tradeoff_run, dt),
                                     NUMBER(tradeoff_run, tolerance),
                                     FLAG(tradeoff_run, stable),
                                     COUNT(tradeoff_run, fallback_steps),
                                     FLAG(tradeoff_run, grew),
                                     FLAG(tradeoff_run, disproved),
                                     NUMBER(tradeoff_run, us_per_step),
                                     NUMBER(tradeoff_run, cost),
                                     NUMBER(tradeoff_run, error.displacement),
                                     NUMBER(tradeoff_run, error.velocity),
                                     NUMBER(tradeoff_run, error.energy),
                                     NUMBER(tradeoff_run, time_error.displacement),
                                     NUMBER(tradeoff_run, time_error.velocity),
                                     NUMBER(tradeoff_run, time_error.energy),
                                     FLAG(tradeoff_run, cancels),
                                     NUMBER(tradeoff_run, drift),
                                     COUNT(tradeoff_run, frequency_mode),
                                     NUMBER(tradeoff_run, frequency_error),
                                     NUMBER(tradeoff_run, frequency),
                                     NUMBER(tradeoff_run, stepped_frequency),
                                     MEMBERS_END};

static cJSON *write_members(const member *members, const void *from, cJSON *array) {
  cJSON *object = json_add_row(array);
  for (const member *m = members; m->key != NULL; m++) {
    const char *place = (const char *)from + m->at;
    if (m->kind == MEMBER_NUMBER)
      json_number(object, m->key, *(const double *)(const void *)place);
    else if (m->kind == MEMBER_COUNT)
      json_number(object, m->key, (double)*(const int64_t *)(const void *)place);
    else
      cJSON_AddBoolToObject(object, m->key, *(const bool *)(const void *)place);
  }
  return object;
}

static void read_members(const member *members, const cJSON *object, void *to) {
  for (const member *m = members; m->key != NULL; m++) {
    char *place = (char *)to + m->at;
    const double number = json_number_of(object, m->key);
    if (m->kind == MEMBER_NUMBER)
      *(double *)(void *)place = number;
    else if (m->kind == MEMBER_COUNT)
      *(int64_t *)(void *)place = isnan(number) ? 0 : (int64_t)number;
    else
      *(bool *)(void *)place = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(object, m->key));
  }
}

static void write_part(const tradeoff_result *part, cJSON *result) {
  json_number(result, "dropped", (double)part->dropped);
  json_string(result, "reason", part->dropped_reason.message);
  json_number(result, "full_error", part->full_error);

  cJSON *bases = cJSON_AddArrayToObject(result, "bases");
  for (int64_t b = 0; b < part->basis_count; b++)
    write_members(basis_members, &part->bases[b], bases);
  cJSON *runs = cJSON_AddArrayToObject(result, "runs");
  for (int64_t n = 0; n < part->run_count; n++)
    json_string(write_members(run_members, &part->runs[n], runs), "integrator",
                experiment_scheme_names[part->runs[n].integrator]);
}

static experiment_scheme scheme_of(const cJSON *run) {
  const char *name = json_text_of(run, "integrator");
  int scheme = 0;
  while (name != NULL && scheme < EXPERIMENT_SCHEME_COUNT - 1 &&
         strcmp(name, experiment_scheme_names[scheme]) != 0)
    scheme++;
  return (experiment_scheme)scheme;
}

static thrum_status read_part(const cJSON *result, tradeoff_result *part, thrum_error *error) {
  const cJSON *bases = cJSON_GetObjectItemCaseSensitive(result, "bases"), *item;
  const cJSON *runs = cJSON_GetObjectItemCaseSensitive(result, "runs");
  const char *reason = json_text_of(result, "reason");
  *part = (tradeoff_result){.full_error = json_number_of(result, "full_error")};
  THRUM_TRY(thrum_reserve(&part->bases, cJSON_GetArraySize(bases) + 1, sizeof *part->bases,
                          "the bases", error));
  THRUM_TRY(thrum_reserve(&part->runs, cJSON_GetArraySize(runs) + 1, sizeof *part->runs, "the runs",
                          error));

  cJSON_ArrayForEach(item, bases) {
    read_members(basis_members, item, &part->bases[part->basis_count++]);
  }
  cJSON_ArrayForEach(item, runs) {
    read_members(run_members, item, &part->runs[part->run_count]);
    part->runs[part->run_count++].integrator = scheme_of(item);
  }

  // why the basis could not be made
  part->dropped = part->basis_count == 0;
  thrum_error_set(&part->dropped_reason, THRUM_INVALID_ARGUMENT, "%s", reason ? reason : "");
  return THRUM_OK;
}

/* --- the jobs --------------------------------------------------------------------------------- */

static void name_job(void *context, int64_t job, char name[JOB_NAME_MAX]) {
  const tradeoff_jobs *jobs = context;
  const tradeoff_recipe *recipe = &jobs->recipes[job];
  char form[40], modes[24] = "";
  snprintf(form, sizeof form, "%s", recipe->single ? "-single" : "");
  if (recipe->cubature_error > 0)
    snprintf(form, sizeof form, "-cubature-%g", recipe->cubature_error);

  // a basis that is not trained has half as many modes as its rank, but for the model's own
  if (!recipe->trained && recipe->modes != (recipe->rank + 1) / 2)
    snprintf(modes, sizeof modes, "%" PRId64 "-", recipe->modes);
  if (job >= jobs->recipe_count)
    snprintf(name, JOB_NAME_MAX, "test-%" PRId64, job - jobs->recipe_count + 1);
  else if (recipe->modes == 0)
    snprintf(name, JOB_NAME_MAX, "own");
  else
    snprintf(name, JOB_NAME_MAX, "%s%s-%s%" PRId64 "%s",
             job < jobs->problem->recipe_count ? "" : "search-",
             recipe->trained ? "trained" : "modes", modes, recipe->rank, form);
}

/* The body with what acts on it and how long: the name that its full order would be kept under. */
static thrum_status stamp_motion(const tradeoff_problem *problem, const full_motion_script *script,
                                 cJSON *stamp, thrum_error *error) {
  char path[FULL_MOTION_PATH_MAX], identity[20];
  THRUM_TRY(full_motion_kept_path("", problem->model, 0, script, problem->full_dt,
                                  FULL_MOTION_SNAPSHOTS, path, error));
  snprintf(identity, sizeof identity, "%016" PRIx64, problem->model->identity);
  json_string(stamp, "body_and_load", path_basename(path));
  json_string(stamp, "model", identity);
  json_string(stamp, "blas_core", thrum_build_blas_core());
  return THRUM_OK;
}

static thrum_status stamp_job(void *context, int64_t job, cJSON *stamp, thrum_error *error) {
  const tradeoff_jobs *jobs = context;
  const tradeoff_problem *problem = jobs->problem;
  if (job >= jobs->recipe_count)
    return stamp_motion(problem, &problem->tests[job - jobs->recipe_count], stamp, error);

  // what is wanted is not in it: the same runs serve any error and any budget
  THRUM_TRY(stamp_motion(problem, &problem->script, stamp, error));
  json_number(stamp, "modes", (double)jobs->recipes[job].modes);
  if (jobs->recipes[job].cubature_error > 0)
    json_number(stamp, "cubature_error", jobs->recipes[job].cubature_error);
  if (jobs->recipes[job].cubature_error > 0 && problem->cubature_refine > 0)
    json_number(stamp, "cubature_refine", (double)problem->cubature_refine);
  json_numbers(stamp, "dts", problem->dts, problem->dt_count);
  json_numbers(stamp, "tolerances", problem->tolerances, problem->tolerance_count);
  cJSON_AddBoolToObject(stamp, "condense", problem->condense);
  cJSON *integrators = cJSON_AddArrayToObject(stamp, "integrators");
  for (int n = 0; n < EXPERIMENT_SCHEME_COUNT; n++)
    if (problem->integrators[n])
      json_add_string(integrators, experiment_scheme_names[n]);
  return THRUM_OK;
}

static thrum_status run_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const tradeoff_jobs *jobs = context;
  tradeoff_result part = {0};
  if (job >= jobs->recipe_count) {
    cJSON_AddBoolToObject(result, "kept", true);
    return tradeoff_solve_test(jobs->problem, job - jobs->recipe_count, error);
  }

  THRUM_TRY(tradeoff_solve_recipe(jobs->problem, &jobs->recipes[job], &part, error));
  write_part(&part, result);
  tradeoff_free(&part);
  return THRUM_OK;
}

static thrum_status take_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  tradeoff_jobs *jobs = context;
  jobs->results[job] = cJSON_Duplicate(result, true);
  return jobs->results[job] != NULL
             ? THRUM_OK
             : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the result of a job");
}

/* The list; full-order runs lie beside the results where the problem names no other folder, whose
 * path is put into `kept`. */
static thrum_status begin(const tradeoff_request *request, tradeoff_problem *problem,
                          tradeoff_jobs *jobs, job_list *list, char kept[FULL_MOTION_PATH_MAX],
                          thrum_error *error) {
  *jobs = (tradeoff_jobs){.request = request, .problem = problem};
  jobs->recipe_count = tradeoff_recipes(problem, jobs->recipes);
  *list = (job_list){.command = "tradeoff",
                     .folder = request->output,
                     .count = jobs->recipe_count + problem->test_count,
                     .context = jobs,
                     .name = name_job,
                     .stamp = stamp_job,
                     .run = run_job,
                     .take = take_job};
  const int length = snprintf(kept, FULL_MOTION_PATH_MAX, "%s/jobs", request->output);
  if (length < 0 || length >= FULL_MOTION_PATH_MAX)
    return thrum_error_set(error, THRUM_IO, "-o %.200s: the path is too long", request->output);
  if (problem->keep_runs == NULL)
    problem->keep_runs = kept;
  return THRUM_OK;
}

thrum_status tradeoff_jobs_run(const tradeoff_request *request, tradeoff_problem *problem,
                               char *const *argv, thrum_error *error) {
  tradeoff_jobs jobs;
  job_list list;
  char kept[FULL_MOTION_PATH_MAX];
  tradeoff_problem here = *problem;
  THRUM_TRY(begin(request, &here, &jobs, &list, kept, error));
  return request->jobs.list ? job_list_print(&list, argv, error)
                            : job_list_run(&list, request->jobs.number, request->json, error);
}

/* --- the report ------------------------------------------------------------------------------- */

static bool is_recipe(const tradeoff_recipe *a, const tradeoff_recipe *b) {
  return a->modes == b->modes && a->rank == b->rank && a->single == b->single &&
         a->trained == b->trained && a->cubature_error == b->cubature_error;
}

static thrum_status take_recipe(void *context, const tradeoff_recipe *recipe, tradeoff_result *part,
                                thrum_error *error) {
  tradeoff_jobs *jobs = context;
  int64_t job = 0;
  while (job < jobs->recipe_count - 1 && !is_recipe(&jobs->recipes[job], recipe))
    job++;
  *part = (tradeoff_result){0};
  jobs->missed[job] = jobs->results[job] == NULL;
  return jobs->missed[job] ? THRUM_OK : read_part(jobs->results[job], part, error);
}

static bool is_kept(void *context, int64_t test) {
  tradeoff_jobs *jobs = context;
  const int64_t job = jobs->recipe_count + test;
  jobs->missed[job] = jobs->results[job] == NULL;
  return !jobs->missed[job];
}

thrum_status tradeoff_jobs_open(const tradeoff_request *request, tradeoff_problem *problem,
                                tradeoff_jobs *jobs, thrum_error *error) {
  job_list list;
  THRUM_TRY(begin(request, problem, jobs, &list, jobs->kept, error));
  problem->take = take_recipe;
  problem->is_kept = is_kept;
  problem->take_context = jobs;

  // which of those that are not there matter is known when it is solved
  cJSON *absent = cJSON_CreateArray();
  const thrum_status status = job_list_collect(&list, absent, error);
  cJSON_Delete(absent);
  return status;
}

void tradeoff_jobs_close(tradeoff_jobs *jobs) {
  for (int64_t job = 0; job < TRADEOFF_BASES_MAX + TRADEOFF_TESTS_MAX; job++)
    cJSON_Delete(jobs->results[job]);
  *jobs = (tradeoff_jobs){0};
}

cJSON *tradeoff_jobs_missing(tradeoff_jobs *jobs) {
  const int64_t count = jobs->problem != NULL ? jobs->recipe_count + jobs->problem->test_count : 0;
  const job_list list = {.count = count};
  cJSON *missing = cJSON_CreateArray();
  for (int64_t job = 0; job < count; job++) {
    char name[JOB_NAME_MAX];
    if (!jobs->missed[job])
      continue;
    name_job(jobs, job, name);
    json_add_string(missing, name);
  }
  job_list_warn(&list, missing);
  return missing;
}
