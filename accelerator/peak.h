/* A device's rate of arithmetic, for `thrum bench accelerator`. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_ACCELERATOR_PEAK_H
#define THRUM_ACCELERATOR_PEAK_H

#include "thrum/accelerator.h"

/* Puts a run of single-precision fused multiplications and additions into the device's queue and
 * waits for it; *operations gets how many of both it made, for the caller to take the time. Call it
 * once before, as the first run compiles. */
thrum_status accelerator_peak_run(const thrum_accelerator *accelerator, double *operations,
                                  thrum_error *error);

/* Additions and multiplications of the products with coefficients in one step of one body of a
 * crowd: all else of a step is small beside them from rank 10 on. */
double crowd_step_operations(int64_t rank, const thrum_crowd_def *def);

#endif
