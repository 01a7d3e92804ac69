/* The kernels that this build and this processor have. Nothing is kept: asking the processor costs
 * a load and a test. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/kernels/processor_kernel.h"

static const thrum_kernel *usable(int32_t id) {
  // a build has the tables of its own processor alone
  switch (id) {
// x86's kernels need the instructions, and the operating system's support for their registers
#ifdef THRUM_KERNEL_HAS_X86
  // both ask for the operating system's support as well
  case THRUM_KERNEL_AVX2:
    return __builtin_cpu_supports("avx2") ? &thrum_kernel_avx2 : NULL;
  case THRUM_KERNEL_AVX512:
    return __builtin_cpu_supports("avx512f") ? &thrum_kernel_avx512 : NULL;
#endif

#ifdef THRUM_KERNEL_HAS_ARM
  case THRUM_KERNEL_NEON:
    return &thrum_kernel_neon;
#endif
#ifdef THRUM_KERNEL_HAS_WASM
  case THRUM_KERNEL_WASM:
    return &thrum_kernel_wasm;
#endif

  default:
    return NULL;
  }
}

const thrum_kernel *thrum_processor_kernel(int32_t id) {
  static const int32_t fastest_first[] = {THRUM_KERNEL_AVX512, THRUM_KERNEL_AVX2, THRUM_KERNEL_NEON,
                                          THRUM_KERNEL_WASM};
  if (id != THRUM_KERNEL_BEST)
    return usable(id);
  const thrum_kernel *found = NULL;
  for (size_t n = 0; !found && n < sizeof fastest_first / sizeof fastest_first[0]; n++)
    found = usable(fastest_first[n]);
  return found ? found : &thrum_kernel_reference;
}
