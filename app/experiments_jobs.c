/* `thrum experiments` in independent jobs: each is the same request with fewer models, loads,
 * amplitudes, starts, time steps, schemes or subjects, so that the rows of all jobs one after the
 * other are those of one run. SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/experiments.h"
#include "io/file_hash.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/allocate.h"
#include "precompute/build_info.h"

/* The axes along which a request is cut into jobs. */
typedef enum axis {
  AXIS_END,
  AXIS_MODEL,
  AXIS_LOAD,
  AXIS_AMPLITUDE,
  AXIS_START,
  AXIS_DT,
  AXIS_SCHEME,
  AXIS_SUBJECT
} axis;

/* The cuts of each kind in the order of its rows, the last fastest. Runs whose times are compared
 * stay together, and so do those that share a force or a reference, where that takes long. */
#define AXES_MAX 4
static const axis axes[EXPERIMENTS_KIND_COUNT][AXES_MAX] = {
    [EXPERIMENTS_MATRIX] = {AXIS_MODEL, AXIS_LOAD},
    [EXPERIMENTS_LONG] = {AXIS_MODEL, AXIS_AMPLITUDE, AXIS_SCHEME},
    [EXPERIMENTS_SWEEP] = {AXIS_MODEL, AXIS_DT},
    [EXPERIMENTS_EXTREMES] = {AXIS_SUBJECT},
    [EXPERIMENTS_LINEAR] = {AXIS_MODEL},
    [EXPERIMENTS_STEP_SIZES] = {AXIS_MODEL, AXIS_LOAD},
    [EXPERIMENTS_WORK_PRECISION] = {AXIS_MODEL, AXIS_START, AXIS_DT},
    [EXPERIMENTS_VARIABLE] = {AXIS_MODEL, AXIS_DT},
};

/* --- cutting ---------------------------------------------------------------------------------- */

/* The flags of an axis that is a list of names, and those; NULL: it is another. */
static bool *flags_of(experiments_request *request, axis along, int *count,
                      const char *const **names) {
  switch (along) {
  case AXIS_LOAD:
    *count = EXPERIMENT_LOAD_COUNT;
    *names = experiment_load_names;
    return request->loads;
  case AXIS_START:
    *count = EXPERIMENT_START_COUNT;
    *names = experiment_start_names;
    return request->starts;
  case AXIS_SCHEME:
    *count = EXPERIMENT_SCHEME_COUNT;
    *names = experiment_scheme_names;
    return request->schemes;
  case AXIS_SUBJECT:
    *count = EXPERIMENT_SUBJECT_COUNT;
    *names = experiment_subject_names;
    return request->subjects;
  default:
    return NULL;
  }
}

/* How many parts the request has along an axis. */
static int64_t part_count(experiments_request *request, axis along) {
  const char *const *names;
  int count = 0;
  const bool *flags = flags_of(request, along, &count, &names);
  if (along == AXIS_MODEL)
    return request->model_count;
  if (along == AXIS_AMPLITUDE)
    return request->amplitude_count;
  if (along == AXIS_DT)
    return request->dt_count;

  int64_t set = 0;
  for (int n = 0; flags != NULL && n < count; n++)
    set += flags[n];
  return set;
}

/* Leaves one of the flags that are set, and returns which it is. */
static int keep_flag(bool *flags, int count, int64_t part) {
  int kept = 0;
  for (int n = 0; n < count; n++) {
    const bool is_kept = flags[n] && part-- == 0;
    kept = is_kept ? n : kept;
    flags[n] = is_kept;
  }
  return kept;
}

/* Leaves one part along an axis, whose name is appended. */
static void keep_part(experiments_request *request, axis along, int64_t part, char *name,
                      size_t size) {
  const char *const *names = NULL;
  int count = 0;
  bool *flags = flags_of(request, along, &count, &names);
  if (along == AXIS_MODEL) {
    request->models[0] = request->models[part];
    request->model_count = 1;
    snprintf(name, size, "-%.60s", path_basename(request->models[0]));
  } else if (along == AXIS_AMPLITUDE) {
    request->amplitudes[0] = request->amplitudes[part];
    request->amplitude_count = 1;
    snprintf(name, size, "-%g", request->amplitudes[0]);
  } else if (along == AXIS_DT) {
    request->dts += part;
    request->dt_count = 1;
    snprintf(name, size, "-%gs", (double)request->dts->longest * EXPERIMENT_SWEEP_TICK);
  } else {
    snprintf(name, size, "-%s", names[keep_flag(flags, count, part)]);
  }
}

