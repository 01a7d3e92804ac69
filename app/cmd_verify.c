/* `thrum verify`: published answers beside what this build computes. The problems and their tables
 * are in validation/published/. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "app/cmd.h"
#include "app/results.h"
#include "config/message.h"
#include "config/progress.h"
#include "driver/spec/job_list.h"
#include "io/folder.h"
#include "io/json.h"
#include "platform/allocate.h"
#include "platform/interrupt.h"
#include "precompute/build_info.h"
#include "validation/published/published.h"

#define REFINEMENTS 2
#define REFINEMENTS_MAX 4

typedef struct verify_request {
  const char *output; /* folder */
  int64_t refinements;
  bool json, quiet;
  job_request jobs;
} verify_request;

#define AT(member) CONFIG_AT(verify_request, member)

static const config_option options[] = {
    OPTION_TEXT("output", "DIR", NULL, "the folder; made when it is not there", .letter = 'o',
                AT(output)),
    OPTION_COUNT("refinements", "2",
                 "how often meshes and steps are refined beyond what the tests do; each takes "
                 "several times longer than the one before",
                 AT(refinements), CONFIG_RANGE(0, REFINEMENTS_MAX)),
    OPTION_JSON(verify_request),
    OPTION_QUIET(verify_request),
    OPTION_HELP,
    OPTION_GROUP(job_options, "in independent jobs, one for each problem", AT(jobs)),
    OPTION_END,
};

const config_command command_verify = {
    .name = "verify",
    .summary = "compute published answers again",
    .usage = "-o DIR [OPTIONS]",
    .about =
        "Computes answers that are known in closed form or published as benchmarks, from coarse "
        "meshes to fine ones, and writes them beside the published ones: verification.csv with "
        "all rows, and tables.md with a line for each quantity, which is printed too.",
    .options = options,
    .examples = "verify -o verification\n"
                "verify -o verification --list-jobs\n"
                "verify -o verification --collect",
    .exits = "0 done, 1 refused, 2 usage, 3 jobs are missing",
};

/* --- rows ------------------------------------------------------------------------------------- */

/* Where the rows of a problem go. */
typedef struct row_sink {
  cJSON *rows;
  bool lost; /* a number is none, for want of memory or as a run was lost */
} row_sink;

static void add_row(void *context, const published_row *row) {
  row_sink *sink = context;
  cJSON *item = json_add_row(sink->rows);
  sink->lost = sink->lost || !isfinite(row->computed);
  json_string(item, "problem", row->problem);
  json_string(item, "quantity", row->quantity);
  json_string(item, "setting", row->mesh);
  json_number(item, "size", row->size);
  json_number(item, "published", row->published);
  json_number(item, "computed", row->computed);
}

static const char *text_of(const cJSON *row, const char *key) {
  const char *text = json_text_of(row, key);
  return text != NULL ? text : "";
}

/* The rows as the tables take them, whose texts stay those of the objects; the caller frees. */
static thrum_status rows_of(const cJSON *array, published_row **rows, thrum_error *error) {
  published_row *row = NULL;
  THRUM_TRY(thrum_reserve(&row, cJSON_GetArraySize(array) + 1, sizeof *row, "the rows", error));
  *rows = row;

  const cJSON *item;
  cJSON_ArrayForEach(item, array) {
    row->problem = text_of(item, "problem");
    row->quantity = text_of(item, "quantity");
    snprintf(row->mesh, sizeof row->mesh, "%s", text_of(item, "setting"));
    row->size = json_number_of(item, "size");
    row->published = json_number_of(item, "published");
    row++->computed = json_number_of(item, "computed");
  }
  return THRUM_OK;
}

/* Adds the rows of one problem. */
static thrum_status solve(const verify_request *request, int64_t n, cJSON *rows,
                          thrum_error *error) {
  const published_entry *problem = &published_problems[n];
  row_sink to = {rows, false};
  const published_sink sink = {add_row, &to, (int)request->refinements};
  thrum_status status = problem->solve(&sink, error);
  if (status >= 0 && to.lost)
    status = thrum_error_set(error, THRUM_NOT_FINITE, "an answer could not be computed");
  return config_error_in(error, status, "%s", problem->text);
}

static thrum_status solve_all(const verify_request *request, cJSON *rows, thrum_error *error) {
  config_progress progress = config_progress_make(request->quiet);
  thrum_status status = folder_make(request->output, error);
  for (int64_t n = 0; n < published_problem_count && status >= 0; n++) {
    config_progress_update(&progress, published_problems[n].text, 0);
    status = solve(request, n, rows, error);
    config_progress_end(&progress, status >= 0);
  }
  return status;
}

/* --- files ------------------------------------------------------------------------------------ */

static void write_csv(FILE *stream, const published_rows *all, const cJSON *missing) {
  (void)missing;
  published_write_csv(all, stream);
}

static void write_tables(FILE *stream, const published_rows *all, const cJSON *missing) {
  const cJSON *name;
  if (cJSON_GetArraySize(missing) > 0)
    fputs("Not whole: these jobs are missing:", stream);
  cJSON_ArrayForEach(name, missing) fprintf(stream, " %s", name->valuestring);
  fputs(cJSON_GetArraySize(missing) > 0 ? "\n\n" : "", stream);
  published_write_tables(all, stream);
}

