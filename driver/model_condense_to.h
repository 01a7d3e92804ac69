/* --condense: what is stepped of a model that is condensed when it is read.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_CONDENSE_TO_H
#define THRUM_DRIVER_MODEL_CONDENSE_TO_H

#include "thrum/model.h"
#include <stdint.h>

/* The stepped model of `loaded` with its lowest `masters` coordinates (thrum/condensed_model.h) in
 * *memory, which the caller frees; 0: all masters of a model that was precomputed condensed, and
 * `loaded` itself of any other. The loaded model must stay. */
thrum_status model_condense_to(const thrum_model *loaded, int64_t masters, void **memory,
                               const thrum_model **stepped, thrum_error *error);

#endif
