/* The configuration table: one row for each option of a command and each key of a scene file.
 *
 * A row says what the option takes, in which range and unit, what holds without it, and where it
 * goes. getopt_long, JSON files, messages, JSON schemas, --help, the manual page, the reference in
 * docs/reference and the completion of the shell all follow the table, so a new option is one row.
 *
 * A mistake is named by where it stands:
 *   --dt wants a number above 0 s, not '-1'                      (with the command, exit code 2)
 *   scene.json:12: bodies[0].rank: wants a whole number from 1 to 512, not 2.5
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_OPTIONS_H
#define THRUM_CONFIG_OPTIONS_H

#include <cjson/cJSON.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "io/json_read.h"
#include "thrum/status.h"

#define CONFIG_OPTION_MAX 64 /* of one table, with those of its groups */
#define CONFIG_PATH_MAX 96   /* of a record: "bodies[0]" */
#define CONFIG_ITEMS_MAX 10000
#define CONFIG_FILE_ITEMS_MAX 256 /* repeated options of one file, all of them together */
#define CONFIG_THREADS_MAX 1024

/* The kind of value, and in brackets what its field holds. */
typedef enum config_kind {
  CONFIG_HEADING = 0, /* no option: a heading of the help */
  CONFIG_GROUP,       /* the rows of the table `keys`, in the struct at the field */
  CONFIG_FLAG,        /* nothing; true or false in a file (bool, or an integer or enum: `set`) */
  CONFIG_SWITCH,      /* on or off (bool or integer) */
  CONFIG_NUMBER,      /* a finite number in the range (double) */
  CONFIG_COUNT,       /* a whole number in the range (integer) */
  CONFIG_PAIR,   /* one number or two with a comma between (double[2]; without the second, 0) */
  CONFIG_VECTOR, /* three numbers in the range (double[3]) */
  CONFIG_CHOICE, /* one of the names: its place among them (bool, integer or enum) */
  CONFIG_WORD,   /* a number or a text, through `take`; with a `schema` any JSON */
  CONFIG_TEXT,   /* any text, which is not copied (const char *); with `names` a list of some of
                    them (bool for each), with `counted` a list of numbers (double for each) */
  CONFIG_TEXTS,  /* one text or a list of them (config_texts) */
  CONFIG_OBJECT, /* of a file: a record of the table `keys` (begins with a config_record) */
  CONFIG_LIST,   /* of a file: such records (config_list) */
  CONFIG_FILE    /* an options file (config_file) */
} config_kind;

/* Where a text of a file names a file beside it, and not one in the working folder. */
typedef enum config_path {
  CONFIG_PATH_NONE = 0,
  CONFIG_PATH_ALWAYS,
  CONFIG_PATH_NAMED,   /* unless `is_name` says that it is a name or a spec and no file */
  CONFIG_PATH_IF_THERE /* if there is such a file, whatever :xyz follows its name */
} config_path;

/* A JSON file that is being read, and then the owner of the texts in its records. */
typedef struct config_file {
  const char *name;
  json_document document;
  char *folder; /* of the file, with its slash; "" when it lies in the working folder */
  char **texts; /* owned: the texts that are not in the document */
  int64_t text_count;
  thrum_error *error;
  /* rewrites messages, `size` bytes of room, in the words of such files; NULL: as they are */
  void (*words)(char *message, size_t size);
} config_file;

/* Where a record stands; the first member of every struct that is read from a file. */
typedef struct config_record {
  const json_node *node;      /* NULL: it was not there */
  char path[CONFIG_PATH_MAX]; /* "bodies[0]"; "" for the whole */
} config_record;

typedef struct config_texts {
  const char **texts;      /* owned */
  const json_node **nodes; /* where each stands; owned */
  int64_t count;
} config_texts;

typedef struct config_list {
  void *items; /* owned */
  int64_t count;
} config_list;

