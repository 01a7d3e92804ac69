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

#define CONFIG_RECORD_PATH_MAX 96
#define CONFIG_RECORD_ITEMS_MAX 10000 /* of one list */

typedef enum config_key_kind {
  CONFIG_KEY_BOOL = 0, /* bool */
  CONFIG_KEY_NUMBER,   /* double, in the table's range */
  CONFIG_KEY_COUNT,    /* int64_t, in the table's range */
  CONFIG_KEY_VECTOR,   /* double[3], in the table's range */
  CONFIG_KEY_TEXT,     /* const char *, not empty; stays as long as the document */
  CONFIG_KEY_TEXTS,    /* config_texts; one text, or a list of them */
  CONFIG_KEY_CHOICE,   /* one of the table's names; through `choose` */
  CONFIG_KEY_OBJECT,   /* a record of the table `keys`; a struct that begins with a config_record */
  CONFIG_KEY_LIST,     /* config_list of such records */
  CONFIG_KEY_OWN       /* through `take`; `schema` is its JSON schema */
} config_key_kind;

/* Where a record stands; the first member of every struct that is read. */
typedef struct config_record {
  const json_node *node;             /* NULL: it was not there */
  char path[CONFIG_RECORD_PATH_MAX]; /* "bodies[0]"; "" for the whole */
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

/* A file that is being read, and then the owner of the texts in its records. */
typedef struct config_record_file {
  const char *name;
  json_document document;
  thrum_error *error;
} config_record_file;

typedef struct config_key {
  const char *name; /* the table ends with a nameless key */
  config_key_kind kind;
  size_t field;       /* offset in the record */
  double least, most; /* range, unlimited while both are 0; INFINITY may stand for most */
  bool above, below;  /* least itself, most itself is not in it */
  bool needed;
  const char *const *names;                /* of a choice: ends with NULL */
  void (*choose)(void *record, int index); /* of a choice: the name's place */
  const struct config_key *keys;           /* of an object or a list */
  size_t size;                             /* of an item of a list */
  void (*begin)(void *item,
                const void *in); /* fills an item's defaults; `in` is the record that the
                                   list stands in, whose other keys are read by then */
  thrum_status (*take)(const config_record_file *file, const config_record *record,
                       const struct config_key *key, const json_node *value, void *to);
  const char *schema;   /* of CONFIG_KEY_OWN */
  const char *unit;     /* "" or NULL: none */
  const char *fallback; /* what holds without it, in words */
  const char *about;    /* one line */
} config_key;

/* Reads the object `node` into the record at `to`, which holds the defaults. What was read so far
 * is to be freed with config_record_free whatever comes back. */
thrum_status config_record_read(const config_record_file *file, const config_key *keys,
                                const json_node *node, void *to);
/* Frees the lists of a record, and of those in it. */
void config_record_free(const config_key *keys, void *record);

/* "FILE:LINE: PATH.KEY: ..." and returns `status`; the line is that of the key, where it is there;
 * key NULL: of the record. */
__attribute__((format(printf, 5, 6))) thrum_status
config_record_refuse(const config_record_file *file, const config_record *record, const char *key,
                     thrum_status status, const char *format, ...);

/* The same of one text of a list, by its own line: "PATH.KEY[2]: ...". */
__attribute__((format(printf, 6, 7))) thrum_status
config_record_refuse_text(const config_record_file *file, const config_record *record,
                          const char *key, const config_texts *texts, int64_t index,
                          const char *format, ...);

/* "... wants WANTS, not what is there"; the line is the value's. */
thrum_status config_record_wrong(const config_record_file *file, const config_record *record,
                                 const config_key *key, const json_node *value, const char *wants);

/* The member of an object, NULL when it is not there. */
const json_node *config_record_member(const config_record_file *file, const config_record *record,
                                      const char *key);

/* For `take`: `count` numbers of an array, finite; false when it is none. */
bool config_record_numbers(const config_record_file *file, const json_node *value, int64_t count,
                           double *numbers);

/* The JSON schema (draft 7) of a file. */
cJSON *config_record_schema(const char *title, const config_key *keys);

#endif
