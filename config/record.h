/* Records of a JSON file, by tables: one table says which keys an object has, what they take, in
 * which unit, and where they go; the reader, its messages, the schema and the list of keys in the
 * documentation follow the table.
 *
 * A message names the file, the line and the path of what is wrong:
 *   scene.json:12: bodies[0].rank: 40 is not 1 to 30
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_RECORD_H
#define THRUM_CONFIG_RECORD_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

#include "io/json_read.h"

#define CLI_RECORD_PATH_MAX 96
#define CLI_RECORD_ITEMS_MAX 10000 /* of one list */

typedef enum cli_key_kind {
  CLI_KEY_BOOL = 0, /* bool */
  CLI_KEY_NUMBER,   /* double, in the table's range */
  CLI_KEY_COUNT,    /* int64_t, in the table's range */
  CLI_KEY_VECTOR,   /* double[3], in the table's range */
  CLI_KEY_TEXT,     /* const char *, not empty; stays as long as the document */
  CLI_KEY_TEXTS,    /* cli_texts; one text, or a list of them */
  CLI_KEY_CHOICE,   /* one of the table's names; through `choose` */
  CLI_KEY_OBJECT,   /* a record of the table `keys`; a struct that begins with a cli_record */
  CLI_KEY_LIST,     /* cli_list of such records */
  CLI_KEY_OWN       /* through `take`; `schema` is its JSON schema */
} cli_key_kind;

/* Where a record stands; the first member of every struct that is read. */
typedef struct cli_record {
  const cli_json_node *node;      /* NULL: it was not there */
  char path[CLI_RECORD_PATH_MAX]; /* "bodies[0]"; "" for the whole */
} cli_record;

typedef struct cli_texts {
  const char **texts;          /* owned */
  const cli_json_node **nodes; /* where each stands; owned */
  int64_t count;
} cli_texts;

typedef struct cli_list {
  void *items; /* owned */
  int64_t count;
} cli_list;

/* A file that is being read, and then the owner of the texts in its records. */
typedef struct cli_record_file {
  const char *name;
  cli_json_document document;
  thrum_error *error;
} cli_record_file;

typedef struct cli_key {
  const char *name; /* the table ends with a nameless key */
  cli_key_kind kind;
  size_t field;       /* offset in the record */
  double least, most; /* range, unlimited while both are 0; INFINITY may stand for most */
  bool above, below;  /* least itself, most itself is not in it */
  bool needed;
  const char *const *names;                /* of a choice: ends with NULL */
  void (*choose)(void *record, int index); /* of a choice: the name's place */
  const struct cli_key *keys;              /* of an object or a list */
  size_t size;                             /* of an item of a list */
  void (*begin)(void *item,
                const void *in); /* fills an item's defaults; `in` is the record that the
                                   list stands in, whose other keys are read by then */
  thrum_status (*take)(const cli_record_file *file, const cli_record *record,
                       const struct cli_key *key, const cli_json_node *value, void *to);
  const char *schema;   /* of CLI_KEY_OWN */
  const char *unit;     /* "" or NULL: none */
  const char *fallback; /* what holds without it, in words */
  const char *about;    /* one line */
} cli_key;

/* Reads the object `node` into the record at `to`, which holds the defaults. What was read so far
 * is to be freed with cli_record_free whatever comes back. */
thrum_status cli_record_read(const cli_record_file *file, const cli_key *keys,
                             const cli_json_node *node, void *to);
/* Frees the lists of a record, and of those in it. */
void cli_record_free(const cli_key *keys, void *record);

/* "FILE:LINE: PATH.KEY: ..." and returns `status`; the line is that of the key, where it is there;
 * key NULL: of the record. */
__attribute__((format(printf, 5, 6))) thrum_status
cli_record_refuse(const cli_record_file *file, const cli_record *record, const char *key,
                  thrum_status status, const char *format, ...);

/* The same of one text of a list, by its own line: "PATH.KEY[2]: ...". */
__attribute__((format(printf, 6, 7))) thrum_status
cli_record_refuse_text(const cli_record_file *file, const cli_record *record, const char *key,
                       const cli_texts *texts, int64_t index, const char *format, ...);

/* "... wants WANTS, not what is there"; the line is the value's. */
thrum_status cli_record_wrong(const cli_record_file *file, const cli_record *record,
                              const cli_key *key, const cli_json_node *value, const char *wants);

/* The member of an object, NULL when it is not there. */
const cli_json_node *cli_record_member(const cli_record_file *file, const cli_record *record,
                                       const char *key);

/* For `take`: `count` numbers of an array, finite; false when it is none. */
bool cli_record_numbers(const cli_record_file *file, const cli_json_node *value, int64_t count,
                        double *numbers);

/* The JSON schema (draft 7) of a file. */
cJSON *cli_record_schema(const char *title, const cli_key *keys);

#endif
