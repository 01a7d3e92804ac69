/* Reads the options of a command from argv by getopt_long. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdlib.h>

#include "config/message.h"
#include "config/options.h"

#define FIRST_LONG 256 /* what getopt_long returns for the first row, clear of all letters */

/* The options that were given, in their order. */
typedef struct given_list {
  config_row rows[CONFIG_OPTION_MAX];
  int row_count;
  config_given *items; /* room for argc */
  int *places;         /* of the rows of the items */
  int count;
  bool overridden[CONFIG_OPTION_MAX];
  int file;                  /* the item that is the options file; -1: none */
  const config_option *help; /* that was asked for; NULL: none */
} given_list;

/* The rows as getopt_long wants them: each long option returns FIRST_LONG plus its place. */
static void make_getopt(const given_list *list, struct option *longs, char *letters) {
  size_t used = 0;
  int count = 0;
  letters[used++] = ':';
  for (int place = 0; place < list->row_count; place++) {
    const config_option *option = list->rows[place].option;
    if (option->argument)
      continue;

    // a letter returns itself, so that both names lead to one row
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

  // both lists end with a zero
  longs[count] = (struct option){NULL, 0, NULL, 0};
  letters[used] = 0;
}

static int find_place(const given_list *list, int returned) {
  if (returned >= FIRST_LONG)
    return returned - FIRST_LONG;
  int place = 0;
  while (list->rows[place].option->letter != returned)
    place++;
  return place;
}

static int collect(const config_command *command, int argc, char **argv, given_list *list) {
  struct option longs[CONFIG_OPTION_MAX + 1];
  char letters[2 + 2 * CONFIG_OPTION_MAX];
  make_getopt(list, longs, letters);

  // each option is noted with its row, in the order of the command line
  opterr = 0;
  optind = 0; // from the start, whatever was read before
  for (int returned; (returned = getopt_long(argc, argv, letters, longs, NULL)) != -1;) {
    if (returned == '?' || returned == ':')
      return config_usage_option(command->name, argv, longs);
    const int place = find_place(list, returned);
    const config_option *option = list->rows[place].option;
    if (option->helps) {
      list->help = option;
      return COMMAND_DONE;
    }

    // only one options file is read, and the command line overrides its rows
    if (option->kind == CONFIG_FILE && list->file >= 0)
      return config_usage(command->name, "one --%s at a time", option->name);
    if (option->kind == CONFIG_FILE)
      list->file = list->count;
    list->overridden[place] = true;
    list->places[list->count] = place;
    list->items[list->count++] = (config_given){.option = option, .text = optarg, .index = -1};
  }

  // a mesh or a model on the command line stands for the file's, too
  for (int n = 0; n < list->row_count; n++)
    if (list->rows[n].option->argument && optind < argc)
      list->overridden[n] = true;
  return COMMAND_DONE;
}

static int read_file(const config_command *command, const given_list *list, void *request) {
  const config_given *given = &list->items[list->file];
  config_file *file = (config_file *)(void *)((char *)request + given->option->field);
  thrum_error error = {0};
  thrum_status status = config_file_open(given->text, "options file", file, &error);
  THRUM_THEN(status, config_file_apply(file, command, list->overridden, request));
  file->error = NULL;
  return status < 0 ? config_refuse(&error) : COMMAND_DONE;
}

static int apply(const config_command *command, const given_list *list, void *request) {
  CONFIG_TRY(list->file >= 0 ? read_file(command, list, request) : COMMAND_DONE);

  // options of the command line come after the file, and so over it
  for (int n = 0; n < list->count; n++) {
    thrum_error error = {0};
    config_given *given = &list->items[n];
    given->error = &error;
    if (n == list->file)
      continue;

    // a row of a group writes into its own struct within the request
    char *base = (char *)request + list->rows[list->places[n]].base;
    const thrum_status status = config_given_apply(given, base);
    if (status == THRUM_OUT_OF_MEMORY)
      return config_refuse(&error);
    if (status < 0)
      return config_usage(command->name, "%s", error.message);
  }
  return COMMAND_DONE;
}

int config_options_read(const config_command *command, int argc, char **argv, void *request) {
  given_list list = {.file = -1};
  list.row_count = config_rows(command->options, list.rows);
  list.items = calloc((size_t)argc + 1, sizeof *list.items);
  list.places = calloc((size_t)argc + 1, sizeof *list.places);

  // help comes before whatever else may be wrong
  const thrum_error memory = {.status = THRUM_OUT_OF_MEMORY};
  int code = list.items == NULL || list.places == NULL ? config_refuse(&memory)
                                                       : collect(command, argc, argv, &list);
  if (code == COMMAND_DONE && list.help != NULL) {
    config_print_help(command, list.help->letter == 0);
    code = COMMAND_HELPED;
  } else if (code == COMMAND_DONE) {
    code = apply(command, &list, request);
  }
  free(list.items);
  free(list.places);
  return code;
}

int config_options_read_one(const config_command *command, const char *what, int argc, char **argv,
                            void *request, const char **value) {
  CONFIG_TRY(config_options_read(command, argc, argv, request));
  if (optind >= argc)
    return *value != NULL ? COMMAND_DONE : config_usage(command->name, "no %s given", what);
  if (optind + 1 < argc)
    return config_usage(command->name, "one %s at a time, but '%s' follows '%s'", what,
                        argv[optind + 1], argv[optind]);
  *value = argv[optind];
  return COMMAND_DONE;
}
