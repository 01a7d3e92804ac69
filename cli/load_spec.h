/* Loads as the command line names them: KIND:X,Y,Z[@TARGET][,key=value...].
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_LOAD_SPEC_H
#define THRUM_CLI_LOAD_SPEC_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

#define CLI_LOAD_TEXT_MAX 512

/* One parsed load. `text` is borrowed from argv. */
typedef struct cli_load {
  const char *text;
  bool gravity;     /* vector is an acceleration [m/s^2] on the whole body, not a force [N] */
  double vector[3]; /* the total over the target */
  bool all;         /* @all */
  int64_t vertex;   /* vertex=N, 1-based; 0: a group */
  char group[CLI_LOAD_TEXT_MAX];
  thrum_load course;
} cli_load;

/* Parses a load; a failure is a mistake of usage. *load is untouched then. */
thrum_status cli_load_parse(const char *text, cli_load *load, thrum_error *error);

/* reduced (rank) = U^T of the load at its full strength, zero where all of its vertices are held.
 * Fails when the model has no such group or vertex, or no basis. */
thrum_status cli_load_reduce(const thrum_model *model, const cli_load *load, double *reduced,
                             thrum_error *error);

/* forces (3 vertex_count) [N] += the load at its full strength, gravity too. */
thrum_status cli_load_fill(const thrum_model *model, const cli_load *load, double *forces,
                           thrum_error *error);

#endif
