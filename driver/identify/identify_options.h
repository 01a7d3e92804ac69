/* Options of `thrum identify`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_IDENTIFY_IDENTIFY_OPTIONS_H
#define THRUM_DRIVER_IDENTIFY_IDENTIFY_OPTIONS_H

#include "config/options.h"
#include "driver/spec/damping_spec.h"
#include "driver/spec/start_spec.h"

typedef struct identify_request {
  const char *model_path, *recording_path;
  const char *output; /* folder; NULL: nothing is written */
  const char *parameters;
  bool young, poisson, density, ratio, alpha, beta, start; /* what is fitted */
  int64_t ratio_count, start_modes;
  start_spec *starts;
  int64_t start_count;
  damping_spec damping; /* from which the fit begins, and what is not fitted */
  double dt;            /* [s]; 0: by the model and the recording */
  int64_t iterations;   /* of each window, at most */
  bool json, quiet;
  config_file file; /* of --options; the texts above may point into it */
} identify_request;

/* The command and its options. */
extern const config_command command_identify;

/* Fills a zeroed request whose list has room for argc + CONFIG_FILE_ITEMS_MAX. COMMAND_DONE, or
 * what the command is to return. */
int identify_options_read(int argc, char **argv, identify_request *request);

#endif
