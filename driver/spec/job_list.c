/* See job_list.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/job_list.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "config/message.h"
#include "io/file.h"
#include "io/file_hash.h"
#include "io/folder.h"
#include "io/json.h"
#include "io/paths.h"
#include "io/shell_word.h"
#include "precompute/build_info.h"
#include "thrum/thrum.h"

#define PATH_LENGTH 1400
#define NAMES_SAID 8 /* of missing jobs in a warning */
#define LIST_OPTION "--list-jobs"
#define NUMBER_LENGTH 24 /* of a dash and any number */

/* A result is JSON that begins with the hash of what follows it: a changed digit would be taken for
 * a number like any other. */
#define HASH_FORMAT "{\"hash\":\"%016" PRIx64 "\","
#define HASH_LENGTH 27

#define AT(member) CONFIG_AT(job_request, member)

const config_option job_options[] = {
    OPTION_FLAG("list-jobs",
                "run nothing; print the independent jobs that this is made of, a command a line",
                AT(list)),
    OPTION_COUNT(
        "job", NULL,
        "run the job with this number alone, and keep its result in the folder jobs in DIR",
        .value = "N", AT(number), CONFIG_FROM(1)),
    OPTION_FLAG("collect",
                "run nothing; make what the results of the jobs make up, and name the jobs that "
                "are missing",
                AT(collect)),
    OPTION_END,
};

bool job_request_given(const job_request *request) {
  return request->list || request->number > 0 || request->collect;
}

int job_request_check(const job_request *request, const char *command) {
  if (request->list + (request->number > 0) + request->collect > 1)
    return config_usage(command, "--list-jobs, --job and --collect: one of them at a time");
  return COMMAND_DONE;
}

/* The name of a job, as a file and a shell's comment take it. */
static void plain_name_of(const job_list *list, int64_t job, char name[JOB_NAME_MAX]) {
  list->name(list->context, job, name);
  for (char *at = name; *at != 0; at++)
    if (*at == '/' || (unsigned char)*at <= ' ')
      *at = '-';
}

/* The name of a job. Of jobs that the command calls the same, such as those of two models with one
 * file name in different folders, all but the first are numbered. */
static void name_of(const job_list *list, int64_t job, char name[JOB_NAME_MAX]) {
  char other[JOB_NAME_MAX];
  int64_t same = 1;
  plain_name_of(list, job, name);
  for (int64_t before = 0; before < job; before++) {
    plain_name_of(list, before, other);
    same += strcmp(name, other) == 0;
  }

  // a name without room for the number loses its end
  const size_t length = strlen(name), most = JOB_NAME_MAX - NUMBER_LENGTH;
  char *end = name + (length < most ? length : most);
  if (same > 1)
    snprintf(end, NUMBER_LENGTH, "-%" PRId64, same);
}

/* --- the list --------------------------------------------------------------------------------- */

/* Whether a word is the option itself, which getopt_long takes in a shorter form, too. */
static bool is_list_option(const char *word) {
  const size_t length = strlen(word);
  return length > 2 && strncmp(word, LIST_OPTION, length) == 0;
}

thrum_status job_list_print(const job_list *list, char *const *argv, thrum_error *error) {
  // the path of the program, since a shell elsewhere may find another one
  char program[PATH_LENGTH], name[JOB_NAME_MAX];
  const char *models = getenv("THRUM_MODELS");
  if (!path_program(program, sizeof program))
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "where this program lies is not known, so that its jobs cannot be named");

  for (int64_t job = 0; job < list->count; job++) {
    name_of(list, job, name);
    shell_word_put(stdout, program);
    if (models != NULL && models[0] != 0) {
      fputs(" --models-dir ", stdout);
      shell_word_put(stdout, models);
    }

    // the command with its number, then the arguments as they were given
    printf(" %s --job %" PRId64, list->command, job + 1);
    for (char *const *word = argv + 1; *word != NULL; word++) {
      if (is_list_option(*word))
        continue;
      fputc(' ', stdout);
      shell_word_put(stdout, *word);
    }
    printf(" # %s\n", name);
  }
  return THRUM_OK;
}

/* --- one job ---------------------------------------------------------------------------------- */

/* The file of a result. */
static thrum_status path_of(const job_list *list, int64_t job, char path[PATH_LENGTH],
                            thrum_error *error) {
  char name[JOB_NAME_MAX];
  name_of(list, job, name);
  const int length = snprintf(path, PATH_LENGTH, "%s/jobs/%s.json", list->folder, name);
  return length > 0 && length < PATH_LENGTH
             ? THRUM_OK
             : thrum_error_set(error, THRUM_IO, "%.200s: the path is too long", list->folder);
}

