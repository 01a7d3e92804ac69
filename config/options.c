/* Values of options, whether they come from the command line or from a file: each has the text that
 * would stand on the command line, and is checked and stored here.
 * SPDX-License-Identifier: Apache-2.0 */
#include "config/options.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "io/text.h"

#define LIST_TEXT_MAX 512
#define LIST_MAX 64

static int spread(const config_option *table, size_t base, config_row *rows, int count) {
  for (const config_option *o = table; o->about != NULL; o++)
    if (o->kind == CONFIG_GROUP)
      count = spread(o->keys, base + o->field, rows, count);
    else if (o->kind != CONFIG_HEADING && count < CONFIG_OPTION_MAX)
      rows[count++] = (config_row){o, base};
  return count;
}

int config_rows(const config_option *table, config_row rows[CONFIG_OPTION_MAX]) {
  return spread(table, 0, rows, 0);
}

/* --- messages --------------------------------------------------------------------------------- */

/* "imexv, newmark or energy" */
static void join_names(const char *const *names, char *text, size_t size) {
  size_t used = 0;
  text[0] = 0;
  for (int n = 0; names[n] != NULL && used < size; n++) {
    const char *between = n == 0 ? "" : names[n + 1] == NULL ? " or " : ", ";
    used += (size_t)snprintf(text + used, size - used, "%s%s", between, names[n]);
  }
}

/* "a number above 0 m", or what a list holds: "a list of three numbers above 0 m" */
static void number_wanted(const config_option *o, char *text, size_t size) {
  const char *what = o->kind == CONFIG_COUNT    ? "a whole number"
                     : o->kind == CONFIG_VECTOR ? "a list of three numbers"
                                                : "a number";
  const char *unit = o->unit != NULL ? o->unit : "", *blank = unit[0] != 0 ? " " : "";

  // a range is said as briefly as it can be
  if (o->least == 0 && o->most == 0)
    snprintf(text, size, "%s%s%s", what, unit[0] != 0 ? " of " : "", unit);
  else if (isinf(o->most))
    snprintf(text, size, "%s %s %.15g%s%s", what, o->above ? "above" : "of at least", o->least,
             blank, unit);
  else
    snprintf(text, size, "%s %s %.15g %s %.15g%s%s", what, o->above ? "above" : "from", o->least,
             o->below   ? "and below"
             : o->above ? "and up to"
                        : "to",
             o->most, blank, unit);
}

const char *config_wants(const config_option *option, char *text, size_t size) {
  static const char *const plain[] = {
      [CONFIG_FLAG] = "true or false",
      [CONFIG_SWITCH] = "on or off",
      [CONFIG_PAIR] = "a number or two, none negative",
      [CONFIG_WORD] = "a number or a text",
      [CONFIG_TEXT] = "a text",
      [CONFIG_TEXTS] = "a text, or a list of texts in [ ]",
      [CONFIG_OBJECT] = "an object with its keys in { }",
      [CONFIG_LIST] = "a list of objects in [ ]",
      [CONFIG_FILE] = "an options file",
  };

  // the row's own words come before those of its kind
  if (option->wants != NULL)
    snprintf(text, size, "%s", option->wants);
  else if (option->kind == CONFIG_CHOICE)
    join_names(option->names, text, size);
  else if (plain[option->kind] != NULL)
    snprintf(text, size, "%s", plain[option->kind]);
  else
    number_wanted(option, text, size);
  return text;
}

/* A line about an option of a file: "FILE:LINE: PATH.KEY: MESSAGE". */
static thrum_status refuse(const config_given *g, thrum_status status, char *message, size_t size) {
  char index[24] = "";
  config_one_line(message);
  if (g->file == NULL)
    return thrum_error_set(g->error, status, "%s", message);

  // a spec that says which option it is of says so once, as the key does here
  const char *option = strncmp(message, "--", 2) == 0 ? strchr(message, ' ') : NULL;
  if (option != NULL)
    memmove(message, option + 1, strlen(option + 1) + 1);
  if (g->file->words != NULL)
    g->file->words(message, size);
  if (g->index >= 0)
    snprintf(index, sizeof index, "[%lld]", (long long)g->index);
  const char *path = g->record != NULL ? g->record->path : "";
  return thrum_error_set(g->error, status, "%.150s:%lld: %s%s%.60s%s: %s", g->file->name,
                         (long long)g->line, path, path[0] != 0 ? "." : "", g->key, index, message);
}

thrum_status config_given_refuse(const config_given *given, const char *format, ...) {
  char line[400];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return refuse(given, THRUM_BAD_VALUE, line, sizeof line);
}

/* How a value of a file is written, for messages. A list of numbers has them as its text, with
 * commas between. */
