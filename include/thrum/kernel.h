/* Which instructions evaluate the polynomial. All kernels give the same bits (docs/determinism.md),
 * so the choice affects speed alone; the best one is taken unless a state's def says otherwise.
 *
 * Pure functions; nothing is allocated; any thread.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_KERNEL_H
#define THRUM_KERNEL_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, value, text) */
#define THRUM_KERNEL_LIST(X)                                                                       \
  X(BEST, 0, "best")           /* the fastest one that this machine has */                         \
  X(REFERENCE, 1, "reference") /* plain C */                                                       \
  X(AVX2, 2, "avx2")                                                                               \
  X(AVX512, 3, "avx512")                                                                           \
  X(NEON, 4, "neon")                                                                               \
  X(WASM, 5, "wasm") /* 128-bit SIMD of WebAssembly */

typedef enum thrum_kernel_id {
#define X(name, value, text) THRUM_KERNEL_##name = value,
  THRUM_KERNEL_LIST(X)
#undef X
} thrum_kernel_id;

/* True where this build on this machine can run the kernel, as for THRUM_KERNEL_BEST; false also
 * for a number that names none. */
THRUM_API bool thrum_kernel_usable(thrum_kernel_id id);

/* The kernel that a request for `id` gets: that one when usable, else the best one here; never
 * THRUM_KERNEL_BEST. */
THRUM_API thrum_kernel_id thrum_kernel_chosen(thrum_kernel_id id);

/* Name of a kernel, "avx512" and so on; NULL for a number that names none. Static storage. */
THRUM_API const char *thrum_kernel_name(thrum_kernel_id id);

#ifdef __cplusplus
}
#endif
#endif