static int64_t job_count(const experiments_request *request) {
  experiments_request all = *request;
  int64_t count = 1;
  for (int n = 0; axes[all.kind][n] != AXIS_END; n++)
    count *= part_count(&all, axes[all.kind][n]);
  return count;
}

/* The request of one job, its name, and the number of its model in the whole request. */
static experiments_request request_of(const experiments_request *request, int64_t job,
                                      char name[JOB_NAME_MAX], int64_t *model) {
  experiments_request all = *request, one = *request;
  const axis *along = axes[request->kind];
  int64_t below = job_count(request);
  snprintf(name, JOB_NAME_MAX, "%s", request->name);
  *model = 0;
  for (int n = 0; along[n] != AXIS_END; n++) {
    const int64_t count = part_count(&all, along[n]);
    below /= count;
    const int64_t part = job / below % count;
    const size_t length = strlen(name);
    keep_part(&one, along[n], part, name + length, JOB_NAME_MAX - length);
    *model = along[n] == AXIS_MODEL ? part : *model;
  }
  return one;
}

/* --- the jobs --------------------------------------------------------------------------------- */

/* The calls of the list share this; models are loaded when a job needs them. */
typedef struct sweep_jobs {
  const experiments_request *request;
  experiments_bodies *bodies;
  cJSON *rows[EXPERIMENTS_TABLES_MAX]; /* that are collected */
  cJSON *lists;                        /* of each job, as its file would have it */
  bool flagged;
} sweep_jobs;

static void name_job(void *context, int64_t job, char name[JOB_NAME_MAX]) {
  const sweep_jobs *all = context;
  int64_t model;
  request_of(all->request, job, name, &model);
}

static thrum_status need_body(const sweep_jobs *all, int64_t model, thrum_error *error) {
  return all->request->model_count == 0 || all->bodies->models[model] != NULL
             ? THRUM_OK
             : experiments_body_load(all->request, model, all->bodies, error);
}

/* The polynomial, and how the body is pushed and measured. */
static void stamp_body(const experiment_body *body, cJSON *stamp) {
  const size_t rank = (size_t)body->model->rank;
  char text[20];
  uint64_t hash = hash_bytes(0, &body->model->identity, sizeof body->model->identity);
  hash = hash_bytes(hash, body->push, rank * sizeof *body->push);
  hash = hash_bytes(hash, body->tip, 3 * rank * sizeof *body->tip);
  hash = hash_bytes(hash, &body->length, sizeof body->length);
  snprintf(text, sizeof text, "%016" PRIx64, hash);
  json_string(stamp, "model", text);
}

/* The names whose flags are set. */
static void stamp_flags(experiments_request *one, axis along, const char *key, cJSON *stamp) {
  const char *const *names = NULL;
  int count = 0;
  const bool *flags = flags_of(one, along, &count, &names);
  cJSON *set = cJSON_AddArrayToObject(stamp, key);
  for (int n = 0; n < count; n++)
    if (flags[n])
      json_add_string(set, names[n]);
}

static thrum_status stamp_job(void *context, int64_t job, cJSON *stamp, thrum_error *error) {
  const sweep_jobs *all = context;
  char name[JOB_NAME_MAX];
  int64_t model;
  experiments_request one = request_of(all->request, job, name, &model);
  THRUM_TRY(need_body(all, model, error));

  // the options, those included that this kind has no use for
  json_number(stamp, "time", one.time);
  json_number(stamp, "dt", one.dt);
  json_number(stamp, "steps", (double)one.steps);
  json_numbers(stamp, "amplitudes", one.amplitudes, one.amplitude_count);
  stamp_flags(&one, AXIS_LOAD, "loads", stamp);
  stamp_flags(&one, AXIS_SCHEME, "schemes", stamp);

  // bodies that the job makes are those of this processor's linear algebra
  if (one.model_count > 0)
    stamp_body(&all->bodies->bodies[model], stamp);
  else
    json_string(stamp, "blas_core", thrum_build_blas_core());
  return THRUM_OK;
}

