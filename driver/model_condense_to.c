/* --condense: a model condensed when it is read. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model_condense_to.h"

#include <stdint.h>

#include "platform/allocate.h"
#include "thrum/thrum.h"

thrum_status model_condense_to(const thrum_model *loaded, int64_t masters, void **memory,
                               const thrum_model **stepped, thrum_error *error) {
  *stepped = loaded;
  const int64_t count = masters > 0 ? masters : thrum_model_masters(loaded);
  if (count == 0)
    return THRUM_OK;

  thrum_error detail = {0};
  size_t size = 0;
  const thrum_status status = thrum_model_condense_size(loaded, count, &size, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "--condense: %s", detail.message);
  *memory = thrum_allocate_aligned(size, "the condensed model", error);
  if (*memory == NULL)
    return THRUM_OUT_OF_MEMORY;
  return thrum_model_condense(*memory, size, loaded, count, stepped, error);
}
