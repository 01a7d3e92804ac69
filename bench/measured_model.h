/* The models that are measured when the user names none. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MEASURED_MODEL_H
#define THRUM_BENCH_MEASURED_MODEL_H

#include "thrum/thrum.h"

/* The body `beam:20x3x3@1x0.15x0.15,split=6`, held at one end, at this rank; bench_model_free. */
thrum_status bench_model_beam(int64_t rank, thrum_model **model, thrum_error *error);

/* The same of the free body `beam:14x14x10@0.3x0.3x0.2`, with 954 vertices on its surface. */
thrum_status bench_model_block(int64_t rank, thrum_model **model, thrum_error *error);

void bench_model_free(thrum_model *model);

#endif
