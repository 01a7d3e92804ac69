/* Loads as the command line names them: KIND:X,Y,Z[@TARGET][,key=value...].
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_LOAD_SPEC_H
#define THRUM_DRIVER_LOAD_SPEC_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

#define CLI_LOAD_TEXT_MAX 512

/* Vertices by name: all, vertex=N or a group. */
typedef struct cli_target {
  bool all;
  int64_t vertex; /* 1-based; 0: a group */
  char group[CLI_LOAD_TEXT_MAX];
} cli_target;

/* One parsed load. `text` is borrowed from argv. */
typedef struct cli_load {
  const char *text;
  bool gravity;      /* vector is an acceleration [m/s^2] on the whole body, not a force [N] */
  bool traction;     /* vector is a force an area [Pa] on the surface of the target */
  double vector[3];  /* the total over the target */
  cli_target target; /* none of gravity */
  thrum_load course;
} cli_load;

/* Parses a target. `said` is the option that it stands in, for the message. *target is untouched on
 * failure, a mistake of usage. */
thrum_status cli_target_parse(const char *text, const char *said, cli_target *target,
                              thrum_error *error);

/* Its vertices: *vertices points into the model (NULL: all of them) or at *one, which gets the
 * number of a single vertex. */
thrum_status cli_target_find(const thrum_model *model, const cli_target *target,
                             const int32_t **vertices, int64_t *count, int32_t *one,
                             thrum_error *error);

/* Does the text begin as a load does? */
bool cli_load_begins(const char *text);

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
