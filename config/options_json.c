/* Reads options files and scene files by their tables.
 *
 * Each value becomes the text that would stand on the command line, so that both are checked by the
 * same code; here its JSON type is checked, and paths become relative to the file.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "config/message.h"
#include "config/options.h"
#include "config/parse.h"
#include "io/paths.h"
#include "io/text.h"

#define KEY_MAX 64
#define MESSAGE_MAX 400 /* as an error has room for */

/* One object that is being read. */
typedef struct reading {
  config_file *file;
  const config_record *record;
  config_row rows[CONFIG_OPTION_MAX];
  int row_count;
  const bool *overridden; /* NULL: none */
  const char *command;    /* NULL: a record */
  void *to;
  int64_t items; /* of repeated options, so far */
} reading;

/* --- files ------------------------------------------------------------------------------------ */

void config_file_free(config_file *file) {
  json_free(&file->document);
  for (int64_t n = 0; n < file->text_count; n++)
    free(file->texts[n]);
  free(file->texts);
  free(file->folder);
  *file = (config_file){0};
}

static thrum_status out_of_memory(config_file *file) {
  return thrum_error_set(file->error, THRUM_OUT_OF_MEMORY, "%.150s: out of memory", file->name);
}

thrum_status config_file_parse(const char *name, const char *bytes, size_t length,
                               config_file *file, thrum_error *error) {
  const size_t folder = (size_t)(path_basename(name) - name);
  *file = (config_file){.name = name, .error = error, .folder = malloc(folder + 1)};
  if (file->folder == NULL)
    return out_of_memory(file);
  memcpy(file->folder, name, folder);
  file->folder[folder] = 0;
  return json_read(name, bytes, length, &file->document, error);
}

thrum_status config_file_open(const char *path, const char *what, config_file *file,
                              thrum_error *error) {
  thrum_text text = {0};
  struct stat info;
  *file = (config_file){.name = path, .error = error};
  if (stat(path, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > JSON_BYTES_MAX)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%.200s: %lld bytes are no %s: %d at most",
                           path, (long long)info.st_size, what, JSON_BYTES_MAX);
  THRUM_TRY(thrum_text_open(path, 0, 0, &text, error));
  thrum_status status =
      config_file_parse(path, text.next, (size_t)(text.stop - text.next), file, error);
  thrum_text_close(&text);
  return status;
}

/* Joins two texts into one that the file owns; NULL: no memory. */
static const char *keep(config_file *file, const char *a, const char *b) {
  char **texts = realloc(file->texts, (size_t)(file->text_count + 1) * sizeof *texts);
  if (texts == NULL)
    return NULL;
  file->texts = texts;
  const size_t size = strlen(a) + strlen(b) + 1;
  char *text = malloc(size);
  if (text == NULL)
    return NULL;
  snprintf(text, size, "%s%s", a, b);
  return file->texts[file->text_count++] = text;
}

static bool is_there(const char *folder, const char *name, size_t length) {
  char path[4096];
  struct stat status;
  const int written = snprintf(path, sizeof path, "%s%.*s", folder, (int)length, name);
  return written > 0 && (size_t)written < sizeof path && stat(path, &status) == 0;
}

/* Does a text of a file in `folder` name a file there? */
static bool is_beside(const config_option *option, const char *folder, const char *text) {
  if (folder[0] == 0 || text[0] == '/' || text[0] == 0 || option->path == CONFIG_PATH_NONE)
    return false;
  if (option->path == CONFIG_PATH_ALWAYS)
    return true;
  if (option->path == CONFIG_PATH_NAMED)
    return option->is_name == NULL || !option->is_name(text);
  const char *colon = strrchr(text, ':');
  return is_there(folder, text, strlen(text)) ||
         (colon != NULL && colon > text && is_there(folder, text, (size_t)(colon - text)));
}

/* --- messages --------------------------------------------------------------------------------- */

/* Both spellings of a key, dry-run and dry_run, are one. */
static bool same_key(const char *a, const char *b) {
  for (; *a != 0 && (*a == '_' ? '-' : *a) == (*b == '_' ? '-' : *b); a++)
    b++;
  return *a == 0 && *b == 0;
}

const json_node *config_record_member(const config_file *file, const config_record *record,
                                      const char *key) {
  const json_node *nodes = file->document.nodes;
  if (record->node == NULL || record->node->type != JSON_OBJECT)
    return NULL;
  for (int64_t n = record->node->first; n >= 0; n = nodes[n].next)
    if (same_key(nodes[n].key, key))
      return &nodes[n];
  return NULL;
}

