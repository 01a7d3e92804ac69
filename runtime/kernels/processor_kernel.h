/* The kernels of the processor; private to the runtime, see processor_kernel.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_KERNELS_PROCESSOR_KERNEL_H
#define THRUM_RUNTIME_KERNELS_PROCESSOR_KERNEL_H

#include "core/polynomial/kernel_private.h"

/* The other kernels that this build has. */
#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define THRUM_KERNEL_HAS_X86 1
extern const thrum_kernel thrum_kernel_avx2;
extern const thrum_kernel thrum_kernel_avx512;
#endif
#if defined(__aarch64__) && defined(__ARM_NEON)
#define THRUM_KERNEL_HAS_ARM 1
extern const thrum_kernel thrum_kernel_neon;
#endif
#if defined(__wasm_simd128__)
#define THRUM_KERNEL_HAS_WASM 1
extern const thrum_kernel thrum_kernel_wasm;
#endif

/* The kernel of this id, or NULL where this build or this processor lacks it; the fastest one for
 * THRUM_KERNEL_BEST. */
const thrum_kernel *thrum_processor_kernel(int32_t id);

#endif
