/* Reads JSON with the line of every value, so that a mistake in a file that people write is named
 * by its line.
 *
 * The format is RFC 8259 and no more: no comments, no trailing commas, no key twice in an object.
 * Cost: linear in the text, but quadratic in the number of keys of one object.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_JSON_READ_H
#define THRUM_IO_JSON_READ_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define JSON_BYTES_MAX 1048576 /* of a text */
#define JSON_DEPTH_MAX 32
#define JSON_KEYS_MAX 1024 /* of one object */

typedef enum json_type {
  JSON_NULL,
  JSON_FALSE,
  JSON_TRUE,
  JSON_NUMBER,
  JSON_STRING,
  JSON_ARRAY,
  JSON_OBJECT
} json_type;

/* A value. Its children follow each other by `next`; -1 ends them. */
typedef struct json_node {
  json_type type;
  int64_t line;     /* 1-based, where it begins; for a member of an object where its key begins */
  const char *key;  /* for a member of an object; NULL otherwise */
  const char *text; /* a string without its escapes, a number as it was written */
  int64_t first, next;
} json_node;

typedef struct json_document {
  json_node *nodes; /* nodes[0] is the whole; owned */
  int64_t count;
  char *texts; /* owned */
} json_document;

/* Reads `length` bytes; `name` stands before ":LINE:" in messages. *document is untouched on
 * failure; free it with json_free. */
thrum_status json_read(const char *name, const char *bytes, size_t length, json_document *document,
                       thrum_error *error);
void json_free(json_document *document);

#endif
