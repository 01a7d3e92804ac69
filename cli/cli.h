/* What the subcommands of `thrum` share: exit codes, messages, parsing, progress, JSON lines.
 *
 * Standard output carries results alone (a table for people, or with --json one object on one
 * line); everything else goes to standard error. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_H
#define THRUM_CLI_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

enum cli_exit { CLI_DONE = 0, CLI_REFUSED = 1, CLI_USAGE = 2, CLI_FLAGGED = 3 };

/* A subcommand: argv[0] is its name. The table of them stands in main.c, one line each. */
int cmd_precompute(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_simulate(int argc, char **argv);

/* Prints "thrum: <message>" on standard error and returns CLI_REFUSED. */
int cli_refuse(const thrum_error *error);

/* Prints "thrum <command>: <line>" and "try: thrum <command> --help"; returns CLI_USAGE. */
__attribute__((format(printf, 2, 3))) int cli_usage(const char *command, const char *format, ...);

/* What getopt_long rejected (it returned '?' or ':', with opterr = 0 and a short list that begins
 * with ':'): says so, with the nearest long option; returns CLI_USAGE. */
struct option;
int cli_usage_option(const char *command, char **argv, const struct option *options);

/* Of `count` names the one that differs least from `text`, NULL when none is near. */
const char *cli_nearest(const char *text, const char *const *names, int64_t count);

/* Prints "thrum: warning: <line>" on standard error. */
__attribute__((format(printf, 1, 2))) void cli_warn(const char *format, ...);

/* Parse the whole of `text`, independent of the locale; false (value untouched) when it is not one
 * finite number, integer, or comma-separated vector. */
bool cli_parse_number(const char *text, double *value);
bool cli_parse_integer(const char *text, int64_t *value);
bool cli_parse_vector3(const char *text, double value[3]);

/* Progress of a long stage: a bar redrawn in place when standard error is a terminal, otherwise
 * one plain line when a stage starts and one when it is done; nothing when quiet. */
typedef struct cli_progress {
  bool terminal;
  bool quiet;
  bool open;
  char label[64];
  double shown; /* fraction last drawn */
  double began; /* cli_seconds() */
} cli_progress;
cli_progress cli_progress_make(bool quiet);
void cli_progress_update(cli_progress *progress, const char *label, double fraction);
void cli_progress_done(cli_progress *progress);

/* Wall clock [s] from a monotonic clock, and the peak resident memory [2^20 bytes]. */
double cli_seconds(void);
double cli_peak_mb(void);

/* Adds a number with all its digits to a cJSON object; null when it is not finite. */
void cli_json_number(cJSON *object, const char *key, double value);
/* Adds an array of numbers, the same way. */
void cli_json_numbers(cJSON *object, const char *key, const double *values, int64_t count);
/* Prints the object on one line on standard output and deletes it. */
void cli_json_print(cJSON *object);

/* Full-precision, compact text of an object (malloc, caller frees), for files and meta. */
char *cli_json_text(const cJSON *object);

#endif
