/* `thrum schema`: the JSON schema of a command's options files, for editors and scripts.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/precompute_request.h"
#include "driver/scene_spec.h"
#include "driver/simulate_options.h"
#include "driver/static_report.h"

/* A further command with --options is one line here. */
static const struct {
  const char *name;
  const config_option *table;
} commands[] = {
    {"precompute", precompute_options_table},
    {"simulate", simulate_options_table},
    {"static", static_options_table},
};
enum { COMMAND_COUNT = sizeof commands / sizeof commands[0] };

static void print_help(void) {
  fputs("usage: thrum schema COMMAND\n\n"
        "Prints the JSON schema (draft 7) of the options files that COMMAND reads with --options:\n"
        "precompute, simulate or static; or scene, that of the scene files of simulate.\n\n"
        "  -h, --help   this text\n\n"
        "examples:\n"
        "  thrum schema simulate > simulate.schema.json\n"
        "  thrum schema scene > scene.schema.json\n",
        stdout);
}

static const config_option table[] = {CONFIG_OPTION_HELP(print_help), {.name = NULL}};

static int print(cJSON *schema) {
  char *text = cJSON_Print(schema);
  if (text != NULL)
    puts(text);
  cJSON_free(text);
  cJSON_Delete(schema);
  return COMMAND_DONE;
}

int cmd_schema(int argc, char **argv) {
  const char *name = NULL, *names[COMMAND_COUNT + 1];
  int code = config_options_read("schema", table, argc, argv, NULL);
  if (code == COMMAND_DONE)
    code = config_one_argument("schema", "command", argc, argv, &name);
  if (code != COMMAND_DONE)
    return code;

  // a scene, or the options file of a command
  if (strcmp(name, "scene") == 0)
    return print(config_record_schema("Scene of thrum simulate", scene_keys));
  for (int n = 0; n < COMMAND_COUNT; n++) {
    names[n] = commands[n].name;
    if (strcmp(name, names[n]) != 0)
      continue;
    return print(config_options_schema(name, commands[n].table));
  }

  names[COMMAND_COUNT] = "scene";
  const char *nearest = config_nearest(name, names, COMMAND_COUNT + 1);
  return config_usage("schema", "'%s' reads no options file; did you mean '%s'?", name,
                      nearest != NULL ? nearest : names[0]);
}
