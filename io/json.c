/* Writes results for other programs: one JSON object on one line of standard output.
 *
 * cJSON's own numbers may lose the last digits, so numbers are added as text: the shortest of 15 to
 * 17 digits that reads back as the same double. SPDX-License-Identifier: Apache-2.0 */
#include "io/json.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "io/number_text.h"
#include "io/text.h"
#include "thrum/thrum.h"

static atomic_bool memory_failed;

static void *watched_malloc(size_t size) {
  void *memory = malloc(size);
  if (memory == NULL)
    atomic_store(&memory_failed, true);
  return memory;
}

void json_watch_memory(void) {
  cJSON_Hooks hooks = {watched_malloc, free};
  cJSON_InitHooks(&hooks);
}

bool json_memory_failed(void) {
  return atomic_load(&memory_failed);
}

cJSON *json_number_item(double value) {
  char text[THRUM_NUMBER_TEXT];
  if (!isfinite(value))
    return cJSON_CreateNull();
  thrum_number_text(value, text);
  return cJSON_CreateRaw(text);
}

void json_number(cJSON *object, const char *key, double value) {
  cJSON_AddItemToObject(object, key, json_number_item(value));
}

double json_value(const cJSON *item) {
  if (cJSON_IsNumber(item))
    return item->valuedouble;
  return cJSON_IsRaw(item) ? strtod(item->valuestring, NULL) : NAN;
}

double json_number_of(const cJSON *object, const char *key) {
  return json_value(cJSON_GetObjectItemCaseSensitive(object, key));
}

const char *json_text_of(const cJSON *object, const char *key) {
  return cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(object, key));
}

void json_numbers(cJSON *object, const char *key, const double *values, int64_t count) {
  cJSON *array = cJSON_AddArrayToObject(object, key);
  for (int64_t n = 0; n < count; n++)
    cJSON_AddItemToArray(array, json_number_item(values[n]));
}

void json_string(cJSON *object, const char *key, const char *text) {
  cJSON_AddItemToObject(object, key, text != NULL ? cJSON_CreateString(text) : cJSON_CreateNull());
}

void json_add_string(cJSON *array, const char *text) {
  cJSON_AddItemToArray(array, cJSON_CreateString(text));
}

void json_strings(cJSON *object, const char *key, const char *const *texts, int64_t count) {
  cJSON *array = cJSON_AddArrayToObject(object, key);
  for (int64_t n = 0; n < count; n++)
    json_add_string(array, texts[n]);
}

cJSON *json_section(cJSON *object, const char *key, bool present) {
  if (present)
    return cJSON_AddObjectToObject(object, key);
  cJSON_AddNullToObject(object, key);
  return NULL;
}

cJSON *json_add_row(cJSON *array) {
  cJSON *row = cJSON_CreateObject();
  cJSON_AddItemToArray(array, row);
  return row;
}

void json_append(cJSON *to, cJSON *from) {
  while (from != NULL && from->child != NULL)
    cJSON_AddItemToArray(to, cJSON_DetachItemViaPointer(from, from->child));
}

/* JSON is UTF-8, so bytes that are none, of a file's name or a model's text, are replaced. */
static void clean(char *text) {
  size_t left = strlen(text);
  for (char *at = text; left > 0;) {
    const int length = thrum_utf8_length(at, left);
    if (length == 0)
      *at = '?';
    at += length == 0 ? 1 : length;
    left -= length == 0 ? 1 : (size_t)length;
  }
}

char *json_text(const cJSON *object) {
  // an object that was made without memory lacks some of its parts
  char *text = json_memory_failed() ? NULL : cJSON_PrintUnformatted(object);
  if (text != NULL)
    clean(text);
  return text;
}

/* Puts raw text in the place of each number of an array or object. */
static void restore_numbers(cJSON *parent) {
  for (cJSON *item = parent->child, *next = NULL; item != NULL; item = next) {
    next = item->next;
    if (!cJSON_IsNumber(item)) {
      restore_numbers(item);
      continue;
    }

    // a member of an object keeps its key
    cJSON *number = json_number_item(item->valuedouble);
    if (cJSON_IsObject(parent))
      cJSON_ReplaceItemInObjectCaseSensitive(parent, item->string, number);
    else
      cJSON_ReplaceItemViaPointer(parent, item, number);
  }
}

cJSON *json_read_back(const char *text, size_t length) {
  cJSON *object = cJSON_ParseWithLength(text, length);
  if (object != NULL)
    restore_numbers(object);
  if (!json_memory_failed())
    return object;
  cJSON_Delete(object);
  return NULL;
}

cJSON *json_report(const char *command, const char *status) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "program", "thrum");
  cJSON_AddStringToObject(object, "version", thrum_version());
  cJSON_AddStringToObject(object, "command", command);
  cJSON_AddStringToObject(object, "status", status);
  return object;
}

void json_print(cJSON *object) {
  char *text = json_text(object);
  if (text != NULL)
    puts(text);
  free(text);
  cJSON_Delete(object);
}

thrum_status json_file_read(const char *path, cJSON **object, thrum_error *error) {
  void *text = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_read(path, &text, &size, error));
  *object = cJSON_ParseWithLength(text, size);
  free(text);
  return THRUM_OK;
}
