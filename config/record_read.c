/* Reads records by their tables. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "config/record.h"
#include "io/text.h"
#include "thrum/thrum.h"

#define KEYS_MAX 64 /* of one table */

const json_node *config_record_member(const config_record_file *file, const config_record *record,
                                      const char *key) {
  const json_node *nodes = file->document.nodes;
  if (record->node == NULL || record->node->type != JSON_OBJECT)
    return NULL;
  for (int64_t n = record->node->first; n >= 0; n = nodes[n].next)
    if (strcmp(nodes[n].key, key) == 0)
      return &nodes[n];
  return NULL;
}

/* "FILE:LINE: PATH.KEY: MESSAGE" */
static thrum_status refuse_line(const config_record_file *file, int64_t line,
                                const config_record *record, const char *key, thrum_status status,
                                const char *message) {
  const bool path = record->path[0] != 0;
  // what is said of an option names it, which the key does here
  const char *option = strncmp(message, "--", 2) == 0 ? strchr(message, ' ') : NULL;
  if (option != NULL)
    message = option + 1;
  return thrum_error_set(file->error, status, "%.150s:%lld: %s%s%.60s%s%s", file->name,
                         (long long)line, record->path, path && key != NULL ? "." : "",
                         key != NULL ? key : "", path || key != NULL ? ": " : "", message);
}

thrum_status config_record_refuse(const config_record_file *file, const config_record *record,
                                  const char *key, thrum_status status, const char *format, ...) {
  char message[300];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  const json_node *node = key != NULL ? config_record_member(file, record, key) : NULL;
  if (node == NULL)
    node = record->node != NULL ? record->node : &file->document.nodes[0];
  return refuse_line(file, node->line, record, key, status, message);
}

/* --- values ------------------------------------------------------------------------------------
 */

static bool in_range(const config_key *key, double value) {
  if (key->least == 0 && key->most == 0)
    return true;
  return (key->above ? value > key->least : value >= key->least) &&
         (key->below ? value < key->most : value <= key->most);
}

/* "a number above 0 m", or what a list holds: "a list of three numbers above 0 m" */
static const char *wanted_number(const config_key *key, char *text, size_t size) {
  const char *what = key->kind == CONFIG_KEY_COUNT    ? "a whole number"
                     : key->kind == CONFIG_KEY_VECTOR ? "a list of three numbers"
                                                      : "a number";
  const char *unit = key->unit != NULL ? key->unit : "";
  const char *blank = unit[0] != 0 ? " " : "";
  if (key->least == 0 && key->most == 0)
    snprintf(text, size, "%s%s%s", what, blank, unit);
  else if (isinf(key->most))
    snprintf(text, size, "%s %s %g%s%s", what, key->above ? "above" : "of at least", key->least,
             blank, unit);
  else
    snprintf(text, size, "%s %s %g %s %g%s%s", what, key->above ? "above" : "from", key->least,
             key->below ? "and below" : "to", key->most, blank, unit);
  return text;
}

/* What a value is, for messages. */
static const char *found(const json_node *value, char *text, size_t size) {
  static const char *const words[] = {"null", "false", "true", "", "", "a list", "an object"};
  if (value->type == JSON_NUMBER || value->type == JSON_STRING) {
    const char *quote = value->type == JSON_STRING ? "\"" : "";
    snprintf(text, size, "%s%s%s", quote, thrum_text_excerpt(value->text, strlen(value->text)).text,
             quote);
    return text;
  }
  return words[value->type];
}

thrum_status config_record_refuse_text(const config_record_file *file, const config_record *record,
                                       const char *key, const config_texts *texts, int64_t index,
                                       const char *format, ...) {
  char message[300], place[80];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  const json_node *member = config_record_member(file, record, key);
  const bool list = member != NULL && member->type == JSON_ARRAY;
  if (list)
    snprintf(place, sizeof place, "%.40s[%lld]", key, (long long)index);
  else
    snprintf(place, sizeof place, "%.40s", key);
  return refuse_line(file, texts->nodes[index]->line, record, place, THRUM_INVALID_ARGUMENT,
                     message);
}

thrum_status config_record_wrong(const config_record_file *file, const config_record *record,
                                 const config_key *key, const json_node *value, const char *wants) {
  char text[120], message[300];
  snprintf(message, sizeof message, "wants %s, not %s", wants, found(value, text, sizeof text));
  return refuse_line(file, value->line, record, key->name, THRUM_BAD_VALUE, message);
}

static bool read_number(const json_node *value, double *number) {
  return value->type == JSON_NUMBER && config_parse_number(value->text, number);
}

bool config_record_numbers(const config_record_file *file, const json_node *value, int64_t count,
                           double *numbers) {
  if (value->type != JSON_ARRAY)
    return false;
  int64_t found_count = 0;
  for (int64_t n = value->first; n >= 0; n = file->document.nodes[n].next) {
    if (found_count == count || !read_number(&file->document.nodes[n], &numbers[found_count++]))
      return false;
  }
  return found_count == count;
}