static const char *found(const config_given *given, char *text, size_t size) {
  static const char *const words[] = {"null", "false", "true", "", "", "a list", "an object"};
  const json_node *node = given->node;
  const bool takes_list =
      given->option->kind == CONFIG_VECTOR || given->option->kind == CONFIG_PAIR;
  if (node->type == JSON_ARRAY && takes_list && given->text != NULL && given->text[0] != 0) {
    snprintf(text, size, "[%s]", thrum_text_excerpt(thrum_word_of(given->text)).text);
    return text;
  }
  if (node->type != JSON_NUMBER && node->type != JSON_STRING)
    return words[node->type];
  const char *quote = node->type == JSON_STRING ? "\"" : "";
  snprintf(text, size, "%s%s%s", quote, thrum_text_excerpt(thrum_word_of(node->text)).text, quote);
  return text;
}

/* Names the choice that was meant, where one is near. */
static void add_nearest(const config_given *given, char *line, size_t size) {
  int64_t count = 0;
  if (given->option->kind != CONFIG_CHOICE || given->text == NULL)
    return;
  while (given->option->names[count] != NULL)
    count++;
  const char *nearest = config_nearest(given->text, given->option->names, count);
  const size_t used = strlen(line);
  if (nearest != NULL)
    snprintf(line + used, size - used, "; did you mean '%s'?", nearest);
}

thrum_status config_given_wrong(const config_given *given) {
  char wants[300], text[120], line[480];
  config_wants(given->option, wants, sizeof wants);
  if (given->file != NULL && given->option->kind == CONFIG_SWITCH)
    snprintf(wants, sizeof wants, "true or false");
  if (given->file != NULL)
    snprintf(line, sizeof line, "wants %s, not %s", wants, found(given, text, sizeof text));
  else
    snprintf(line, sizeof line, "--%s wants %s, not '%.60s'", given->option->name, wants,
             given->text);
  add_nearest(given, line, sizeof line);
  return refuse(given, THRUM_BAD_VALUE, line, sizeof line);
}

/* --- values ----------------------------------------------------------------------------------- */

static bool in_range(const config_option *o, double value) {
  if (o->least == 0 && o->most == 0)
    return true;
  return (o->above ? value > o->least : value >= o->least) &&
         (o->below ? value < o->most : value <= o->most);
}

/* The text as a number in the row's range. */
static thrum_status given_number(const config_given *given, double *value) {
  double parsed = 0;
  if (!config_parse_number(given->text, &parsed) || !in_range(given->option, parsed))
    return config_given_wrong(given);
  *value = parsed;
  return THRUM_OK;
}

thrum_status config_given_count(const config_given *given, int64_t *value) {
  int64_t parsed = 0;
  if (!config_parse_integer(given->text, &parsed) || !in_range(given->option, (double)parsed))
    return config_given_wrong(given);
  *value = parsed;
  return THRUM_OK;
}

/* Cuts the text at its commas into `copy`, which the parts point into; -1 when a part is empty or
 * there are too many. */
static int64_t cut(const config_given *given, char copy[LIST_TEXT_MAX], const char **parts,
                   int64_t most) {
  int64_t count = 0;
  if (given->text == NULL || strlen(given->text) >= LIST_TEXT_MAX)
    return -1;
  memcpy(copy, given->text, strlen(given->text) + 1);
  for (char *at = copy; at != NULL; count++) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma = 0;
    if (at[0] == 0 || count == most)
      return -1;
    parts[count] = at;
    at = comma != NULL ? comma + 1 : NULL;
  }
  return count;
}

thrum_status config_given_numbers(const config_given *given, int64_t least, int64_t most,
                                  double *values, int64_t *count) {
  char copy[LIST_TEXT_MAX];
  const char *parts[LIST_MAX];
  double parsed[LIST_MAX];
  const int64_t found_count = cut(given, copy, parts, most < LIST_MAX ? most : LIST_MAX);
  if (found_count < least)
    return config_given_wrong(given);
  for (int64_t n = 0; n < found_count; n++)
    if (!config_parse_number(parts[n], &parsed[n]) || !in_range(given->option, parsed[n]))
      return config_given_wrong(given);

  // values keep their defaults until the whole list is known to be good
  memcpy(values, parsed, (size_t)found_count * sizeof *values);
  if (count != NULL)
    *count = found_count;
  return THRUM_OK;
}

thrum_status config_given_counts(const config_given *given, int64_t most, int64_t *values,
                                 int64_t *count) {
  double numbers[LIST_MAX];
  int64_t found_count = 0;
  const thrum_status status = config_given_numbers(given, 1, most, numbers, &found_count);
  for (int64_t n = 0; status >= 0 && n < found_count; n++) {
    if (numbers[n] != floor(numbers[n]) || fabs(numbers[n]) > 9e15)
      return config_given_wrong(given);
    values[n] = (int64_t)numbers[n];
  }
  if (status >= 0)
    *count = found_count;
  return status;
}

