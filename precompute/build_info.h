/* Names what this build computes with; it is stored in models and printed with figures, because
 * another BLAS kernel gives other last bits. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BUILD_INFO_H
#define THRUM_PRECOMPUTE_BUILD_INFO_H

/* Compiler and its version; static storage. */
const char *thrum_build_compiler(void);

/* Kernel that OpenBLAS chose for this processor, such as "Haswell"; static storage. */
const char *thrum_build_blas_core(void);

#endif
