/* How a run starts, as the command line names it: mode:K,AMPLITUDE or FILE.npy.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CLI_START_SPEC_H
#define THRUM_CLI_START_SPEC_H

#include "thrum/thrum.h"

/* One parsed start. `text` is borrowed from argv and names the file when mode is 0. */
typedef struct cli_start {
  const char *text;
  int64_t mode;     /* 1-based basis vector, or 0: a file */
  double amplitude; /* of the vertex that moves furthest [m] */
} cli_start;

/* Parses a start; a failure is a mistake of usage. *start is untouched then. */
thrum_status cli_start_parse(const char *text, cli_start *start, thrum_error *error);

/* Adds the start to q and p (rank each), which are untouched on failure. */
thrum_status cli_start_add(const thrum_model *model, const cli_start *start, double *q, double *p,
                           thrum_error *error);

#endif
