/* Exit codes, and messages for people on standard error. Standard output carries results alone: a
 * table, or with --json one object on one line. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_MESSAGE_H
#define THRUM_CONFIG_MESSAGE_H

#include "thrum/status.h"
#include <getopt.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum command_exit { COMMAND_DONE = 0, COMMAND_REFUSED = 1, COMMAND_USAGE = 2, COMMAND_FLAGGED = 3 };
enum { COMMAND_HELPED = -1 }; /* no exit code: a command has printed its help and is done */

/* Returns from the caller with the code of a step of its command that is not COMMAND_DONE. */
#define CONFIG_TRY(call)                                                                           \
  do {                                                                                             \
    const int try_code_ = (call);                                                                  \
    if (try_code_ != COMMAND_DONE)                                                                 \
      return try_code_;                                                                            \
  } while (0)

/* Prints "thrum: <message>" on standard error and returns COMMAND_REFUSED. */
int config_refuse(const thrum_error *error);

/* The exit code at the end of a command: refused with that line, flagged, or done. */
int config_end(thrum_status status, bool flagged, const thrum_error *error);

/* Passes a status on; what the error of a failure says then follows these words and ": ". */
__attribute__((format(printf, 3, 4))) thrum_status
config_error_in(thrum_error *error, thrum_status status, const char *format, ...);

/* The same of one option or key, a static text: it is the field of the error. */
thrum_status config_error_of(thrum_error *error, thrum_status status, const char *field);

/* Control characters of what was typed, line ends too, and marks that turn the direction of a text
 * into '?': a message is one line, and shows what is there. */
void config_one_line(char *text);

/* Prints "thrum <command>: <line> (try: thrum <command> --help)"; returns COMMAND_USAGE. */
__attribute__((format(printf, 2, 3))) int config_usage(const char *command, const char *format,
                                                       ...);

/* Says what getopt_long rejected (it returned '?' or ':', with opterr = 0 and a short list that
 * begins with ':'): says so, with the nearest long option; returns COMMAND_USAGE. */
int config_usage_option(const char *command, char **argv, const struct option *options);

/* Returns the one of `count` names that differs least from `text`, NULL when none is near. */
const char *config_nearest(const char *text, const char *const *names, int64_t count);

/* From now on warnings begin with a place, "scene.json:7: body 'block'", and go through `words`,
 * which rewrites a line of `size` bytes of room; each may be NULL. A setting of the process until
 * it is made again: `place` must stay as long. For programs, and not while several threads warn. */
void config_warn_under(const char *place, void (*words)(char *line, size_t size));

/* Prints "thrum: warning: <line>" on standard error. */
__attribute__((format(printf, 1, 2))) void config_warn(const char *format, ...);

#endif