/* One option as it was given, for `take` and for messages. */
typedef struct config_given {
  const struct config_option *option;
  const char *text;      /* as on the command line; NULL: a flag, or JSON that has no such form */
  config_file *file;     /* the file it stands in; NULL: the command line */
  const json_node *node; /* its value there */
  const char *key;       /* how the file spells the name */
  int64_t line;          /* in the file */
  int64_t index;         /* in a list of values; -1: no list */
  const config_record *record;
  thrum_error *error;
} config_given;

typedef struct config_option {
  const char *name; /* with dashes; a file may also write '_'. The table ends with about == NULL */
  int letter;       /* short name, or 0 */
  config_kind kind;
  const char *value;    /* stands for the value in the help, "FILE"; NULL: by its kind */
  const char *unit;     /* NULL: none */
  const char *fallback; /* what holds without it, in words; NULL: nothing to say */
  const char *about;    /* one line */
  size_t field, size;   /* place and size of the field in the request or record */
  size_t given;         /* place of a bool that becomes true, not 0; 0: none */
  size_t counted;     /* place of an int64_t, not 0: the length of a list of numbers; 0: no list */
  int64_t set;        /* CONFIG_FLAG: what the field becomes; 0: 1; or what `take` makes of it */
  double least, most; /* range, unlimited while both are 0; INFINITY may stand for most */
  bool above, below;  /* least itself, most itself is not in it */
  bool repeats;       /* each time adds one */
  bool argument;      /* no option: the one argument that has no name; text, for options files */
  bool needed;        /* of a record: must be there */
  bool helps;         /* prints help, and is no key of a file */
  config_path path;
  bool (*is_name)(const char *text);
  const char *const *names; /* CONFIG_CHOICE: ends with NULL; of a list: as many as the field has */
  const char *wants;        /* what a message says that it wants; NULL: by its kind */
  const char *schema;       /* JSON schema, where the kind does not say it all */
  thrum_status (*take)(const config_given *given, void *record);
  thrum_status (*check)(const char *text, thrum_error *error); /* of each text */
  const struct config_option *keys;                            /* of a group, object or list */
  size_t item_size;                                            /* of a list */
  void (*begin)(void *item, const void *in); /* an item's defaults; `in` holds the list */
} config_option;

/* A command as its help and the reference describe it. */
typedef struct config_command {
  const char *name;    /* "simulate", "bench step" */
  const char *summary; /* one line, for the list of commands */
  const char *usage;   /* what follows the name; one form a line */
  const char *about;   /* paragraphs, a line each */
  const config_option *options;
  const char *often;    /* names of options that --help shows, blanks between; NULL: all of them */
  const char *notes;    /* after the options, printed as it is; NULL: none */
  const char *examples; /* one a line, without "thrum" in front */
  const char *exits;    /* exit codes; NULL: the usual */
} config_command;

/* Rows of tables: the fields that every kind needs, and then designators. */
#define CONFIG_AT(type, member) .field = offsetof(type, member), .size = sizeof(((type *)0)->member)
#define CONFIG_ABOVE(a) .least = a, .most = INFINITY, .above = true
#define CONFIG_FROM(a) .least = a, .most = INFINITY
#define CONFIG_RANGE(a, b) .least = a, .most = b
#define OPTION_END                                                                                 \
  { .about = NULL }
#define OPTION_HEADING(text)                                                                       \
  { .kind = CONFIG_HEADING, .about = text }
#define OPTION_GROUP(table, text, ...)                                                             \
  { .kind = CONFIG_GROUP, .keys = table, .about = text, __VA_ARGS__ }
#define OPTION_ROW(n, of_kind, otherwise, text, ...)                                               \
  { .name = n, .kind = of_kind, .fallback = otherwise, .about = text, __VA_ARGS__ }
#define OPTION_FLAG(n, text, ...)                                                                  \
  { .name = n, .kind = CONFIG_FLAG, .about = text, __VA_ARGS__ }
