/* Tables of results: an array of JSON objects with the same keys, a row each, as comma-separated
 * values for programs and in columns for people. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_JSON_TABLE_H
#define THRUM_IO_JSON_TABLE_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "thrum/status.h"

/* A column for people. */
typedef struct json_column {
  const char *key; /* of the rows */
  const char *heading;
  int width;          /* as printf has it: negative is to the left */
  const char *format; /* of a number, "%.2f"; NULL: a text */
  double scale;       /* times the number */
} json_column;
#define COLUMN_TEXT(key, heading, width)                                                           \
  { key, heading, width, NULL, 1 }
#define COLUMN_NUMBER(key, heading, width, format)                                                 \
  { key, heading, width, format, 1 }
#define COLUMN_PERCENT(key, heading, width, format)                                                \
  { key, heading, width, format, 100 }
#define COLUMN_END                                                                                 \
  { NULL, NULL, 0, NULL, 0 }

/* A line of the first row's keys, then a line for each row; an object within a row is spread out. A
 * number has ten digits, and is left empty where it is null. THRUM_OUT_OF_MEMORY where the rows
 * were made without memory for some of their parts (json_memory_failed); an error of the stream
 * leaves its mark on it. */
thrum_status json_table_csv(FILE *stream, const cJSON *rows, thrum_error *error);

/* A line of headings, then the rows, on standard output; a number that is null is a dash. */
void json_table_print(const cJSON *rows, const json_column *columns);

#endif