static thrum_status run_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const sweep_jobs *all = context;
  char name[JOB_NAME_MAX];
  int64_t model;
  bool flagged;
  experiments_request one = request_of(all->request, job, name, &model);
  THRUM_TRY(need_body(all, model, error));

  // the job has its one body in the first place; the bodies still belong to `all`
  experiments_bodies *bodies = NULL;
  THRUM_TRY(thrum_reserve(&bodies, 1, sizeof *bodies, "the models", error));
  bodies->count = one.model_count;
  bodies->models[0] = all->bodies->models[model];
  bodies->bodies[0] = all->bodies->bodies[model];
  one.result = result;
  const thrum_status status = experiments_run(&one, bodies, &flagged, error);
  free(bodies);
  return status;
}

/* --- the report ------------------------------------------------------------------------------- */

static thrum_status take_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  sweep_jobs *all = context;
  const experiments_form *form = all->request->form;
  (void)job;
  (void)error;
  cJSON *list = cJSON_DetachItemFromObjectCaseSensitive(result, "list");
  all->flagged |= cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(result, "flagged"));
  for (int n = 0; n < EXPERIMENTS_TABLES_MAX && form->tables[n].key != NULL; n++)
    json_append(all->rows[n], cJSON_GetObjectItemCaseSensitive(result, form->tables[n].key));
  cJSON_AddItemToArray(all->lists, list);
  return THRUM_OK;
}

static void write_list(FILE *stream, const void *of) {
  const sweep_jobs *all = of;
  const cJSON *list = NULL;
  cJSON_ArrayForEach(list, all->lists) {
    // the names of the columns stand once
    const char *text = cJSON_IsString(list) ? list->valuestring : "", *rows = strchr(text, '\n');
    fputs(list != all->lists->child && rows != NULL ? rows + 1 : text, stream);
  }
}

/* The rows and the list of all jobs; on failure none is left. */
static thrum_status collect_rows(sweep_jobs *all, const job_list *list, cJSON *missing,
                                 thrum_error *error) {
  const experiments_form *form = all->request->form;
  for (int n = 0; n < EXPERIMENTS_TABLES_MAX && form->tables[n].key != NULL; n++)
    all->rows[n] = cJSON_CreateArray();
  all->lists = cJSON_CreateArray();
  thrum_status status = job_list_collect(list, missing, error);
  if (status >= 0 && json_memory_failed())
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the rows");
  for (int n = 0; n < EXPERIMENTS_TABLES_MAX && status < 0; n++)
    cJSON_Delete(all->rows[n]);
  return status;
}

static thrum_status collect(sweep_jobs *all, const job_list *list, bool *flagged,
                            thrum_error *error) {
  cJSON *missing = cJSON_CreateArray();
  thrum_status status = collect_rows(all, list, missing, error);
  if (status >= 0) {
    job_list_warn(list, missing);
    *flagged = all->flagged || cJSON_GetArraySize(missing) > 0;
    const experiments_outcome outcome = {.rows = {all->rows[0], all->rows[1]},
                                         .write_list = write_list,
                                         .of = all,
                                         .flagged = all->flagged,
                                         .missing = missing};
    status = experiments_publish(all->request, &outcome, error);
  }
  cJSON_Delete(all->lists);
  cJSON_Delete(missing);
  return status;
}

thrum_status experiments_jobs(const experiments_request *request, char *const *argv, bool *flagged,
                              thrum_error *error) {
  sweep_jobs all = {.request = request};
  const job_list list = {.command = "experiments",
                         .folder = request->output,
                         .count = job_count(request),
                         .context = &all,
                         .name = name_job,
                         .stamp = stamp_job,
                         .run = run_job,
                         .take = take_job};
  *flagged = false;
  if (request->jobs.list)
    return job_list_print(&list, argv, error);

  thrum_status status = thrum_reserve(&all.bodies, 1, sizeof *all.bodies, "the models", error);
  if (status >= 0)
    status = request->jobs.collect
                 ? collect(&all, &list, flagged, error)
                 : job_list_run(&list, request->jobs.number, request->json, error);
  experiments_bodies_free(all.bodies);
  return status;
}