#define OPTION_SWITCH(n, otherwise, text, ...)                                                     \
  OPTION_ROW(n, CONFIG_SWITCH, otherwise, text, __VA_ARGS__)
#define OPTION_NUMBER(n, of_unit, otherwise, text, ...)                                            \
  OPTION_ROW(n, CONFIG_NUMBER, otherwise, text, .unit = of_unit, __VA_ARGS__)
#define OPTION_COUNT(n, otherwise, text, ...)                                                      \
  OPTION_ROW(n, CONFIG_COUNT, otherwise, text, __VA_ARGS__)
#define OPTION_PAIR(n, otherwise, text, ...)                                                       \
  OPTION_ROW(n, CONFIG_PAIR, otherwise, text, __VA_ARGS__)
#define OPTION_VECTOR(n, of_unit, otherwise, text, ...)                                            \
  OPTION_ROW(n, CONFIG_VECTOR, otherwise, text, .unit = of_unit, __VA_ARGS__)
#define OPTION_CHOICE(n, of_names, otherwise, text, ...)                                           \
  OPTION_ROW(n, CONFIG_CHOICE, otherwise, text, .names = of_names, __VA_ARGS__)
#define OPTION_WORD(n, stands_for, otherwise, text, ...)                                           \
  OPTION_ROW(n, CONFIG_WORD, otherwise, text, .value = stands_for, __VA_ARGS__)
#define OPTION_TEXT(n, stands_for, otherwise, text, ...)                                           \
  OPTION_ROW(n, CONFIG_TEXT, otherwise, text, .value = stands_for, __VA_ARGS__)
#define OPTION_TEXTS(n, otherwise, text, ...)                                                      \
  OPTION_ROW(n, CONFIG_TEXTS, otherwise, text, __VA_ARGS__)
#define OPTION_OBJECT(n, table, otherwise, text, ...)                                              \
  OPTION_ROW(n, CONFIG_OBJECT, otherwise, text, .keys = table, __VA_ARGS__)
#define OPTION_LIST(n, table, type, otherwise, text, ...)                                          \
  OPTION_ROW(n, CONFIG_LIST, otherwise, text, .keys = table, .item_size = sizeof(type), __VA_ARGS__)

/* The rows that most commands have at the end of their tables. */
#define OPTION_FILE(type)                                                                          \
  {                                                                                                \
    .name = "options", .kind = CONFIG_FILE,                                                        \
    .about = "read options from a JSON file (docs/options.md); the command line overrides it",     \
    CONFIG_AT(type, file)                                                                          \
  }
#define OPTION_JSON(type)                                                                          \
  OPTION_FLAG("json", "print one JSON object instead of the table", CONFIG_AT(type, json))
#define OPTION_QUIET(type)                                                                         \
  OPTION_FLAG("quiet", "no progress", .letter = 'q', CONFIG_AT(type, quiet))
#define OPTION_HELP OPTION_FLAG("help", "this text", .letter = 'h', .helps = true)

/* In place of it, for a command that says which of its options are used often. */
#define OPTION_HELP_TWICE                                                                          \
  OPTION_FLAG("help", "what is used often", .letter = 'h', .helps = true),                         \
      OPTION_FLAG("help-all", "all options, and how they are written", .helps = true)

/* One row of a table whose groups are spread out, and where its record begins in the request. */
typedef struct config_row {
  const config_option *option;
  size_t base;
} config_row;

/* Spreads a table out, without headings; returns the number of rows. */
int config_rows(const config_option *table, config_row rows[CONFIG_OPTION_MAX]);

/* --- values ----------------------------------------------------------------------------------- */

/* Fails with "wants ..., not ...", with the row's `wants`, or what its kind and range say. */
thrum_status config_given_wrong(const config_given *given);
/* Fails with a line of its own. */
__attribute__((format(printf, 2, 3))) thrum_status config_given_refuse(const config_given *given,
                                                                       const char *format, ...);

