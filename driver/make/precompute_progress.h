/* How the stages of `thrum precompute` are called, and what is shown while they last.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_PROGRESS_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_PROGRESS_H

#include "config/progress.h"
#include "driver/make/precompute_request.h"

typedef struct precompute_stage_label {
  const char *name; /* for machines */
  const char *text;
} precompute_stage_label;

/* The last stage makes the polynomial, or the cubature points in its place. */
precompute_stage_label precompute_stage_label_of(thrum_stage stage, bool cubature);

/* The bar of a precompute. A training makes several bases one after the other, and `basis` tells
 * them apart: it stands before the stage, and is empty where there is one basis. */
typedef struct precompute_progress {
  config_progress bar;
  const char *basis;
  bool cubature;
} precompute_progress;

/* A basis in the making: what is asked for, the mesh and what of it is held, and who is told. */
typedef struct precompute_task {
  const precompute_request *request;
  const thrum_mesh *mesh;
  const uint8_t *fixed;             /* vertex_count */
  thrum_precompute_options options; /* of the request, with a progress that shows on the bar */
  precompute_progress *progress;
} precompute_task;

/* Shows a stage on the bar of `context`, a precompute_progress: progress of
 * thrum_precompute_options. Always true. */
bool precompute_progress_show(void *context, thrum_stage stage, double fraction);

#endif
