/* The commands that make the recommended model and run it. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_TRADEOFF_COMMANDS_H
#define THRUM_APP_TRADEOFF_COMMANDS_H

#include <cjson/cJSON.h>

#include "app/tradeoff_options.h"

/* The parts that the commands are made of; the pointers are borrowed. */
typedef struct tradeoff_commands {
  const tradeoff_request *request;
  const tradeoff_problem *problem;
  const tradeoff_result *result; /* with a chosen run */
  const load_spec *loads;
  int64_t load_count;
  int64_t own_modes;   /* of the model's own basis; 0: not known */
  const char *program; /* how a shell calls this program */
} tradeoff_commands;

/* Writes commands.sh, simulate.json and, where a model has to be made, precompute.json. */
thrum_status tradeoff_commands_write(const tradeoff_commands *commands, const char *folder,
                                     thrum_error *error);

/* Adds "commands": the texts. */
thrum_status tradeoff_commands_add(const tradeoff_commands *commands, cJSON *object,
                                   thrum_error *error);
void tradeoff_commands_print(const tradeoff_commands *commands);

#endif
