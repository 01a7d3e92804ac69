/* Options of `thrum response`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_OPTIONS_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_OPTIONS_H

#include "config/options.h"
#include "driver/response/response_load.h"
#include "driver/spec/damping_spec.h"

typedef struct response_request {
  const char *model_path;
  const char *start_from; /* .npy of a state at phase 0; NULL: the motion at rest of the load */
  const char *output;     /* folder; NULL: nothing is written */
  int64_t mode;           /* 1-based, of a backbone; 0: a forced curve */
  response_load *loads;
  int64_t load_count;
  double from, to;      /* [Hz]; 0: by the mode */
  const char **at;      /* targets, as given */
  load_target *targets; /* the same, parsed */
  int64_t target_count;
  int64_t harmonics; /* of the motion; 0: as many as are needed */
  int64_t periods;   /* of the load in one of the motion */
  int64_t branch;    /* branch point after which the other curve is followed; 0: none */
  bool other_side;   /* of it */
  damping_spec damping;
  int64_t condense;       /* masters; -1: by the model, 0: none follow */
  double amplitude;       /* of the first target, at which a backbone ends [m]; infinite: none */
  double step, tolerance; /* of the library */
  int64_t points_max, stability_steps;
  bool stability;
  bool followers;       /* what follows has inertia and damping */
  int64_t target_given; /* of the targets by --at; the others are those of the loads */
  int64_t *starts;      /* 1-based points whose state is written */
  int64_t start_count;
  int64_t check; /* motions that the mesh is stepped on; 0: none; -1: as its size allows */
  bool no_check;
  double check_error; /* by which they may miss */
  bool json, quiet;
  config_file file; /* of --options; the texts above may point into it */
} response_request;

/* The command and its options. */
extern const config_command command_response;

/* Fills a zeroed request whose lists have room for argc + CONFIG_FILE_ITEMS_MAX. COMMAND_DONE, or
 * what the command is to return. */
int response_options_read(int argc, char **argv, response_request *request);

#endif
