/* The option --load of the commands that take loads. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_LOAD_OPTION_H
#define THRUM_DRIVER_LOAD_OPTION_H

#include "config/options.h"
#include "driver/load_spec.h"

/* Parses the load given into loads[*count], which has room for it, and counts it; COMMAND_DONE, or
 * the code after a line was printed. */
int cli_load_take(const config_given *given, cli_load *loads, int64_t *count);

#endif
