/* A surface's block and its kernels, private to the runtime (thrum/surface.h).
 *
 * Vertices stand in blocks of 16. A block's rows of U are rank x 3 x 16 floats: for each mode the
 * 16 x, the 16 y, the 16 z. So a product needs no sum across a register, and reads the whole of U
 * in ascending order once. The last block is filled up with zeros.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_READOUT_SURFACE_PRIVATE_H
#define THRUM_RUNTIME_READOUT_SURFACE_PRIVATE_H

#include <stdint.h>

#include "thrum/surface.h"

#define THRUM_SURFACE_BLOCK 16                        /* vertices */
#define THRUM_SURFACE_LANES (3 * THRUM_SURFACE_BLOCK) /* floats of one mode of a block */

/* position += sum_i q_i row_i, i ascending, no fused multiply-add; rows: rank x 48, aligned to 64;
 * position: 48. */
typedef void thrum_surface_kernel(int64_t rank, const float *rows, const float *q, float *position);

/* The fastest one for this processor. All give the same bits. */
thrum_surface_kernel *thrum_surface_kernel_best(void);

/* Plain C, and what the others are tested against. */
thrum_surface_kernel thrum_surface_kernel_reference;

#endif
