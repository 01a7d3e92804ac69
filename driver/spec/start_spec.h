/* How a run starts, as the command line names it: mode:K,AMPLITUDE, static:LOAD or FILE.npy.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_START_SPEC_H
#define THRUM_DRIVER_SPEC_START_SPEC_H

#include "driver/spec/load_spec.h"

typedef enum start_kind { START_FILE, START_MODE, START_STATIC } start_kind;

/* One parsed start. `text` is borrowed from argv. */
typedef struct start_spec {
  const char *text;
  start_kind kind;
  const char *path; /* of a file */
  int64_t mode;     /* 1-based basis vector */
  double amplitude; /* of the vertex that moves furthest [m] */
  load_spec load;   /* of an equilibrium */
} start_spec;

/* Parses a start; a failure is a mistake of usage. *start is untouched then. */
thrum_status start_spec_parse(const char *text, start_spec *start, thrum_error *error);

/* q and p (rank each, zero before): all starts together. They add up, but the loads of several
 * static: act together on one equilibrium. */
thrum_status start_specs_make(const thrum_model *model, const start_spec *starts, int64_t count,
                              double *q, double *p, thrum_error *error);

#endif