/* "FILE:LINE: PATH.KEY: MESSAGE" */
static thrum_status refuse_line(const config_file *file, int64_t line, const config_record *record,
                                const char *key, thrum_status status, char message[MESSAGE_MAX]) {
  const bool path = record->path[0] != 0;
  const char *option = strncmp(message, "--", 2) == 0 ? strchr(message, ' ') : NULL;
  if (option != NULL)
    memmove(message, option + 1, strlen(option + 1) + 1);
  if (file->words != NULL)
    file->words(message, MESSAGE_MAX);
  return thrum_error_set(file->error, status, "%.150s:%lld: %s%s%.60s%s%s", file->name,
                         (long long)line, record->path, path && key != NULL ? "." : "",
                         key != NULL ? key : "", path || key != NULL ? ": " : "", message);
}

thrum_status config_record_refuse(const config_file *file, const config_record *record,
                                  const char *key, thrum_status status, const char *format, ...) {
  char message[MESSAGE_MAX];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  const json_node *node = key != NULL ? config_record_member(file, record, key) : NULL;
  if (node == NULL)
    node = record->node != NULL ? record->node : &file->document.nodes[0];
  return refuse_line(file, node->line, record, key, status, message);
}

thrum_status config_record_refuse_text(const config_file *file, const config_record *record,
                                       const char *key, const config_texts *texts, int64_t index,
                                       const char *format, ...) {
  char message[MESSAGE_MAX], place[80];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  const json_node *member = config_record_member(file, record, key);
  if (member != NULL && member->type == JSON_ARRAY)
    snprintf(place, sizeof place, "%.40s[%lld]", key, (long long)index);
  else
    snprintf(place, sizeof place, "%.40s", key);
  return refuse_line(file, texts->nodes[index]->line, record, place, THRUM_INVALID_ARGUMENT,
                     message);
}

/* "; its keys: A, B, ..." as far as there is room. */
static void list_keys(const char *const *names, int64_t count, char *text, size_t size) {
  size_t used = (size_t)snprintf(text, size, "; its keys: ");
  for (int64_t n = 0; n < count; n++) {
    const bool last = n + 1 == count;
    if (used + strlen(names[n]) + sizeof ", ..." > size) {
      snprintf(text + used, size - used, "...");
      return;
    }
    used += (size_t)snprintf(text + used, size - used, "%s%s", names[n], last ? "" : ", ");
  }
}

/* The row that a key means; NULL, and a message with the nearest one, where there is none. */
static const config_row *find_row(const reading *r, const json_node *member) {
  char spelled[CONFIG_OPTION_MAX][KEY_MAX];
  const char *names[CONFIG_OPTION_MAX];
  int64_t count = 0;
  for (int n = 0; n < r->row_count; n++) {
    const config_option *option = r->rows[n].option;
    if (option->kind == CONFIG_FILE || option->helps)
      continue;
    if (same_key(option->name, member->key))
      return &r->rows[n];
    // names are suggested in the spelling that the key has
    snprintf(spelled[count], KEY_MAX, "%s", option->name);
    const bool dashes = r->command != NULL && strchr(member->key, '_') == NULL;
    for (char *c = spelled[count]; *c != 0; c++)
      *c = *c == '-' && !dashes ? '_' : *c == '_' && dashes ? '-' : *c;
    names[count] = spelled[count];
    count++;
  }

  const char *nearest = config_nearest(member->key, names, count);
  char hint[200];
  if (nearest != NULL)
    snprintf(hint, sizeof hint, "; did you mean \"%s\"?", nearest);
  else if (r->command != NULL)
    snprintf(hint, sizeof hint, " (try: thrum %s --help)", r->command);
  else
    list_keys(names, count, hint, sizeof hint);
  const config_record here = {.node = member};
  const char *in = r->record->path[0] != 0 ? r->record->path : "the file";
  config_record_refuse(r->file, &here, NULL, THRUM_BAD_VALUE, "%s has no key \"%s\"%s", in,
                       thrum_text_excerpt(thrum_word_of(member->key)).text, hint);
  return NULL;
}

/* --- values ----------------------------------------------------------------------------------- */

/* 30.0 and 3e1 are whole numbers in JSON. */
static const char *whole_text(config_file *file, const char *text) {
  double value = 0;
  char digits[32];
  if (!config_parse_number(text, &value) || value != floor(value) || fabs(value) > 9e15)
    return text;
  snprintf(digits, sizeof digits, "%.0f", value);
  return keep(file, digits, "");
}

/* [A, B] as "A,B"; NULL when it holds anything but numbers. */
static const char *numbers_text(config_file *file, const json_node *list) {
  const json_node *nodes = file->document.nodes;
  char text[512] = "";
  size_t used = 0;
  for (int64_t n = list->first; n >= 0 && used < sizeof text; n = nodes[n].next) {
    if (nodes[n].type != JSON_NUMBER)
      return NULL;
    used += (size_t)snprintf(text + used, sizeof text - used, "%s%s", used > 0 ? "," : "",
                             nodes[n].text);
  }
  return used > 0 && used < sizeof text ? keep(file, text, "") : NULL;
}

