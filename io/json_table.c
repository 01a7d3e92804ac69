/* See json_table.h. Numbers are added as raw text (json.c), so they are read back from there.
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/json_table.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "io/json.h"

/* A text in quotes where it may hold a comma, RFC 4180. */
static void put_text(FILE *stream, const char *text) {
  if (strpbrk(text, ",\"\n") == NULL) {
    fputs(text, stream);
    return;
  }
  fputc('"', stream);
  for (const char *at = text; *at != 0; at++)
    fprintf(stream, *at == '"' ? "\"\"" : "%c", *at);
  fputc('"', stream);
}

/* The keys of a row, or its values; *first: nothing stands before it on the line. */
static void put_cells(FILE *stream, const cJSON *row, bool keys, bool *first) {
  const cJSON *item;
  cJSON_ArrayForEach(item, row) {
    if (cJSON_IsObject(item)) {
      put_cells(stream, item, keys, first);
      continue;
    }

    // a comma between cells; objects within a row are cells of it
    if (!*first)
      fputc(',', stream);
    *first = false;

    if (keys)
      fputs(item->string, stream);
    else if (cJSON_IsString(item))
      put_text(stream, item->valuestring);
    else if (cJSON_IsRaw(item))
      fprintf(stream, "%.10g", strtod(item->valuestring, NULL));
    else if (cJSON_IsBool(item))
      fputc(cJSON_IsTrue(item) ? '1' : '0', stream);
  }
}

static void put_line(FILE *stream, const cJSON *row, bool keys) {
  bool first = true;
  put_cells(stream, row, keys, &first);
  fputc('\n', stream);
}

thrum_status json_table_csv(FILE *stream, const cJSON *rows, thrum_error *error) {
  if (json_memory_failed())
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the rows of a table");
  const cJSON *row;
  put_line(stream, cJSON_GetArrayItem(rows, 0), true);
  cJSON_ArrayForEach(row, rows) put_line(stream, row, false);
  return THRUM_OK;
}

static void print_row(const cJSON *row, const json_column *columns) {
  for (const json_column *column = columns; column->key != NULL; column++) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(row, column->key);
    char text[64] = "-";
    if (cJSON_IsRaw(item))
      snprintf(text, sizeof text, column->format, column->scale * strtod(item->valuestring, NULL));
    printf("%s%*s", column > columns ? " " : "", column->width,
           cJSON_IsString(item) ? item->valuestring : text);
  }
  putchar('\n');
}

void json_table_print(const cJSON *rows, const json_column *columns) {
  const cJSON *row;
  for (const json_column *column = columns; column->key != NULL; column++)
    printf("%s%*s", column > columns ? " " : "", column->width, column->heading);
  putchar('\n');
  cJSON_ArrayForEach(row, rows) print_row(row, columns);
}
