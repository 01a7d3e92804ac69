/* Options files: a JSON object whose keys are the long options of a command (docs/options.md).
 *
 * Each value becomes the text that would stand on the command line, so that both are read by the
 * same code; here, its JSON type is checked and paths become relative to the file.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "config/message.h"
#include "config/options.h"
#include "config/parse.h"
#include "driver/named_model.h"
#include "io/paths.h"
#include "io/text.h"

#define KEY_MAX 64

/* One file that is being applied. */
typedef struct application {
  const char *command;
  const config_option *table;
  const char *path;
  const bool *overridden;
  config_options_file *file;
  void *request;
  int64_t items; /* of repeated options, so far */
} application;

void config_options_file_free(config_options_file *file) {
  json_free(&file->document);
  for (int64_t n = 0; n < file->text_count; n++)
    free(file->texts[n]);
  free(file->texts);
  free(file->folder);
  *file = (config_options_file){0};
}

static int out_of_memory(void) {
  const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
  return config_refuse(&error);
}

/* A + B as a text that the file keeps; NULL: out of memory. */
static const char *keep(config_options_file *file, const char *a, const char *b) {
  char **texts = realloc(file->texts, (size_t)(file->text_count + 1) * sizeof *texts);
  if (texts == NULL)
    return NULL;
  file->texts = texts;
  const size_t length = strlen(a);
  char *text = malloc(length + strlen(b) + 1);
  if (text == NULL)
    return NULL;
  memcpy(text, a, length);
  memcpy(text + length, b, strlen(b) + 1);
  return file->texts[file->text_count++] = text;
}

/* Both spellings of a key, dry-run and dry_run, are one. */
static void spell(const char *key, char spelled[KEY_MAX]) {
  snprintf(spelled, KEY_MAX, "%s", key);
  for (char *c = spelled; *c != 0; c++)
    *c = *c == '_' ? '-' : *c;
}

static bool is_key(const config_option *option) {
  return option->kind != CONFIG_FILE && option->letter != 'h';
}

/* The option that a key means; a line and NULL when there is none. */
static const config_option *find_option(const application *a, const json_node *member) {
  char key[KEY_MAX];
  const char *names[CONFIG_OPTION_MAX];
  int64_t count = 0;
  spell(member->key, key);
  for (const config_option *option = a->table; option->name != NULL; option++) {
    if (!is_key(option))
      continue;
    if (strcmp(option->name, key) == 0)
      return option;
    if (count < CONFIG_OPTION_MAX)
      names[count++] = option->name;
  }
  const char *nearest = config_nearest(key, names, count);
  const thrum_excerpt shown = thrum_text_excerpt(member->key, strlen(member->key));
  fprintf(stderr, "thrum: %s:%lld: unknown key \"%s\"", a->path, (long long)member->line,
          shown.text);
  if (nearest != NULL)
    fprintf(stderr, ": did you mean \"%s\"?\n", nearest);
  else
    fprintf(stderr, " (try: thrum %s --help)\n", a->command);
  return NULL;
}

static bool is_there(const char *folder, const char *name, size_t length) {
  char path[4096];
  struct stat status;
  const int written = snprintf(path, sizeof path, "%s%.*s", folder, (int)length, name);
  return written > 0 && (size_t)written < sizeof path && stat(path, &status) == 0;
}

bool config_is_beside(config_path path, const char *folder, const char *text) {
  static const char *const kinds[] = {"beam:", "mode:", "static:", "sine:"};
  if (folder[0] == 0 || text[0] == '/' || text[0] == 0 || path == CONFIG_PATH_NONE)
    return false;
  if (path == CONFIG_PATH_ALWAYS)
    return true;
  if (path == CONFIG_PATH_NAMED) {
    for (int n = 0; n < CLI_MODEL_COUNT; n++) {
      if (strcmp(text, cli_model_names[n]) == 0)
        return false;
    }
    for (size_t n = 0; n < sizeof kinds / sizeof kinds[0]; n++) {
      if (strncmp(text, kinds[n], strlen(kinds[n])) == 0)
        return false;
    }
    return true;
  }
  const char *colon = strrchr(text, ':');
  return is_there(folder, text, strlen(text)) ||
         (colon != NULL && colon > text && is_there(folder, text, (size_t)(colon - text)));
}

/* 30.0 and 3e1 are whole numbers in JSON. */
static const char *whole_text(config_options_file *file, const char *text) {
  double value = 0;
  char digits[32];
  if (!config_parse_number(text, &value) || value != floor(value) || fabs(value) > 9e15)
    return text;
  snprintf(digits, sizeof digits, "%.0f", value);
  return keep(file, digits, "");
}

/* [A, B] as "A,B". */
static const char *pair_text(config_options_file *file, const json_node *first) {
  const json_node *nodes = file->document.nodes;
  const json_node *second = &nodes[first->next];
  const char *head = keep(file, first->text, ",");
  return head != NULL ? keep(file, head, second->text) : NULL;
}

static bool is_pair(const json_document *document, const json_node *value) {
  const json_node *nodes = document->nodes;
  if (value->type != JSON_ARRAY || value->first < 0 || nodes[value->first].next < 0)
    return false;
  const json_node *first = &nodes[value->first], *second = &nodes[first->next];
  return second->next < 0 && first->type == JSON_NUMBER && second->type == JSON_NUMBER;
}