static thrum_status make_stamp(const job_list *list, int64_t job, cJSON **stamp,
                               thrum_error *error) {
  char name[JOB_NAME_MAX];
  name_of(list, job, name);
  cJSON *made = cJSON_CreateObject();
  json_string(made, "command", list->command);
  json_string(made, "job", name);

  // other code may round differently
  json_string(made, "version", thrum_version());
  json_string(made, "compiler", thrum_build_compiler());
  const thrum_status status = list->stamp(list->context, job, made, error);
  if (status >= 0)
    *stamp = made;
  else
    cJSON_Delete(made);
  return status;
}

/* The first member of the stamp that another has not, or has otherwise; NULL: none. */
static const cJSON *first_difference(const cJSON *stamp, const cJSON *other) {
  const cJSON *item;
  cJSON_ArrayForEach(item, stamp) {
    if (!cJSON_Compare(item, cJSON_GetObjectItemCaseSensitive(other, item->string), true))
      return item;
  }
  return NULL;
}

static thrum_status refuse_stamp(const char *path, const cJSON *mine, const cJSON *theirs,
                                 thrum_error *error) {
  char *here = json_text(mine), *there = theirs != NULL ? json_text(theirs) : NULL;
  const thrum_status status =
      thrum_error_set(error, THRUM_BAD_VALUE,
                      "%.300s: is of other options or inputs (%s is %.100s there and %.100s here): "
                      "give the options of all jobs, or take another folder",
                      path, mine->string, there ? there : "not", here ? here : "?");
  free(here);
  free(there);
  return status;
}

/* The JSON object of a file whose hash is that of its text; NULL: it is damaged. */
static cJSON *read_hashed(const char *text, size_t size) {
  char hash[HASH_LENGTH + 1];
  if (size <= HASH_LENGTH)
    return NULL;
  snprintf(hash, sizeof hash, HASH_FORMAT, hash_bytes(0, text + HASH_LENGTH, size - HASH_LENGTH));
  return memcmp(text, hash, HASH_LENGTH) == 0 ? json_read_back(text, size) : NULL;
}

/* Puts the hash in front of the members of a JSON object; NULL: out of memory. */
static char *put_hash(const char *object) {
  const char *members = object + 1; // behind its brace
  const size_t length = strlen(members), size = HASH_LENGTH + length + 1;
  char *text = malloc(size);
  if (text != NULL)
    snprintf(text, size, HASH_FORMAT "%s", hash_bytes(0, members, length), members);
  return text;
}

/* Reads the result of a job; *result is NULL where there is none. What is damaged is refused. */
static thrum_status read_result(const char *path, const cJSON *stamp, cJSON **result,
                                thrum_error *error) {
  void *text = NULL;
  size_t size = 0;
  *result = NULL;
  if (access(path, F_OK) != 0)
    return THRUM_OK;
  THRUM_TRY(thrum_file_read(path, &text, &size, error));
  cJSON *file = read_hashed(text, size);
  free(text);

  // the stamp first: of another sweep nothing is believed
  const cJSON *theirs = cJSON_GetObjectItemCaseSensitive(file, "stamp");
  const cJSON *mine = theirs != NULL ? first_difference(stamp, theirs) : NULL;
  cJSON *found = mine == NULL ? cJSON_DetachItemFromObjectCaseSensitive(file, "result") : NULL;
  thrum_status status = THRUM_OK;
  if (mine != NULL)
    status =
        refuse_stamp(path, mine, cJSON_GetObjectItemCaseSensitive(theirs, mine->string), error);
  else if (found == NULL)
    status =
        thrum_error_set(error, THRUM_BAD_FORMAT,
                        "%.300s: not the result of a job; delete it and run the job again", path);
  cJSON_Delete(file);
  *result = found;
  return status;
}

static thrum_status write_result(const char *path, cJSON *stamp, cJSON *result,
                                 thrum_error *error) {
  // the references keep both with their owners
  cJSON *file = cJSON_CreateObject();
  cJSON_AddItemReferenceToObject(file, "stamp", stamp);
  cJSON_AddItemReferenceToObject(file, "result", result);
  char *object = json_text(file), *text = object != NULL ? put_hash(object) : NULL;
  const thrum_status status =
      text != NULL
          ? thrum_file_write_atomic(path, text, strlen(text), error)
          : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the result of a job");
  free(text);
  free(object);
  cJSON_Delete(file);
  return status;
}

