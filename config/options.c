/* Options of the subcommands, read by their tables. SPDX-License-Identifier: Apache-2.0 */
#include "config/options.h"

#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"

#define FIRST_LONG 256 /* what getopt_long returns for table[0], clear of all letters */
#define COUNTS_TEXT_MAX 256

const char *const config_switches[] = {"off", "on", NULL};

int config_name_index(const char *text, const char *const *names) {
  for (int n = 0; names[n] != NULL; n++) {
    if (strcmp(text, names[n]) == 0)
      return n;
  }
  return -1;
}

/* A line of an options file, or of the command line. */
static int refuse_line(const config_given *given, const char *between, char *line) {
  config_one_line(line);
  if (given->file == NULL)
    return config_usage(given->command, "%s", line);
  fprintf(stderr, "thrum: %s:%lld: \"%s\"%s%s\n", given->file, (long long)given->line,
          given->option->name, between, line);
  return COMMAND_REFUSED;
}

int config_given_refuse(const config_given *given, const char *format, ...) {
  char line[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  return refuse_line(given, ": ", line);
}

int config_given_wants(const config_given *given, const char *wants) {
  char line[1200];
  const bool typed = given->file == NULL;
  snprintf(line, sizeof line, "%s%s%swants %s", typed ? "--" : "", typed ? given->option->name : "",
           typed ? " " : "", wants);
  return refuse_line(given, " ", line);
}

/* "imexv, newmark or energy" */
static void join_names(const char *const *names, char *text, size_t size) {
  size_t used = 0;
  text[0] = 0;
  for (int n = 0; names[n] != NULL && used < size; n++) {
    const char *between = n == 0 ? "" : names[n + 1] == NULL ? " or " : ", ";
    used += (size_t)snprintf(text + used, size - used, "%s%s", between, names[n]);
  }
}

int config_given_wrong(const config_given *given) {
  const config_option *option = given->option;
  char wants[1024];
  if (option->wants != NULL)
    snprintf(wants, sizeof wants, "%s", option->wants);
  else if (option->kind == CONFIG_CHOICE)
    join_names(option->names, wants, sizeof wants);
  else if (option->kind == CONFIG_COUNT)
    snprintf(wants, sizeof wants, "a whole number from %.15g to %.15g", option->least,
             option->most);
  else
    snprintf(wants, sizeof wants, "%s",
             option->above && option->least == 0 ? "a number above 0" : "a number");
  const size_t used = strlen(wants);
  snprintf(wants + used, sizeof wants - used, ", not '%.200s'", given->text);
  return config_given_wants(given, wants);
}

static bool in_range(const config_option *option, double value) {
  if (option->least == 0 && option->most == 0)
    return true;
  return (option->above ? value > option->least : value >= option->least) &&
         (option->below ? value < option->most : value <= option->most);
}

int config_given_number(const config_given *given, double *value) {
  double parsed = 0;
  if (!config_parse_number(given->text, &parsed) || !in_range(given->option, parsed))
    return config_given_wrong(given);
  *value = parsed;
  return COMMAND_DONE;
}

int config_given_count(const config_given *given, int64_t *value) {
  int64_t parsed = 0;
  if (!config_parse_integer(given->text, &parsed) || !in_range(given->option, (double)parsed))
    return config_given_wrong(given);
  *value = parsed;
  return COMMAND_DONE;
}

int config_given_pair(const config_given *given, double pair[2]) {
  char first[64];
  double parsed[2] = {pair[0], pair[1]};
  const size_t length = strcspn(given->text, ",");
  if (length >= sizeof first)
    return config_given_wrong(given);
  memcpy(first, given->text, length);
  first[length] = 0;
  const bool both = given->text[length] == ',';
  if (!config_parse_number(first, &parsed[0]) ||
      (both && !config_parse_number(given->text + length + 1, &parsed[1])) || !(parsed[0] >= 0) ||
      !(parsed[1] >= 0))
    return config_given_wrong(given);
  memcpy(pair, parsed, sizeof parsed);
  return COMMAND_DONE;
}

int config_given_counts(const config_given *given, int64_t most, int64_t *values, int64_t *count) {
  char copy[COUNTS_TEXT_MAX];
  int64_t found = 0;
  if (strlen(given->text) >= sizeof copy)
    return config_given_wrong(given);
  memcpy(copy, given->text, strlen(given->text) + 1);
  for (char *at = copy; at != NULL;) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma++ = 0;
    int64_t value = 0;
    if (found == most || !config_parse_integer(at, &value) ||
        !in_range(given->option, (double)value))
      return config_given_wrong(given);
    values[found++] = value;
    at = comma;
  }
  *count = found;
  return COMMAND_DONE;
}