/* The text of a value of a type that the option takes; NULL: of another. */
static const char *value_text(config_file *file, const config_option *option,
                              const json_node *value) {
  const config_kind kind = option->kind;
  const bool takes_number =
      kind == CONFIG_NUMBER || kind == CONFIG_COUNT || kind == CONFIG_PAIR || kind == CONFIG_WORD;
  const bool takes_list = kind == CONFIG_VECTOR || kind == CONFIG_PAIR || option->schema != NULL;

  // the type of the value decides whether the option can take it
  switch (value->type) {
  case JSON_NUMBER:
    if (kind == CONFIG_COUNT)
      return whole_text(file, value->text);
    return takes_number ? value->text : NULL;
  case JSON_ARRAY:
    // one number of a pair stands without brackets
    if (kind == CONFIG_PAIR && value->first >= 0 && file->document.nodes[value->first].next < 0)
      return NULL;
    return takes_list ? numbers_text(file, value) : NULL;
  case JSON_TRUE:
    return kind == CONFIG_SWITCH ? "on" : NULL;
  case JSON_FALSE:
    return kind == CONFIG_SWITCH ? "off" : NULL;
  case JSON_STRING:
    if (kind != CONFIG_WORD && (takes_number || kind == CONFIG_VECTOR))
      return NULL;
    if (is_beside(option, file->folder, value->text))
      return keep(file, file->folder, value->text);
    return value->text;
  default:
    return NULL;
  }
}

static thrum_status read_object(reading *r, const config_option *keys, const json_node *node);

/* A record within a record, and its path. */
static thrum_status take_object(const config_given *given, const config_option *keys,
                                const json_node *node, int64_t index, void *item) {
  config_record *record = item;
  const char *outer = given->record->path;
  char number[24] = "";
  if (index >= 0)
    snprintf(number, sizeof number, "[%lld]", (long long)index);

  // the path names the record in every message about it
  record->node = node;
  const int length = snprintf(record->path, sizeof record->path, "%s%s%s%s", outer,
                              outer[0] != 0 ? "." : "", given->key, number);
  if (length < 0 || length >= (int)sizeof record->path)
    return config_given_refuse(given, "nested too deep");

  // its keys are read like those of the whole file
  if (node->type != JSON_OBJECT)
    return config_record_refuse(given->file, item, NULL, THRUM_BAD_VALUE,
                                "wants an object with its keys in { }");
  reading inner = {.file = given->file, .record = record, .to = item};
  return read_object(&inner, keys, node);
}

thrum_status config_object_read(const config_given *given, const config_option *keys, void *to) {
  return take_object(given, keys, given->node, -1, to);
}

static thrum_status take_list(const config_given *given, config_list *list) {
  const json_node *nodes = given->file->document.nodes;
  const config_option *option = given->option;
  int64_t count = 0;
  if (given->node->type != JSON_ARRAY)
    return config_given_wrong(given);
  for (int64_t n = given->node->first; n >= 0; n = nodes[n].next)
    count++;
  if (count > CONFIG_ITEMS_MAX)
    return config_given_refuse(given, "more than %d items", CONFIG_ITEMS_MAX);

  // items are read in their order, each over its defaults
  list->items = calloc((size_t)count + 1, option->item_size);
  if (list->items == NULL)
    return out_of_memory(given->file);
  for (int64_t n = given->node->first; n >= 0; n = nodes[n].next) {
    void *item = (char *)list->items + (size_t)list->count * option->item_size;
    if (option->begin != NULL)
      option->begin(item, given->record);
    THRUM_TRY(take_object(given, option->keys, &nodes[n], list->count++, item));
  }
  return THRUM_OK;
}

static thrum_status take_flag(const config_given *given, void *to) {
  const bool set = given->node->type == JSON_TRUE;
  if (!set && given->node->type != JSON_FALSE)
    return config_given_wrong(given);
  // false is as if it were not there, but for a record that may have it on
  if (!set && given->option->take == NULL)
    memset((char *)to + given->option->field, 0, given->option->size);
  return set ? config_given_apply(given, to) : THRUM_OK;
}