static int name_index(const char *text, const char *const *names, int count) {
  for (int n = 0; n < count && names[n] != NULL; n++)
    if (strcmp(text, names[n]) == 0)
      return n;
  return -1;
}

/* Marks the names of a list with commas between in `flags`, one for each known name. */
static thrum_status store_names(const config_given *given, bool *flags) {
  const char *const *known = given->option->names;
  const int count = (int)(given->option->size / sizeof *flags);
  char copy[LIST_TEXT_MAX];
  const char *parts[LIST_MAX];
  const int64_t found_count = cut(given, copy, parts, LIST_MAX);
  if (found_count < 0)
    return config_given_wrong(given);

  // the list takes the place of the default one
  memset(flags, 0, (size_t)count * sizeof *flags);
  for (int64_t n = 0; n < found_count; n++) {
    const int index = name_index(parts[n], known, count);
    if (index < 0)
      return config_given_refuse(given, "--%s: there is no '%s'", given->option->name, parts[n]);
    flags[index] = true;
  }
  return THRUM_OK;
}

/* Fields of one, four and eight bytes: bool, an enum or int32_t, int64_t. */
static void store(const config_option *option, void *field, int64_t value) {
  const bool truth = value != 0;
  const int32_t narrow = (int32_t)value;
  const void *from = &value;
  if (option->size == sizeof truth)
    from = &truth;
  else if (option->size == sizeof narrow)
    from = &narrow;
  memcpy(field, from, option->size);
}

static thrum_status out_of_memory(const config_given *given) {
  return thrum_error_set(given->error, THRUM_OUT_OF_MEMORY, "out of memory");
}

static thrum_status add_text(const config_given *given, config_texts *texts) {
  const size_t room = (size_t)texts->count + 1;
  const char **list = realloc(texts->texts, room * sizeof *list);
  if (list == NULL)
    return out_of_memory(given);
  texts->texts = list;
  const json_node **nodes = realloc(texts->nodes, room * sizeof *nodes);
  if (nodes == NULL)
    return out_of_memory(given);
  texts->nodes = nodes;
  texts->nodes[texts->count] = given->node;
  texts->texts[texts->count++] = given->text;
  return THRUM_OK;
}

static thrum_status store_number(const config_given *given, void *field) {
  const config_option *option = given->option;
  if (option->kind == CONFIG_VECTOR)
    return config_given_numbers(given, 3, 3, field, NULL);
  if (option->kind == CONFIG_NUMBER)
    return given_number(given, field);
  int64_t count = 0;
  THRUM_TRY(config_given_count(given, &count));
  store(option, field, count);
  return THRUM_OK;
}

/* The second of a pair is 0 when it is not given. */
static thrum_status store_pair(const config_given *given, double *field) {
  double pair[2] = {0, 0};
  THRUM_TRY(config_given_numbers(given, 1, 2, pair, NULL));
  memcpy(field, pair, sizeof pair);
  return THRUM_OK;
}

static thrum_status store_text(const config_given *given, void *field) {
  thrum_error detail = {0};
  if (given->option->check != NULL && given->option->check(given->text, &detail) < 0)
    return config_given_refuse(given, "%s", detail.message);
  if (given->option->kind == CONFIG_TEXTS)
    return add_text(given, field);
  *(const char **)field = given->text;
  return THRUM_OK;
}

thrum_status config_given_apply(const config_given *given, void *record) {
  static const char *const switches[] = {"off", "on", NULL};
  const config_option *option = given->option;
  void *field = (char *)record + option->field;
  if (option->given != 0)
    *(bool *)(void *)((char *)record + option->given) = true;

  // a row that knows better than its kind stores the value itself
  if (option->take != NULL)
    return option->take(given, record);
  switch (option->kind) {
  case CONFIG_FLAG:
    store(option, field, option->set != 0 ? option->set : 1);
    return THRUM_OK;
  case CONFIG_NUMBER:
  case CONFIG_COUNT:
  case CONFIG_VECTOR:
    return store_number(given, field);
  case CONFIG_SWITCH:
  case CONFIG_CHOICE: {
    const bool is_switch = option->kind == CONFIG_SWITCH;
    const int index = name_index(given->text, is_switch ? switches : option->names, 64);
    if (index < 0)
      return config_given_wrong(given);
    store(option, field, index);
    return THRUM_OK;
  }
  case CONFIG_PAIR:
    return store_pair(given, field);
  default:
    if (option->names != NULL)
      return store_names(given, field);
    if (option->counted != 0)
      return config_given_numbers(given, 1, (int64_t)(option->size / sizeof(double)), field,
                                  (int64_t *)(void *)((char *)record + option->counted));
    return store_text(given, field);
  }
}