int config_given_apply(const config_given *given, void *request) {
  const config_option *option = given->option;
  char *field = (char *)request + option->field;
  if (option->help != NULL) {
    option->help();
    return COMMAND_HELPED;
  }
  if (option->take != NULL)
    return option->take(given, request);
  switch (option->kind) {
  case CONFIG_FLAG:
    *(bool *)(void *)field = true;
    return COMMAND_DONE;
  case CONFIG_NUMBER:
    return config_given_number(given, (double *)(void *)field);
  case CONFIG_COUNT:
    return config_given_count(given, (int64_t *)(void *)field);
  case CONFIG_CHOICE: {
    const int index = config_name_index(given->text, option->names);
    if (index < 0)
      return config_given_wrong(given);
    option->choose(request, index);
    return COMMAND_DONE;
  }
  default:
    *(const char **)(void *)field = given->text;
    return COMMAND_DONE;
  }
}

/* The table as getopt_long wants it: each long option returns FIRST_LONG plus its place. */
static void make_getopt(const config_option *table, struct option *longs, char *letters) {
  size_t used = 0;
  int count = 0;
  letters[used++] = ':';
  int place = 0;
  for (; table[place].name != NULL && place < CONFIG_OPTION_MAX; place++) {
    const config_option *option = &table[place];
    if (option->argument)
      continue;
    const bool has_value = option->kind != CONFIG_FLAG;
    longs[count++] =
        (struct option){option->name, has_value ? required_argument : no_argument, NULL,
                        option->letter != 0 ? option->letter : FIRST_LONG + place};
    if (option->letter == 0)
      continue;
    letters[used++] = (char)option->letter;
    if (has_value)
      letters[used++] = ':';
  }
  longs[count] = (struct option){NULL, 0, NULL, 0};
  letters[used] = 0;
}

static const config_option *find_returned(const config_option *table, int returned) {
  if (returned >= FIRST_LONG)
    return &table[returned - FIRST_LONG];
  while (table->letter != returned)
    table++;
  return table;
}

/* What was given, in its order. */
typedef struct given_list {
  config_given *items; /* room for argc */
  int count;
  bool overridden[CONFIG_OPTION_MAX];
  const config_given *file; /* the options file */
  const config_given *help;
} given_list;

static int collect(const char *command, const config_option *table, int argc, char **argv,
                   given_list *list) {
  struct option longs[CONFIG_OPTION_MAX + 1];
  char letters[2 + 2 * CONFIG_OPTION_MAX];
  make_getopt(table, longs, letters);
  opterr = 0;
  optind = 0; // from the start, whatever was read before
  for (int returned; (returned = getopt_long(argc, argv, letters, longs, NULL)) != -1;) {
    if (returned == '?' || returned == ':')
      return config_usage_option(command, argv, longs);
    config_given *given = &list->items[list->count++];
    *given = (config_given){
        .command = command, .option = find_returned(table, returned), .text = optarg};
    list->overridden[given->option - table] = true;
    if (returned == 'h')
      list->help = given;
    if (list->help != NULL)
      break;
    if (given->option->kind == CONFIG_FILE && list->file != NULL)
      return config_usage(command, "one --%s at a time", given->option->name);
    if (given->option->kind == CONFIG_FILE)
      list->file = given;
  }
  // a mesh or a model on the command line stands for the file's, too
  for (int n = 0; table[n].name != NULL; n++)
    list->overridden[n] = list->overridden[n] || (table[n].argument && optind < argc);
  return COMMAND_DONE;
}

int config_options_read(const char *command, const config_option *table, int argc, char **argv,
                        void *request) {
  given_list list = {.items = calloc((size_t)argc + 1, sizeof *list.items)};
  if (list.items == NULL) {
    const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
    return config_refuse(&error);
  }
  int code = collect(command, table, argc, argv, &list);
  if (code == COMMAND_DONE && list.help != NULL) {
    code = config_given_apply(list.help, request);
  } else {
    if (code == COMMAND_DONE && list.file != NULL)
      code = config_options_file_apply(
          command, table, list.file->text, list.overridden,
          (config_options_file *)(void *)((char *)request + list.file->option->field), request);
    for (int n = 0; n < list.count && code == COMMAND_DONE; n++) {
      if (list.items[n].option->kind != CONFIG_FILE)
        code = config_given_apply(&list.items[n], request);
    }
  }
  free(list.items);
  return code;
}

int config_one_argument(const char *command, const char *what, int argc, char **argv,
                        const char **value) {
  if (optind >= argc)
    return *value != NULL ? COMMAND_DONE : config_usage(command, "no %s given", what);
  if (optind + 1 < argc)
    return config_usage(command, "one %s at a time, but '%s' follows '%s'", what, argv[optind + 1],
                        argv[optind]);
  *value = argv[optind];
  return COMMAND_DONE;
}
