/* --rank: a model cut down when it is read. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model_truncate_to.h"

#include <stdint.h>

#include "platform/allocate.h"
#include "thrum/thrum.h"

thrum_status model_truncate_to(const thrum_model *loaded, int64_t rank, void **memory,
                               const thrum_model **model, thrum_error *error) {
  if (rank == 0 || rank == loaded->rank) {
    *model = loaded;
    return THRUM_OK;
  }
  if (thrum_model_masters(loaded) > 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "--rank: the model was precomputed condensed, and coordinates that "
                           "follow cannot be left out: give --condense 1 to %lld",
                           (long long)thrum_model_masters(loaded));
  thrum_error detail = {0};
  size_t size = 0;
  const thrum_status status = thrum_model_truncate_size(loaded, rank, &size, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "--rank: %s", detail.message);
  *memory = thrum_allocate_aligned(size, "the truncated model", error);
  if (*memory == NULL)
    return THRUM_OUT_OF_MEMORY;
  return thrum_model_truncate(*memory, size, loaded, rank, model, error);
}
