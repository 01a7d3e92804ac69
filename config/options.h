/* Options of the subcommands: one table for each command says what there is, what it takes and
 * where it goes; getopt_long, the messages, options files and their schema all follow the table.
 *
 * A new option is one line in its command's table, a line in its help, and one in the document of
 * the command. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_OPTIONS_H
#define THRUM_CONFIG_OPTIONS_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/json_read.h"

#define CONFIG_OPTION_MAX 48 /* of one command */
#define CONFIG_THREADS_MAX 1024

/* What an option takes, and the type of the field that it goes to. */
typedef enum config_kind {
  CONFIG_FLAG = 0, /* nothing; bool */
  CONFIG_NUMBER,   /* a finite number in the table's range; double */
  CONFIG_COUNT,    /* a whole number in the table's range; int64_t */
  CONFIG_TEXT,     /* any text; const char *, which points to where it was given */
  CONFIG_CHOICE,   /* one of the table's names; through `choose` */
  CONFIG_WORD,     /* a number or a text; through `take` */
  CONFIG_PAIR,     /* one number or two with a comma between; through `take` */
  CONFIG_FILE      /* an options file; config_options_file */
} config_kind;

/* When a text of an options file names a file beside it, and not one in the working folder. */
typedef enum config_path {
  CONFIG_PATH_NONE = 0,
  CONFIG_PATH_ALWAYS,
  CONFIG_PATH_NAMED,   /* unless it is the name of a model, or begins with KIND: such as beam: */
  CONFIG_PATH_IF_THERE /* if there is such a file, whatever :xyz follows its name */
} config_path;

/* Does a text of a file in `folder` (with its slash; "" for the working folder) name a file there?
 */
bool config_is_beside(config_path path, const char *folder, const char *text);

#define CONFIG_FILE_ITEMS_MAX 256 /* repeated options of one file, all of them together */

/* What an options file said: the texts that a request points to. */
typedef struct config_options_file {
  json_document document;
  char *folder; /* of the file, with its slash; "" when it lies in the working folder */
  char **texts;
  int64_t text_count;
} config_options_file;
void config_options_file_free(config_options_file *file);

/* One option as it was given, for `take` and for messages. */
typedef struct config_given {
  const char *command; /* "precompute" */
  const struct config_option *option;
  const char *text; /* NULL for flags */
  const char *file; /* the options file it stands in; NULL: the command line */
  int64_t line;     /* in the file */
} config_given;

typedef struct config_option {
  const char *name; /* long name; the table ends with a nameless option */
  int letter;       /* short name, or 0 */
  config_kind kind;
  size_t field;       /* offset in the request, unless `take` or `choose` is there */
  double least, most; /* range, unlimited while both are 0; INFINITY may stand for most */
  bool above, below;  /* least itself, most itself is not in it */
  bool repeats;       /* each time adds one */
  bool argument;      /* no option: the one argument that has no name; text, for options files */
  config_path path;
  const char *const *names; /* CONFIG_CHOICE: ends with NULL */
  const char *wants;        /* what a message says that it wants; NULL: of its kind */
  int (*take)(const config_given *given,
              void *request);               /* COMMAND_DONE, or the code of a message */
  void (*choose)(void *request, int index); /* CONFIG_CHOICE: the name's place */
  void (*help)(void);                       /* prints the command's help */
} config_option;

/* Reads argv by the table into a request, which holds the defaults; optind is then the first
 * argument that is no option. An options file, where the table has one, comes first; an option of
 * the command line takes the place of the file's. COMMAND_DONE, or the code after one line was
 * printed, or COMMAND_HELPED at --help, once that is printed. */
int config_options_read(const char *command, const config_option *table, int argc, char **argv,
                        void *request);

/* "--NAME wants ..., not 'TEXT'", with the table's `wants`, or what the kind and range say. */
int config_given_wrong(const config_given *given);
/* The same with other words for what it wants, and without the text. */
int config_given_wants(const config_given *given, const char *wants);
/* A line about an option in words of its own: "--NAME: ...". */
__attribute__((format(printf, 2, 3))) int config_given_refuse(const config_given *given,
                                                              const char *format, ...);

/* For `take`: the text as what the kind says, in the table's range; value untouched on failure. */
int config_given_number(const config_given *given, double *value);
int config_given_count(const config_given *given, int64_t *value);
/* "A" or "A,B", none negative; B stays when it is not given. */
int config_given_pair(const config_given *given, double pair[2]);
/* Whole numbers in the table's range with commas between, 1 to `most` of them. */
int config_given_counts(const config_given *given, int64_t most, int64_t *values, int64_t *count);

/* Puts one option into the request, as the kind says. */
int config_given_apply(const config_given *given, void *request);

/* Applies an options file to the request, without the options marked in `overridden` (by their
 * place in the table). COMMAND_DONE, or COMMAND_REFUSED after one line with the file and the line.
 */
int config_options_file_apply(const char *command, const config_option *table, const char *path,
                              const bool *overridden, config_options_file *file, void *request);

/* The JSON schema of a command's options files. */
cJSON *config_options_schema(const char *command, const config_option *table);

/* The one argument that is no option (`what`: "mesh"), once the options are read; *value may hold
 * what an options file said. */
int config_one_argument(const char *command, const char *what, int argc, char **argv,
                        const char **value);

/* The place of `text` among names that end with NULL, or -1. */
int config_name_index(const char *text, const char *const *names);

/* "off" and "on". */
extern const char *const config_switches[];

/* What every command has, at the end of its table. */
#define CONFIG_OPTION_JSON(request)                                                                \
  { .name = "json", .kind = CONFIG_FLAG, .field = offsetof(request, json) }
#define CONFIG_OPTION_FILE(request)                                                                \
  { .name = "options", .kind = CONFIG_FILE, .field = offsetof(request, file) }
#define CONFIG_OPTION_QUIET(request)                                                               \
  { .name = "quiet", .letter = 'q', .kind = CONFIG_FLAG, .field = offsetof(request, quiet) }
#define CONFIG_OPTION_HELP(print)                                                                  \
  { .name = "help", .letter = 'h', .kind = CONFIG_FLAG, .help = print }

#endif
