/* Support for tests of the program: it is run, its output and exit code are kept, its JSON is read.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_PROGRAM_SUPPORT_H
#define THRUM_TESTS_SUPPORT_PROGRAM_SUPPORT_H

#include <cjson/cJSON.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define ARGUMENTS_MAX 64

/* The result of one run of the program. exit_code is -1 when a signal ended it. */
typedef struct program_result {
  int exit_code;
  char *out; /* standard output, ended by 0 */
  char *err; /* standard error, ended by 0 */
} program_result;

static inline void program_result_free(program_result *result) {
  free(result->out);
  free(result->err);
  memset(result, 0, sizeof *result);
}

/* A whole file as text (malloc, ended by 0); NULL when it cannot be read. */
static inline char *text_file_read(const char *path) {
  FILE *file = fopen(path, "rb");
  if (file == NULL)
    return NULL;

  // the size is unknown beforehand, as for /proc, so the buffer grows
  size_t used = 0, size = 4096;
  char *text = malloc(size);
  while (text != NULL) {
    used += fread(text + used, 1, size - used - 1, file);
    if (used + 1 < size)
      break;
    size *= 2;
    char *grown = realloc(text, size);
    if (grown == NULL)
      free(text);
    text = grown;
  }

  if (text != NULL)
    text[used] = 0;

  fclose(file);
  return text;
}

static inline bool text_file_write(const char *path, const char *text) {
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return false;
  const bool written = fputs(text, file) >= 0;
  return fclose(file) == 0 && written;
}

static inline bool file_exists(const char *path) {
  struct stat status;
  return stat(path, &status) == 0;
}

/* Lets signals end this program and those that it runs, as in a terminal. A program that was
 * started by nohup, or with & in a script, ignores SIGINT or SIGHUP, and so do all that it starts.
 * For the first line of main of a test that sends signals. */
static inline void signals_as_in_a_terminal(void) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
  for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++)
    signal(numbers[n], SIG_DFL);
}

/* A fresh folder for one test program; remove it with test_folder_remove. */
static inline const char *test_folder_make(char path[64]) {
  snprintf(path, 64, "/tmp/thrum-test-XXXXXX");
  return mkdtemp(path);
}

/* Runs argv[0] with these arguments (ended by NULL), in `folder` when it is not NULL. */
static inline program_result program_execute(const char *folder, char *const *argv) {
  program_result result = {.exit_code = -1};

  // files instead of pipes, which could fill up and block the child
  char out_path[] = "/tmp/thrum-out-XXXXXX", err_path[] = "/tmp/thrum-err-XXXXXX";
  const int out = mkstemp(out_path), err = mkstemp(err_path);
  fflush(NULL);

  // exit codes of the child that the program itself does not use
  const pid_t child = out >= 0 && err >= 0 ? fork() : -1;
  if (child == 0) {
    if (folder != NULL && chdir(folder) != 0)
      _exit(126);
    if (dup2(out, STDOUT_FILENO) < 0 || dup2(err, STDERR_FILENO) < 0)
      _exit(126);
    execv(argv[0], argv);
    _exit(127);
  }

  // -1 stays when a signal ended the child
  int status = 0;
  if (child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status)) {
    result.exit_code = WEXITSTATUS(status);
  }

  // the output is kept, the files are not
  result.out = text_file_read(out_path);
  result.err = text_file_read(err_path);
  if (out >= 0)
    close(out);
  if (err >= 0)
    close(err);

  unlink(out_path);
  unlink(err_path);
  return result;
}

/* Runs `thrum` with the arguments given, ended by NULL, such as
 * thrum_run(folder, "info", "beam.npz", "--json", NULL). */
static inline program_result thrum_run(const char *folder, ...) {
  const char *arguments[ARGUMENTS_MAX + 1] = {THRUM_PROGRAM};
  va_list list;
  va_start(list, folder);
  int count = 1;
  const char *argument = va_arg(list, const char *);
  while (argument != NULL && count < ARGUMENTS_MAX) {
    arguments[count++] = argument;
    argument = va_arg(list, const char *);
  }
  va_end(list);
  // execv takes char *const *, but changes nothing
  char *argv[ARGUMENTS_MAX + 1];
  memcpy(argv, arguments, sizeof argv);
  return program_execute(folder, argv);
}

static inline void test_folder_remove(const char *path) {
  char remove[] = "/bin/rm", options[] = "-rf", target[128];
  snprintf(target, sizeof target, "%s", path);
  char *argv[] = {remove, options, target, NULL};
  program_result result = program_execute(NULL, argv);
  program_result_free(&result);
}

/* The one JSON object that --json prints: NULL unless `out` is exactly one line holding it. */
static inline cJSON *json_line(const char *out) {
  const char *newline = out != NULL ? strchr(out, '\n') : NULL;
  if (newline == NULL || newline[1] != 0)
    return NULL;
  cJSON *object = cJSON_Parse(out);
  if (object != NULL && !cJSON_IsObject(object)) {
    cJSON_Delete(object);
    return NULL;
  }
  return object;
}

/* A number of an object; NaN when it is missing or not a number. */
static inline double json_value(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  return cJSON_IsNumber(item) ? item->valuedouble : strtod("nan", NULL);
}

/* How often a text occurs in another. */
static inline int text_count(const char *text, const char *part) {
  int count = 0;
  for (const char *at = strstr(text, part); at != NULL; at = strstr(at + 1, part))
    count++;
  return count;
}

/* Whether standard error is `lines` lines, none of them empty. */
static inline bool line_count_is(const char *text, int lines) {
  int count = 0;
  for (const char *at = text; *at != 0; at++)
    count += *at == '\n';
  return count == lines;
}

/* Whether a run was refused with this exit code, in one line that holds these words, and printed no
 * result. */
static inline bool is_refusal(const program_result *run, int code, const char *words) {
  return run->exit_code == code && strstr(run->err, words) != NULL && line_count_is(run->err, 1) &&
         run->out[0] == 0;
}

#endif
