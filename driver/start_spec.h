/* How a run starts, as the command line names it: mode:K,AMPLITUDE, static:LOAD or FILE.npy.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_START_SPEC_H
#define THRUM_DRIVER_START_SPEC_H

#include "driver/load_spec.h"

typedef enum cli_start_kind { CLI_START_FILE, CLI_START_MODE, CLI_START_STATIC } cli_start_kind;

/* One parsed start. `text` is borrowed from argv. */
typedef struct cli_start {
  const char *text;
  cli_start_kind kind;
  const char *path; /* of a file */
  int64_t mode;     /* 1-based basis vector */
  double amplitude; /* of the vertex that moves furthest [m] */
  cli_load load;    /* of an equilibrium */
} cli_start;

/* Parses a start; a failure is a mistake of usage. *start is untouched then. */
thrum_status cli_start_parse(const char *text, cli_start *start, thrum_error *error);

/* q and p (rank each, zero before): all starts together. They add up, but the loads of several
 * static: act together on one equilibrium. */
thrum_status cli_starts_make(const thrum_model *model, const cli_start *starts, int64_t count,
                             double *q, double *p, thrum_error *error);

#endif
