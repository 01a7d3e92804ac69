/* Progress of stages and checked allocation, see stage.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/stage.h"

#include <stdlib.h>

thrum_status thrum_report(const thrum_reporter *reporter, double fraction, thrum_error *error) {
  if (!reporter || !reporter->options->progress)
    return THRUM_OK;
  const thrum_precompute_options *options = reporter->options;
  if (options->progress(options->progress_context, reporter->stage, fraction))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INTERRUPTED, "stopped on request");
}

void *thrum_allocate(int64_t count, size_t size, const char *what, thrum_error *error) {
  void *memory = NULL;
  if (count >= 0 && (uint64_t)count <= SIZE_MAX / 2 / size)
    memory = malloc((size_t)count * size + 1);
  if (!memory)
    thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %s (%.0f MB)", what,
                    (double)count * (double)size / 1048576);
  return memory;
}
