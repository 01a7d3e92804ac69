/* A sweep in independent jobs, which run on as many processes and machines as there are: the list
 * of its jobs as lines for a shell, one job, and the report of what is there.
 *
 * The result of a job is one JSON file, FOLDER/jobs/NAME.json, which appears when it is whole. It
 * begins with a hash of its text and a stamp, the options and inputs that it depends on; a result
 * that was changed or has another stamp is refused. A job that is killed leaves nothing, and is run
 * again by the same line. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_JOB_LIST_H
#define THRUM_DRIVER_SPEC_JOB_LIST_H

#include <cjson/cJSON.h>

#include "config/options.h"
#include "thrum/status.h"

#define JOB_NAME_MAX 128

/* The part of its work that a command is asked for; {0}: all of it at once. */
typedef struct job_request {
  bool list;
  int64_t number; /* from 1; 0: not one job */
  bool collect;
} job_request;

/* The table of its options, for a group. */
extern const config_option job_options[];

/* A sweep as its command knows it. Jobs are counted from 0 here, and from 1 where people see them.
 * Their order is that of the report. */
typedef struct job_list {
  const char *command; /* "experiments" */
  const char *folder;  /* of the sweep */
  int64_t count;
  void *context;
  /* A name; jobs that are called the same are numbered. */
  void (*name)(void *context, int64_t job, char name[JOB_NAME_MAX]);
  /* Adds to `stamp` what the result depends on, but for the version and the compiler. */
  thrum_status (*stamp)(void *context, int64_t job, cJSON *stamp, thrum_error *error);
  /* Runs the job and adds its result to an empty object. */
  thrum_status (*run)(void *context, int64_t job, cJSON *result, thrum_error *error);
  /* Adds such a result, as it is read back, to what is collected; may take parts of it away. */
  thrum_status (*take)(void *context, int64_t job, cJSON *result, thrum_error *error);
} job_list;

/* Whether one of the three is asked for. */
bool job_request_given(const job_request *request);

/* Whether the options are those of one of the three; COMMAND_DONE, or COMMAND_USAGE after a line
 * that says what is wrong with them. */
int job_request_check(const job_request *request, const char *command);

/* Prints one line a job: this program with the arguments of the command (argv, with its name first)
 * and with --job N in place of --list-jobs. THRUM_UNSUPPORTED where the system does not tell where
 * the program lies. */
thrum_status job_list_print(const job_list *list, char *const *argv, thrum_error *error);

/* Runs the job with this number, from 1, unless its result is there, and prints which of both it
 * was. Refused: another number, and where there is a result with another stamp. */
thrum_status job_list_run(const job_list *list, int64_t number, bool json, thrum_error *error);

/* Hands the results that are there to list->take, in their order. `missing`, an array, gets the
 * names of the others. Refused where there is none, and at a result with another stamp. */
thrum_status job_list_collect(const job_list *list, cJSON *missing, thrum_error *error);

/* "2 of 12 jobs are missing: a, b", with the first of their names. */
#define JOB_MISSING_MAX 1200
const char *job_list_missing(const job_list *list, const cJSON *missing,
                             char text[JOB_MISSING_MAX]);

/* Warns of them, where there are any. */
void job_list_warn(const job_list *list, const cJSON *missing);

#endif
