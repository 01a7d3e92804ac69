/* Which kernels evaluate batches (batch_kernel.h). SPDX-License-Identifier: Apache-2.0 */
#include "runtime/batch/batch_kernel.h"

const thrum_batch_kernel *thrum_batch_kernel_of(thrum_kernel_id id) {
#ifdef THRUM_KERNEL_HAS_X86
  if (id == THRUM_KERNEL_AVX512)
    return &thrum_batch_kernel_avx512;
  if (id == THRUM_KERNEL_AVX2)
    return &thrum_batch_kernel_avx2;
#else
  (void)id;
#endif
  return NULL;
}
