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
enum { CLI_HELPED = -1 }; /* no exit code: a command has printed its help and is done */

/* A subcommand: argv[0] is its name. The table of them stands in main.c, one line each. */
int cmd_precompute(int argc, char **argv);
int cmd_convert(int argc, char **argv);
int cmd_mesh(int argc, char **argv);
int cmd_check(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_embed(int argc, char **argv);
int cmd_export(int argc, char **argv);
int cmd_simulate(int argc, char **argv);
int cmd_static(int argc, char **argv);
int cmd_experiments(int argc, char **argv);
int cmd_tradeoff(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_schema(int argc, char **argv);
int cmd_view(int argc, char **argv);

/* Before all else: where the address space is limited, starts the program anew with one thread of
 * BLAS, so that it can end; else, or when that fails, does nothing. */
void cli_begin_in_address_space(char **argv);

/* Prints "thrum: <message>" on standard error and returns CLI_REFUSED. */
int cli_refuse(const thrum_error *error);

/* Control characters of what was typed, line ends too, into '?': a message is one line. */
void cli_one_line(char *text);

/* Prints "thrum <command>: <line> (try: thrum <command> --help)"; returns CLI_USAGE. */
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
  double drawn; /* cli_seconds() of the last drawing */
  double began; /* cli_seconds() */
} cli_progress;
cli_progress cli_progress_make(bool quiet);
void cli_progress_update(cli_progress *progress, const char *label, double fraction);
void cli_progress_done(cli_progress *progress);
/* Ends an unfinished stage without claiming that it was done. */
void cli_progress_abandon(cli_progress *progress);

/* The folder that a file lies in, "." without any; to be freed, NULL without memory. */
char *cli_folder_of(const char *path);
/* Are two paths one file, or would they be, if it were written? */
bool cli_same_file(const char *left, const char *right);
/* share/thrum/NAME of the prefix that this program would be installed in; false: `path` is too
 * short, or the system does not say where the program is. */
bool cli_share_path(const char *name, char *path, size_t size);

/* Refuses an output that could not be written, before long work rather than after it. */
thrum_status cli_check_output(const char *path, thrum_error *error);

/* Wall clock [s] from a monotonic clock, and the peak resident memory [2^20 bytes]. */
double cli_seconds(void);
double cli_peak_mb(void);

/* Adds a number with all its digits to a cJSON object; null when it is not finite. */
void cli_json_number(cJSON *object, const char *key, double value);
/* The number alone, for an array. */
cJSON *cli_json_number_item(double value);
/* Adds an array of numbers, the same way. */
void cli_json_numbers(cJSON *object, const char *key, const double *values, int64_t count);
/* Adds a text; bytes that are no UTF-8, as a file's name may hold, become '?'. */
void cli_json_string(cJSON *object, const char *key, const char *text);
void cli_json_strings(cJSON *object, const char *key, const char *const *texts, int64_t count);
/* What the report of a command begins with: "program", "version", "command" and "status". */
cJSON *cli_json_report(const char *command, const char *status);
/* Prints the object on one line on standard output and deletes it. */
void cli_json_print(cJSON *object);

/* The part of a path after its last slash. */
const char *cli_basename(const char *path);

/* `loaded` cut down to its lowest `rank` coordinates (0: all of them) in *memory, which the caller
 * frees; the loaded model must stay. */
thrum_status cli_model_lower(const thrum_model *loaded, int64_t rank, void **memory,
                             const thrum_model **model, thrum_error *error);

/* Makes a folder for results where there is none; refuses one that cannot be written to. */
thrum_status cli_results_folder(const char *path, thrum_error *error);

/* 64-bit FNV-1a of a file's bytes. */
thrum_status cli_hash_file(const char *path, uint64_t *hash, thrum_error *error);

/* How imexv would split this model at `dt` with its other defaults, and what a state would take. */
typedef struct cli_split {
  int64_t explicit_modes;
  int64_t implicit_modes;
  size_t state_bytes;
} cli_split;
thrum_status cli_split_at(const thrum_model *model, double dt, cli_split *split,
                          thrum_error *error);

/* Full-precision, compact text of an object (malloc, caller frees), for files and meta. */
char *cli_json_text(const cJSON *object);

#endif