/* For `take`: the text as a whole number, or as numbers with commas between, `least` to `most` of
 * them, all in the row's range. */
thrum_status config_given_count(const config_given *given, int64_t *value);
thrum_status config_given_numbers(const config_given *given, int64_t least, int64_t most,
                                  double *values, int64_t *count);
/* The same, all whole. */
thrum_status config_given_counts(const config_given *given, int64_t most, int64_t *values,
                                 int64_t *count);
/* Puts one option into the record, as its kind says. */
thrum_status config_given_apply(const config_given *given, void *record);

/* "a number above 0 s"; "imexv, newmark or energy" */
const char *config_wants(const config_option *option, char *text, size_t size);

/* --- commands --------------------------------------------------------------------------------- */

/* Reads argv by the command's table into a request, which holds the defaults; optind is then the
 * first argument that is no option. An options file, where the table has one, comes first; an
 * option of the command line takes the place of the file's. COMMAND_DONE, or the code after one
 * line was printed, or COMMAND_HELPED at --help, once that is printed. */
int config_options_read(const config_command *command, int argc, char **argv, void *request);

/* The same of a command with one argument that is no option (`what`: "mesh"); *value may hold what
 * an options file said. */
int config_options_read_one(const config_command *command, const char *what, int argc, char **argv,
                            void *request, const char **value);

/* --- files ------------------------------------------------------------------------------------ */

/* Reads a JSON file, or `length` bytes of one (`name` stands in messages); `what` it is: "scene
 * file". `name` and `error` must stay as long as the file. config_file_free frees it, whatever came
 * back. */
thrum_status config_file_open(const char *path, const char *what, config_file *file,
                              thrum_error *error);
thrum_status config_file_parse(const char *name, const char *bytes, size_t length,
                               config_file *file, thrum_error *error);
void config_file_free(config_file *file);

/* Applies an options file to the request, without the rows marked in `overridden`. */
thrum_status config_file_apply(config_file *file, const config_command *command,
                               const bool *overridden, void *request);

/* Reads the whole file into the record at `to`, which holds the defaults. What was read so far is
 * to be freed with config_record_free whatever comes back. */
thrum_status config_record_read(config_file *file, const config_option *keys, void *to);
/* For `take`: reads the value, an object, into the record at `to`. */
thrum_status config_object_read(const config_given *given, const config_option *keys, void *to);
/* Frees the lists of a record, and of those in it. */
void config_record_free(const config_option *keys, void *record);

/* "FILE:LINE: PATH.KEY: ..." and returns `status`; the line is that of the key, where it is there;
 * key NULL: of the record. */
__attribute__((format(printf, 5, 6))) thrum_status
config_record_refuse(const config_file *file, const config_record *record, const char *key,
                     thrum_status status, const char *format, ...);

/* The same of one text of a list, by its own line: "PATH.KEY[2]: ...". */
__attribute__((format(printf, 6, 7))) thrum_status
config_record_refuse_text(const config_file *file, const config_record *record, const char *key,
                          const config_texts *texts, int64_t index, const char *format, ...);

/* The member of an object, in either spelling; NULL when it is not there. */
const json_node *config_record_member(const config_file *file, const config_record *record,
                                      const char *key);

/* --- what is made of the tables --------------------------------------------------------------- */

/* The JSON schema (draft 7) of a file. Keys of records are written with '_', of commands with '-'.
 */
cJSON *config_schema(const char *title, const config_option *table, bool records);

/* Prints the help of a command; its section of the reference in Markdown or of the manual page in
 * troff; and the tables of the keys of a file. */
void config_print_help(const config_command *command, bool all);
void config_print_markdown(const config_command *command);
void config_print_man(const config_command *command);
void config_print_keys(const char *title, const config_option *keys);
/* Prints the lines of a shell's `case` for a command: "simulate) words="--dt ..." ;;" */
void config_print_completion(const config_command *command);

#endif