static thrum_status make_folder(const job_list *list, thrum_error *error) {
  char path[PATH_LENGTH];
  const int length = snprintf(path, sizeof path, "%s/jobs", list->folder);
  if (length < 0 || length >= (int)sizeof path)
    return thrum_error_set(error, THRUM_IO, "%.200s: the path is too long", list->folder);
  THRUM_TRY(folder_make(list->folder, error));
  return folder_make(path, error);
}

static void say(const job_list *list, int64_t job, bool ran, bool json) {
  char name[JOB_NAME_MAX];
  name_of(list, job, name);
  if (!json) {
    printf("job %" PRId64 " of %" PRId64 ", %s: %s\n", job + 1, list->count, name,
           ran ? "done" : "was done");
    return;
  }
  cJSON *object = json_report(list->command, "done");
  json_string(object, "job", name);
  cJSON_AddBoolToObject(object, "ran", ran);
  json_print(object);
}

/* Runs a job whose result is not there. */
static thrum_status make_result(const job_list *list, int64_t job, const char *path, cJSON *stamp,
                                thrum_error *error) {
  cJSON *result = cJSON_CreateObject();
  if (result == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the result of a job");
  thrum_status status = list->run(list->context, job, result, error);
  THRUM_THEN(status, write_result(path, stamp, result, error));
  cJSON_Delete(result);
  return status;
}

thrum_status job_list_run(const job_list *list, int64_t number, bool json, thrum_error *error) {
  const int64_t job = number - 1;
  char path[PATH_LENGTH];
  cJSON *stamp = NULL, *there = NULL;
  if (job < 0 || job >= list->count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--job %" PRId64 ": there are %" PRId64 " jobs", number, list->count);
  THRUM_TRY(make_folder(list, error));
  THRUM_TRY(path_of(list, job, path, error));
  THRUM_TRY(make_stamp(list, job, &stamp, error));

  // a result that is there need not be made again
  thrum_status status = read_result(path, stamp, &there, error);
  const bool missing = there == NULL;
  if (missing)
    THRUM_THEN(status, make_result(list, job, path, stamp, error));
  if (status >= 0)
    say(list, job, missing, json);
  cJSON_Delete(there);
  cJSON_Delete(stamp);
  return status;
}

/* --- the report ------------------------------------------------------------------------------- */

/* Takes one result where it is there, else names it. */
static thrum_status take_job(const job_list *list, int64_t job, cJSON *missing,
                             thrum_error *error) {
  char path[PATH_LENGTH], name[JOB_NAME_MAX];
  cJSON *stamp = NULL, *result = NULL;
  THRUM_TRY(path_of(list, job, path, error));
  THRUM_TRY(make_stamp(list, job, &stamp, error));
  thrum_status status = read_result(path, stamp, &result, error);
  cJSON_Delete(stamp);
  if (status < 0)
    return status;
  if (result != NULL) {
    status = list->take(list->context, job, result, error);
    cJSON_Delete(result);
    return status;
  }

  name_of(list, job, name);
  json_add_string(missing, name);
  return THRUM_OK;
}

thrum_status job_list_collect(const job_list *list, cJSON *missing, thrum_error *error) {
  for (int64_t job = 0; job < list->count; job++)
    THRUM_TRY(take_job(list, job, missing, error));
  if (json_memory_failed())
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the results of the jobs");
  if (cJSON_GetArraySize(missing) < list->count)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "%.300s/jobs: there is no result of any job; --list-jobs names them",
                         list->folder);
}

const char *job_list_missing(const job_list *list, const cJSON *missing,
                             char text[JOB_MISSING_MAX]) {
  const int count = cJSON_GetArraySize(missing);
  size_t used = (size_t)snprintf(text, JOB_MISSING_MAX,
                                 "%d of %" PRId64 " jobs are missing: ", count, list->count);
  for (int n = 0; n < count && n < NAMES_SAID; n++)
    used += (size_t)snprintf(text + used, JOB_MISSING_MAX - used, "%s%s", n > 0 ? ", " : "",
                             cJSON_GetArrayItem(missing, n)->valuestring);
  snprintf(text + used, JOB_MISSING_MAX - used, "%s", count > NAMES_SAID ? " ..." : "");
  return text;
}

void job_list_warn(const job_list *list, const cJSON *missing) {
  char text[JOB_MISSING_MAX];
  if (cJSON_GetArraySize(missing) > 0)
    config_warn("the report is not whole: %s", job_list_missing(list, missing, text));
}
