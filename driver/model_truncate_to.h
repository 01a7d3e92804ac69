/* --rank: a model truncated when it is read. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_TRUNCATE_TO_H
#define THRUM_DRIVER_MODEL_TRUNCATE_TO_H

#include "thrum/model.h"
#include <stdint.h>

/* `loaded` cut down to its lowest `rank` coordinates (0: all of them) in *memory, which the caller
 * frees; the loaded model must stay. */
thrum_status model_truncate_to(const thrum_model *loaded, int64_t rank, void **memory,
                               const thrum_model **model, thrum_error *error);

#endif
