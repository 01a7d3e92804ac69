/* See load_option.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/load_option.h"

#include "config/message.h"

int cli_load_take(const config_given *given, cli_load *loads, int64_t *count) {
  thrum_error error = {0};
  if (cli_load_parse(given->text, &loads[*count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  ++*count;
  return COMMAND_DONE;
}
