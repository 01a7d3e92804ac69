/* `thrum schema`: the JSON schema of a command's options files, for editors and scripts.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "app/cmd.h"
#include "app/commands.h"
#include "config/message.h"
#include "driver/scene/scene_spec.h"

#define COMMANDS_MAX 32

static const config_option options[] = {OPTION_HELP, OPTION_END};

const config_command command_schema = {
    .name = "schema",
    .summary = "print the JSON schema of a command's options files",
    .usage = "COMMAND",
    .about =
        "Prints the JSON schema (draft 7) of the options files that COMMAND reads with --options: "
        "precompute, simulate or static; or scene, that of the scene files of simulate.",
    .options = options,
    .examples = "schema simulate > simulate.schema.json\n"
                "schema scene > scene.schema.json",
};

static int print(cJSON *schema) {
  char *text = cJSON_Print(schema);
  if (text != NULL)
    puts(text);
  cJSON_free(text);
  cJSON_Delete(schema);
  return COMMAND_DONE;
}

static bool reads_files(const config_command *command) {
  for (const config_option *option = command->options; option->about != NULL; option++)
    if (option->kind == CONFIG_FILE)
      return true;
  return false;
}

int cmd_schema(int argc, char **argv) {
  const char *name = NULL, *names[COMMANDS_MAX] = {"scene"};
  int count = 1;
  CONFIG_TRY(config_options_read_one(&command_schema, "command", argc, argv, NULL, &name));

  // a scene, or the options file of a command
  if (strcmp(name, "scene") == 0)
    return print(config_schema("Scene of thrum simulate", scene_keys, true));

  // every command that takes --options has a schema
  for (const app_command *c = app_commands; c->about != NULL && count < COMMANDS_MAX; c++) {
    char title[80];
    if (!reads_files(c->about))
      continue;
    names[count++] = c->about->name;
    snprintf(title, sizeof title, "Options of thrum %s", name);
    if (strcmp(name, c->about->name) == 0)
      return print(config_schema(title, c->about->options, false));
  }
  const char *nearest = config_nearest(name, names, count);
  return config_usage("schema", "'%s' reads no options file; did you mean '%s'?", name,
                      nearest != NULL ? nearest : names[1]);
}