static thrum_status take_value(reading *r, config_given *given, const json_node *value, void *to) {
  const config_option *option = given->option;
  void *field = (char *)to + option->field;
  given->node = value;
  if (given->index >= 0)
    given->line = value->line;
  if (option->kind == CONFIG_FLAG)
    return take_flag(given, to);
  if (option->kind == CONFIG_OBJECT)
    return config_object_read(given, option->keys, field);
  if (option->kind == CONFIG_LIST)
    return take_list(given, field);

  // all else is read as the text of the command line; a row with a schema may read JSON itself
  given->text = value_text(r->file, option, value);
  const bool any = option->schema != NULL && option->kind == CONFIG_WORD;
  if (given->text == NULL && !any)
    return config_given_wrong(given);
  if (given->text != NULL && given->text[0] == 0 && r->command == NULL)
    return config_given_wrong(given);
  if (option->repeats && r->command != NULL && ++r->items > CONFIG_FILE_ITEMS_MAX)
    return config_given_refuse(given, "more than %d values in lists", CONFIG_FILE_ITEMS_MAX);
  return config_given_apply(given, to);
}

static thrum_status take_member(reading *r, const config_row *row, const json_node *member) {
  const json_node *nodes = r->file->document.nodes;
  const config_option *option = row->option;
  config_given given = {.option = option,
                        .file = r->file,
                        .key = member->key,
                        .line = member->line,
                        .index = -1,
                        .record = r->record,
                        .error = r->file->error};
  char *to = (char *)r->to + row->base;

  // the parser has seen keys that are the same, but not the two spellings of one
  const json_node *first = config_record_member(r->file, r->record, member->key);
  if (first != member)
    return config_given_refuse(&given, "it is there twice, in two spellings; first in line %lld",
                               (long long)first->line);
  if (r->overridden != NULL && r->overridden[row - r->rows])
    return THRUM_OK;
  const bool many = option->repeats || option->kind == CONFIG_TEXTS;
  if (!many || member->type != JSON_ARRAY)
    return take_value(r, &given, member, to);
  for (int64_t n = member->first; n >= 0; n = nodes[n].next) {
    given.index++;
    THRUM_TRY(take_value(r, &given, &nodes[n], to));
  }
  return THRUM_OK;
}

static thrum_status read_object(reading *r, const config_option *keys, const json_node *node) {
  const json_node *nodes = r->file->document.nodes;
  r->row_count = config_rows(keys, r->rows);

  // lists come last, since the defaults of their items are in the other members
  for (int lists = 0; lists < 2; lists++) {
    for (int64_t n = node->first; n >= 0; n = nodes[n].next) {
      if (strcmp(nodes[n].key, "$schema") == 0)
        continue; // for editors
      const config_row *row = find_row(r, &nodes[n]);
      if (row == NULL)
        return THRUM_BAD_VALUE;
      if ((row->option->kind == CONFIG_LIST) == (lists != 0))
        THRUM_TRY(take_member(r, row, &nodes[n]));
    }
  }

  // keys without a default must have been there
  for (int n = 0; n < r->row_count; n++) {
    const config_option *option = r->rows[n].option;
    if (option->needed && config_record_member(r->file, r->record, option->name) == NULL)
      return config_record_refuse(r->file, r->record, NULL, THRUM_MISSING,
                                  "the key \"%s\" is missing: %s", option->name, option->about);
  }
  return THRUM_OK;
}

thrum_status config_record_read(config_file *file, const config_option *keys, void *to) {
  config_record *record = to;
  record->node = &file->document.nodes[0];
  reading r = {.file = file, .record = record, .to = to};
  return read_object(&r, keys, record->node);
}

thrum_status config_file_apply(config_file *file, const config_command *command,
                               const bool *overridden, void *request) {
  const config_record record = {.node = &file->document.nodes[0]};
  reading r = {.file = file,
               .record = &record,
               .overridden = overridden,
               .command = command->name,
               .to = request};
  if (record.node->type != JSON_OBJECT)
    return config_record_refuse(file, &record, NULL, THRUM_BAD_FORMAT,
                                "options stand in { }, such as {\"rank\": 20}");
  return read_object(&r, command->options, record.node);
}

void config_record_free(const config_option *keys, void *record) {
  config_row rows[CONFIG_OPTION_MAX];
  const int count = config_rows(keys, rows);
  for (int n = 0; n < count; n++) {
    const config_option *option = rows[n].option;
    void *field = (char *)record + rows[n].base + option->field;

    // only texts and lists own memory; records are searched for both
    if (option->kind == CONFIG_TEXTS) {
      config_texts *texts = field;
      free(texts->texts);
      free(texts->nodes);
      *texts = (config_texts){0};
    } else if (option->kind == CONFIG_OBJECT) {
      config_record_free(option->keys, field);
    } else if (option->kind == CONFIG_LIST) {
      config_list *list = field;
      for (int64_t k = 0; k < list->count; k++)
        config_record_free(option->keys, (char *)list->items + (size_t)k * option->item_size);
      free(list->items);
      *list = (config_list){0};
    }
  }
}