static thrum_status write_file(const verify_request *request, const char *name,
                               const published_rows *all, const cJSON *missing,
                               void (*write)(FILE *, const published_rows *, const cJSON *),
                               thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(results_open(request->output, name, &writer, error));
  write(writer.stream, all, missing);
  return thrum_file_writer_commit(&writer, error);
}

/* The files, and the result on standard output; `rows` is taken. */
static thrum_status publish(const verify_request *request, cJSON *rows, const cJSON *missing,
                            thrum_error *error) {
  published_row *row = NULL;
  thrum_status status = json_memory_failed()
                            ? thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the rows")
                            : rows_of(rows, &row, error);
  const published_rows all = {row, cJSON_GetArraySize(rows)};
  THRUM_THEN(status, write_file(request, "verification.csv", &all, missing, write_csv, error));
  THRUM_THEN(status, write_file(request, "tables.md", &all, missing, write_tables, error));

  // the files first, so that a full disk is the last word
  if (status >= 0 && !request->json)
    write_tables(stdout, &all, missing);
  free(row);
  if (status < 0 || !request->json) {
    cJSON_Delete(rows);
    return status;
  }
  const bool whole = cJSON_GetArraySize(missing) == 0;
  cJSON *object = json_report("verify", whole ? "done" : "incomplete");
  results_add_machine(object);
  if (!whole)
    cJSON_AddItemToObject(object, "missing_jobs", cJSON_Duplicate(missing, true));
  cJSON_AddItemToObject(object, "rows", rows);
  json_print(object);
  return THRUM_OK;
}

/* --- jobs ------------------------------------------------------------------------------------- */

typedef struct verify_jobs {
  const verify_request *request;
  cJSON *rows; /* that are collected */
} verify_jobs;

static void name_job(void *context, int64_t job, char name[JOB_NAME_MAX]) {
  (void)context;
  snprintf(name, JOB_NAME_MAX, "%s", published_problems[job].name);
}

static thrum_status stamp_job(void *context, int64_t job, cJSON *stamp, thrum_error *error) {
  const verify_jobs *all = context;
  (void)job;
  (void)error;
  json_number(stamp, "refinements", (double)all->request->refinements);
  json_string(stamp, "blas_core", thrum_build_blas_core());
  return THRUM_OK;
}

static thrum_status run_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const verify_jobs *all = context;
  return solve(all->request, job, cJSON_AddArrayToObject(result, "rows"), error);
}

static thrum_status take_job(void *context, int64_t job, cJSON *result, thrum_error *error) {
  const verify_jobs *all = context;
  (void)job;
  (void)error;
  json_append(all->rows, cJSON_GetObjectItemCaseSensitive(result, "rows"));
  return THRUM_OK;
}

/* One of the three that the jobs are asked for. *rows are those that are collected. */
static thrum_status run_jobs(const verify_request *request, char *const *argv, cJSON *rows,
                             cJSON *missing, thrum_error *error) {
  verify_jobs all = {request, rows};
  const job_list list = {.command = "verify",
                         .folder = request->output,
                         .count = published_problem_count,
                         .context = &all,
                         .name = name_job,
                         .stamp = stamp_job,
                         .run = run_job,
                         .take = take_job};
  if (request->jobs.list)
    return job_list_print(&list, argv, error);
  if (request->jobs.number > 0)
    return job_list_run(&list, request->jobs.number, request->json, error);

  THRUM_TRY(job_list_collect(&list, missing, error));
  job_list_warn(&list, missing);
  return THRUM_OK;
}

/* All problems, or what the jobs are asked for. */
static thrum_status run_request(const verify_request *request, char *const *argv, bool *flagged,
                                thrum_error *error) {
  const bool split = job_request_given(&request->jobs);
  cJSON *rows = cJSON_CreateArray(), *missing = cJSON_CreateArray();
  thrum_status status =
      split ? run_jobs(request, argv, rows, missing, error) : solve_all(request, rows, error);

  // a list and a single job have no report
  *flagged = cJSON_GetArraySize(missing) > 0;
  if (status >= 0 && (!split || request->jobs.collect))
    status = publish(request, rows, missing, error);
  else
    cJSON_Delete(rows);
  cJSON_Delete(missing);
  return status;
}

int cmd_verify(int argc, char **argv) {
  verify_request request = {.refinements = REFINEMENTS};
  thrum_error error = {0};
  bool flagged = false;

  // options that do not go together are refused before any work is done
  CONFIG_TRY(config_options_read(&command_verify, argc, argv, &request));
  if (optind < argc)
    return config_usage("verify", "'%s' is too much; the folder is -o DIR", argv[optind]);
  if (request.output == NULL || request.output[0] == 0)
    return config_usage("verify", "where to? name a folder with -o DIR");
  CONFIG_TRY(job_request_check(&request.jobs, "verify"));

  thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
  const thrum_status status = run_request(&request, argv, &flagged, &error);
  return config_end(status, flagged, &error);
}
