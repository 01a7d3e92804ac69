/* The choice among the kernels that this build and this machine have
 * (core/polynomial/kernel_private.h). Nothing is kept: asking the processor costs a load and a
 * test.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"

const thrum_kernel *thrum_kernel_get(int32_t id) {
  if (id == THRUM_KERNEL_REFERENCE || !thrum_passes.kernel)
    return &thrum_kernel_reference;
  const thrum_kernel *found = thrum_passes.kernel(id);
  return found ? found : thrum_kernel_get(THRUM_KERNEL_BEST);
}

bool thrum_kernel_usable(thrum_kernel_id id) {
  if (id == THRUM_KERNEL_BEST || id == THRUM_KERNEL_REFERENCE)
    return true;
  return thrum_passes.kernel && thrum_passes.kernel((int32_t)id) != NULL;
}

thrum_kernel_id thrum_kernel_chosen(thrum_kernel_id id) {
  return thrum_kernel_get((int32_t)id)->id;
}

const char *thrum_kernel_name(thrum_kernel_id id) {
  switch ((int)id) {
#define X(name, value, text)                                                                       \
  case value:                                                                                      \
    return text;
    THRUM_KERNEL_LIST(X)
#undef X
  default:
    return NULL;
  }
}
