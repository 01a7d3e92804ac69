/* The lists of commands. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_COMMANDS_H
#define THRUM_APP_COMMANDS_H

#include <stdio.h>

#include "config/options.h"

/* One command, or one measurement of `thrum bench`; argv[0] is its name. */
typedef struct app_command {
  const config_command *about;
  int (*run)(int argc, char **argv);
} app_command;

/* The lists end with a command without `about`. */
extern const app_command app_commands[];
extern const app_command bench_commands[];

/* The command of this name, the last word of about->name; NULL after a line with the nearest one,
 * which says that `what` it is not: "command". */
const app_command *app_command_find(const app_command *list, const char *of, const char *what,
                                    const char *name);
/* Prints the commands of a list with their summaries. */
void app_commands_print(FILE *stream, const app_command *list);

#endif