static const char *type_wanted(const config_option *option) {
  switch (option->kind) {
  case CONFIG_FLAG:
    return "true or false";
  case CONFIG_NUMBER:
    return "a number without quotes";
  case CONFIG_COUNT:
    return "a whole number without quotes";
  case CONFIG_WORD:
    return "a number or a text";
  case CONFIG_PAIR:
    return "a number or two as in [0.1, 0.2]";
  default:
    return option->repeats                    ? "a text, or texts in [ ]"
           : option->names == config_switches ? "true or false"
                                              : "a text in quotes";
  }
}

/* The text of a value of the right type; NULL: of a wrong one. */
static const char *value_text(application *a, const config_option *option, const json_node *value) {
  const bool text = value->type == JSON_STRING, number = value->type == JSON_NUMBER;
  switch (option->kind) {
  case CONFIG_NUMBER:
    return number ? value->text : NULL;
  case CONFIG_COUNT:
    return number ? whole_text(a->file, value->text) : NULL;
  case CONFIG_WORD:
    return text || number ? value->text : NULL;
  case CONFIG_PAIR:
    if (is_pair(&a->file->document, value))
      return pair_text(a->file, &a->file->document.nodes[value->first]);
    return number ? value->text : NULL;
  case CONFIG_CHOICE:
    if (option->names == config_switches && value->type == JSON_TRUE)
      return "on";
    if (option->names == config_switches && value->type == JSON_FALSE)
      return "off";
    return text ? value->text : NULL;
  default:
    if (text && config_is_beside(option->path, a->file->folder, value->text))
      return keep(a->file, a->file->folder, value->text);
    return text ? value->text : NULL;
  }
}

static int apply_value(application *a, const config_option *option, const json_node *value) {
  config_given given = {a->command, option, NULL, a->path, value->line};
  if (option->kind == CONFIG_FLAG) {
    if (value->type != JSON_TRUE && value->type != JSON_FALSE)
      return config_given_wants(&given, type_wanted(option));
    return value->type == JSON_TRUE ? config_given_apply(&given, a->request) : COMMAND_DONE;
  }
  given.text = value_text(a, option, value);
  if (given.text == NULL)
    return config_given_wants(&given, type_wanted(option));
  if (option->repeats && ++a->items > CONFIG_FILE_ITEMS_MAX)
    return config_given_refuse(&given, "more than %d values in lists", CONFIG_FILE_ITEMS_MAX);
  return config_given_apply(&given, a->request);
}

static int apply_member(application *a, const json_node *member) {
  if (strcmp(member->key, "$schema") == 0)
    return COMMAND_DONE; // for editors
  const config_option *option = find_option(a, member);
  if (option == NULL)
    return COMMAND_REFUSED;
  // the two spellings of a key
  const json_node *nodes = a->file->document.nodes;
  for (const json_node *other = &nodes[nodes[0].first]; other != member;
       other = &nodes[other->next]) {
    char key[KEY_MAX];
    spell(other->key, key);
    if (strcmp(key, option->name) != 0)
      continue;
    const config_given given = {a->command, option, NULL, a->path, member->line};
    return config_given_refuse(&given, "it is there twice, in two spellings; first in line %lld",
                               (long long)other->line);
  }
  if (a->overridden[option - a->table])
    return COMMAND_DONE;
  if (!option->repeats || member->type != JSON_ARRAY)
    return apply_value(a, option, member);
  for (int64_t n = member->first; n >= 0; n = nodes[n].next) {
    const int code = apply_value(a, option, &nodes[n]);
    if (code != COMMAND_DONE)
      return code;
  }
  return COMMAND_DONE;
}

/* Reads the file into a->file: its values, and the folder it lies in. */
static int read_file(application *a) {
  thrum_error error = {0};
  thrum_text text = {0};
  struct stat status;
  if (stat(a->path, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > JSON_BYTES_MAX) {
    thrum_error_set(&error, THRUM_BAD_FORMAT, "%.200s: %lld bytes are no options file: %d at most",
                    a->path, (long long)status.st_size, JSON_BYTES_MAX);
    return config_refuse(&error);
  }
  if (thrum_text_open(a->path, 0, 0, &text, &error) < 0)
    return config_refuse(&error);
  const thrum_status read =
      json_read(a->path, text.next, (size_t)(text.stop - text.next), &a->file->document, &error);
  thrum_text_close(&text);
  if (read < 0)
    return config_refuse(&error);
  const size_t length = (size_t)(path_basename(a->path) - a->path);
  a->file->folder = malloc(length + 1);
  if (a->file->folder == NULL)
    return out_of_memory();
  memcpy(a->file->folder, a->path, length);
  a->file->folder[length] = 0;
  return COMMAND_DONE;
}

int config_options_file_apply(const char *command, const config_option *table, const char *path,
                              const bool *overridden, config_options_file *file, void *request) {
  application a = {command, table, path, overridden, file, request, 0};
  int code = read_file(&a);
  if (code != COMMAND_DONE)
    return code;
  const json_node *nodes = file->document.nodes;
  if (nodes[0].type != JSON_OBJECT) {
    fprintf(stderr, "thrum: %s:%lld: options stand in { }, such as {\"rank\": 20}\n", path,
            (long long)nodes[0].line);
    return COMMAND_REFUSED;
  }
  for (int64_t n = nodes[0].first; n >= 0 && code == COMMAND_DONE; n = nodes[n].next)
    code = apply_member(&a, &nodes[n]);
  return code;
}
