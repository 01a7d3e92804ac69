/* Options of the subcommands: one table for each command says what there is, what it takes and
 * where it goes; getopt_long, the messages, options files and their schema all follow the table.
 *
 * A new option is one line in its command's table, a line in its help, and one in the document of
 * the command. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_ARGS_H
#define THRUM_CLI_ARGS_H

#include <stddef.h>

#include "cli/cli.h"

#define CLI_OPTION_MAX 48 /* of one command */
#define CLI_THREADS_MAX 1024

/* What an option takes, and the type of the field that it goes to. */
typedef enum cli_kind {
  CLI_FLAG = 0, /* nothing; bool */
  CLI_NUMBER,   /* a finite number in the table's range; double */
  CLI_COUNT,    /* a whole number in the table's range; int64_t */
  CLI_TEXT,     /* any text; const char *, which points to where it was given */
  CLI_CHOICE,   /* one of the table's names; through `choose` */
  CLI_WORD,     /* a number or a text; through `take` */
  CLI_PAIR      /* one number or two with a comma between; through `take` */
} cli_kind;

/* One option as it was given, for `take` and for messages. */
typedef struct cli_given {
  const char *command; /* "precompute" */
  const struct cli_option *option;
  const char *text; /* NULL for flags */
} cli_given;

typedef struct cli_option {
  const char *name; /* long name; the table ends with a nameless option */
  int letter;       /* short name, or 0 */
  cli_kind kind;
  size_t field;             /* offset in the request, unless `take` or `choose` is there */
  double least, most;       /* range, unlimited while both are 0; INFINITY may stand for most */
  bool above;               /* least itself is not in it */
  bool repeats;             /* each time adds one */
  const char *const *names; /* CLI_CHOICE: ends with NULL */
  const char *wants;        /* what a message says that it wants; NULL: of its kind */
  int (*take)(const cli_given *given, void *request); /* CLI_DONE, or the code of a message */
  void (*choose)(void *request, int index);           /* CLI_CHOICE: the name's place */
} cli_option;

/* Reads argv by the table into a request, which holds the defaults; *optind is then the first
 * argument that is no option. Stops at --help. CLI_DONE, or the code after one line was printed. */
int cli_options_read(const char *command, const cli_option *table, int argc, char **argv,
                     void *request);

/* "--NAME wants ..., not 'TEXT'", with the table's `wants`, or what the kind and range say. */
int cli_given_wrong(const cli_given *given);
/* A line about an option in words of its own: "--NAME: ...". */
__attribute__((format(printf, 2, 3))) int cli_given_refuse(const cli_given *given,
                                                           const char *format, ...);

/* For `take`: the text as what the kind says, in the table's range; value untouched on failure. */
int cli_given_number(const cli_given *given, double *value);
int cli_given_count(const cli_given *given, int64_t *value);
/* "A" or "A,B", none negative; B stays when it is not given. */
int cli_given_pair(const cli_given *given, double pair[2]);
/* Whole numbers in the table's range with commas between, 1 to `most` of them. */
int cli_given_counts(const cli_given *given, int64_t most, int64_t *values, int64_t *count);

/* The one argument that is no option (`what`: "mesh"), once the options are read. */
int cli_one_argument(const char *command, const char *what, int argc, char **argv,
                     const char **value);

/* The place of `text` among names that end with NULL, or -1. */
int cli_name_index(const char *text, const char *const *names);

/* "off" and "on". */
extern const char *const cli_switches[];

/* What every command has, at the end of its table. */
#define CLI_OPTION_JSON(request)                                                                   \
  { .name = "json", .kind = CLI_FLAG, .field = offsetof(request, json) }
#define CLI_OPTION_QUIET(request)                                                                  \
  { .name = "quiet", .letter = 'q', .kind = CLI_FLAG, .field = offsetof(request, quiet) }
#define CLI_OPTION_HELP(request)                                                                   \
  { .name = "help", .letter = 'h', .kind = CLI_FLAG, .field = offsetof(request, help) }

#endif
