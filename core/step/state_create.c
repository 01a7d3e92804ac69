/* A state in heap memory (thrum/state.h). It stands alone in its file, so that a program which lays
 * its states into memory of its own links no allocator. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "core/base/alignment_check.h"
#include "thrum/state.h"

thrum_status thrum_state_create(const thrum_model *model, const thrum_state_def *def,
                                thrum_state **state, thrum_error *error) {
  if (!state)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "state is NULL");
  size_t size;
  THRUM_TRY(thrum_state_size(model, def, &size, error));

  // aligned_alloc wants a multiple of the alignment
  void *memory = size <= SIZE_MAX - THRUM_ALIGNMENT
                     ? aligned_alloc(THRUM_ALIGNMENT, thrum_round_up(size))
                     : NULL;
  if (!memory)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a state of %zu bytes", size);

  const thrum_status status = thrum_state_init(memory, size, model, def, state, error);
  if (status < 0)
    free(memory);
  return status;
}

void thrum_state_destroy(thrum_state *state) {
  free(state);
}