static thrum_status take_number(const config_record_file *file, const config_record *record,
                                const config_key *key, const json_node *value, void *field) {
  double number = 0;
  char wants[120];
  const bool whole = key->kind == CONFIG_KEY_COUNT;
  if (!read_number(value, &number) || !in_range(key, number) ||
      (whole && (number != floor(number) || fabs(number) > 9e15)))
    return config_record_wrong(file, record, key, value, wanted_number(key, wants, sizeof wants));
  if (whole)
    *(int64_t *)field = (int64_t)number;
  else
    *(double *)field = number;
  return THRUM_OK;
}

static thrum_status take_vector(const config_record_file *file, const config_record *record,
                                const config_key *key, const json_node *value, void *field) {
  double numbers[3];
  char wants[120];
  bool good = config_record_numbers(file, value, 3, numbers);
  for (int axis = 0; axis < 3 && good; axis++)
    good = in_range(key, numbers[axis]);
  if (!good)
    return config_record_wrong(file, record, key, value, wanted_number(key, wants, sizeof wants));
  memcpy(field, numbers, sizeof numbers);
  return THRUM_OK;
}

static thrum_status take_texts(const config_record_file *file, const config_record *record,
                               const config_key *key, const json_node *value, config_texts *texts) {
  const json_node *nodes = file->document.nodes;
  const bool list = value->type == JSON_ARRAY;
  int64_t count = list ? 0 : 1;
  for (int64_t n = list ? value->first : -1; n >= 0; n = nodes[n].next)
    count++;
  texts->texts = calloc((size_t)count + 1, sizeof *texts->texts);
  texts->nodes = calloc((size_t)count + 1, sizeof *texts->nodes);
  if (texts->texts == NULL || texts->nodes == NULL)
    return thrum_error_set(file->error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory", file->name);
  int64_t next = list ? value->first : value - nodes;
  for (int64_t k = 0; k < count; k++, next = nodes[next].next) {
    if (nodes[next].type != JSON_STRING || nodes[next].text[0] == 0)
      return config_record_wrong(file, record, key, &nodes[next], "a text, or a list of texts");
    texts->nodes[texts->count] = &nodes[next];
    texts->texts[texts->count++] = nodes[next].text;
  }
  return THRUM_OK;
}

static thrum_status take_choice(const config_record_file *file, const config_record *record,
                                const config_key *key, const json_node *value, void *to) {
  char list[200] = "";
  for (int n = 0; key->names[n] != NULL; n++) {
    if (value->type == JSON_STRING && strcmp(value->text, key->names[n]) == 0) {
      key->choose(to, n);
      return THRUM_OK;
    }
    const size_t used = strlen(list);
    const char *join = n == 0 ? "" : key->names[n + 1] == NULL ? " or " : ", ";
    snprintf(list + used, sizeof list - used, "%s\"%s\"", join, key->names[n]);
  }
  return config_record_wrong(file, record, key, value, list);
}

/* --- records -----------------------------------------------------------------------------------
 */

static thrum_status begin_record(const config_record_file *file, const config_record *outer,
                                 const config_key *key, int64_t index, const json_node *node,
                                 config_record *record) {
  const char *dot = outer->path[0] != 0 ? "." : "";
  char number[24] = "";
  if (index >= 0)
    snprintf(number, sizeof number, "[%lld]", (long long)index);
  record->node = node;
  const int length =
      snprintf(record->path, sizeof record->path, "%s%s%s%s", outer->path, dot, key->name, number);
  if (length < 0 || length >= (int)sizeof record->path)
    return config_record_refuse(file, outer, key->name, THRUM_BAD_FORMAT, "nested too deep");
  return THRUM_OK;
}

static thrum_status take_object(const config_record_file *file, const config_record *outer,
                                const config_key *key, int64_t index, const json_node *value,
                                void *item) {
  thrum_status status = begin_record(file, outer, key, index, value, item);
  if (status >= 0 && value->type != JSON_OBJECT)
    status = config_record_refuse(file, item, NULL, THRUM_BAD_VALUE,
                                  "wants an object with its keys in { }");
  return status >= 0 ? config_record_read(file, key->keys, value, item) : status;
}

static thrum_status take_list(const config_record_file *file, const config_record *record,
                              const config_key *key, const json_node *value, config_list *list) {
  const json_node *nodes = file->document.nodes;
  int64_t count = 0;
  if (value->type != JSON_ARRAY)
    return config_record_wrong(file, record, key, value, "a list of objects in [ ]");
  for (int64_t n = value->first; n >= 0; n = nodes[n].next)
    count++;
  if (count > CONFIG_RECORD_ITEMS_MAX)
    return config_record_refuse(file, record, key->name, THRUM_BAD_VALUE, "more than %d items",
                                CONFIG_RECORD_ITEMS_MAX);
  list->items = calloc((size_t)count + 1, key->size);
  if (list->items == NULL)
    return thrum_error_set(file->error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory", file->name);
  thrum_status status = THRUM_OK;
  for (int64_t n = value->first; n >= 0 && status >= 0; n = nodes[n].next) {
    void *item = (char *)list->items + (size_t)list->count * key->size;
    if (key->begin != NULL)
      key->begin(item, record);
    status = take_object(file, record, key, list->count++, &nodes[n], item);
  }
  return status;
}

static thrum_status take_value(const config_record_file *file, const config_key *key,
                               const json_node *value, void *to) {
  const config_record *record = to;
  void *field = (char *)to + key->field;
  switch (key->kind) {
  case CONFIG_KEY_BOOL:
    if (value->type != JSON_TRUE && value->type != JSON_FALSE)
      return config_record_wrong(file, record, key, value, "true or false");
    *(bool *)field = value->type == JSON_TRUE;
    return THRUM_OK;
  case CONFIG_KEY_NUMBER:
  case CONFIG_KEY_COUNT:
    return take_number(file, record, key, value, field);
  case CONFIG_KEY_VECTOR:
    return take_vector(file, record, key, value, field);
  case CONFIG_KEY_TEXT:
    if (value->type != JSON_STRING || value->text[0] == 0)
      return config_record_wrong(file, record, key, value, "a text in double quotes");
    *(const char **)field = value->text;
    return THRUM_OK;
  case CONFIG_KEY_TEXTS:
    return take_texts(file, record, key, value, field);
  case CONFIG_KEY_CHOICE:
    return take_choice(file, record, key, value, to);
  case CONFIG_KEY_OBJECT:
    return take_object(file, record, key, -1, value, field);
  case CONFIG_KEY_LIST:
    return take_list(file, record, key, value, field);
  case CONFIG_KEY_OWN:
    break;
  }
  return key->take(file, record, key, value, to);
}

/* The key of a member, or a message with the nearest one. */
static const config_key *find_key(const config_record_file *file, const config_record *record,
                                  const config_key *keys, const json_node *member) {
  const char *names[KEYS_MAX];
  int64_t count = 0;
  for (const config_key *key = keys; key->name != NULL && count < KEYS_MAX; key++) {
    if (strcmp(key->name, member->key) == 0)
      return key;
    names[count++] = key->name;
  }
  const char *nearest = config_nearest(member->key, names, count);
  const thrum_excerpt excerpt = thrum_text_excerpt(member->key, strlen(member->key));
  const config_record here = {.node = member};
  const char *in = record->path[0] != 0 ? record->path : "the file";
  if (nearest != NULL)
    config_record_refuse(file, &here, NULL, THRUM_BAD_VALUE,
                         "%s has no key \"%s\"; did you mean \"%s\"?", in, excerpt.text, nearest);
  else
    config_record_refuse(file, &here, NULL, THRUM_BAD_VALUE,
                         "%s has no key \"%s\"; its first is \"%s\"", in, excerpt.text, names[0]);
  return NULL;
}

/* The members that are lists, or those that are not: lists come last, for their defaults. */
static thrum_status read_members(const config_record_file *file, const config_key *keys, bool lists,
                                 void *to) {
  const config_record *record = to;
  const json_node *nodes = file->document.nodes;
  for (int64_t n = record->node->first; n >= 0; n = nodes[n].next) {
    if (strcmp(nodes[n].key, "$schema") == 0)
      continue; // for editors
    const config_key *key = find_key(file, record, keys, &nodes[n]);
    if (key == NULL)
      return THRUM_BAD_VALUE;
    if ((key->kind == CONFIG_KEY_LIST) != lists)
      continue;
    const thrum_status status = take_value(file, key, &nodes[n], to);
    if (status < 0)
      return status;
  }
  return THRUM_OK;
}

thrum_status config_record_read(const config_record_file *file, const config_key *keys,
                                const json_node *node, void *to) {
  config_record *record = to;
  record->node = node;
  thrum_status status = read_members(file, keys, false, to);
  if (status >= 0)
    status = read_members(file, keys, true, to);
  for (const config_key *key = keys; status >= 0 && key->name != NULL; key++)
    if (key->needed && config_record_member(file, record, key->name) == NULL)
      status = config_record_refuse(file, record, NULL, THRUM_MISSING,
                                    "the key \"%s\" is missing: %s", key->name, key->about);
  return status;
}

void config_record_free(const config_key *keys, void *record) {
  for (const config_key *key = keys; key->name != NULL; key++) {
    void *field = (char *)record + key->field;
    if (key->kind == CONFIG_KEY_TEXTS) {
      config_texts *texts = field;
      free(texts->texts);
      free(texts->nodes);
      *texts = (config_texts){0};
    } else if (key->kind == CONFIG_KEY_OBJECT) {
      config_record_free(key->keys, field);
    } else if (key->kind == CONFIG_KEY_LIST) {
      config_list *list = field;
      for (int64_t n = 0; n < list->count; n++)
        config_record_free(key->keys, (char *)list->items + (size_t)n * key->size);
      free(list->items);
      *list = (config_list){0};
    }
  }
}
