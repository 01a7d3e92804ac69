/* The lists of commands. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "app/bench_command.h"
#include "app/cmd.h"
#include "app/commands.h"

#include "config/message.h"

#define COMMANDS_MAX 32

#define X(name) {&command_##name, cmd_##name},
const app_command app_commands[] = {COMMAND_LIST(X){NULL, NULL}};
#undef X
#define X(name) {&command_bench_##name, bench_##name##_command},
const app_command bench_commands[] = {BENCH_COMMAND_LIST(X){NULL, NULL}};
#undef X

static const char *last_word(const char *name) {
  const char *blank = strrchr(name, ' ');
  return blank != NULL ? blank + 1 : name;
}

const app_command *app_command_find(const app_command *list, const char *of, const char *what,
                                    const char *name) {
  const char *names[COMMANDS_MAX];
  int count = 0;
  for (const app_command *c = list; c->about != NULL && count < COMMANDS_MAX; c++) {
    names[count] = last_word(c->about->name);
    if (strcmp(names[count++], name) == 0)
      return c;
  }
  const char *nearest = config_nearest(name, names, count);
  if (nearest != NULL)
    config_usage(of, "unknown %s '%s'; did you mean '%s'?", what, name, nearest);
  else
    config_usage(of, "unknown %s '%s'", what, name);
  return NULL;
}

void app_commands_print(FILE *stream, const app_command *list) {
  for (const app_command *c = list; c->about != NULL; c++)
    fprintf(stream, "  %-12s %s\n", last_word(c->about->name), c->about->summary);
}
