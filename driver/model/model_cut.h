/* --rank and --condense: a model is condensed when it is read.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_MODEL_CUT_H
#define THRUM_DRIVER_MODEL_MODEL_CUT_H

#include "thrum/model.h"
#include <stdint.h>

/* How many coordinates of `loaded` are stepped while the others follow, by --rank and --condense
 * (0: not given): *masters is 0 where all are. No coordinate is cut off, for that would lock the
 * body.
 */
thrum_status model_masters_asked(const thrum_model *loaded, int64_t rank, int64_t condense,
                                 int64_t *masters, thrum_error *error);

/* Refuses a model that was precomputed condensed, which has no polynomial of all its coordinates,
 * where `command` needs that. `remedy`: how to precompute it instead. */
thrum_status model_check_whole(const thrum_model *model, const char *path, const char *command,
                               const char *remedy, thrum_error *error);

/* The stepped model of `loaded` with its lowest `masters` coordinates (thrum/condensed_model.h) in
 * *memory, which the caller frees; 0: all masters of a model that was precomputed condensed, and
 * `loaded` itself of any other. The loaded model must stay. */
thrum_status model_condense_to(const thrum_model *loaded, int64_t masters, void **memory,
                               const thrum_model **stepped, thrum_error *error);

#endif
