/* See model_cut.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model_cut.h"

#include "config/message.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

thrum_status model_truncate_to(const thrum_model *loaded, int64_t rank, void **memory,
                               const thrum_model **model, thrum_error *error) {
  *model = loaded;
  if (rank == 0 || rank == loaded->rank)
    return THRUM_OK;
  if (thrum_model_masters(loaded) > 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "--rank: the model was precomputed condensed, and coordinates that "
                           "follow cannot be left out: give --condense 1 to %lld",
                           (long long)thrum_model_masters(loaded));

  size_t size = 0;
  THRUM_TRY(
      config_error_in(error, thrum_model_truncate_size(loaded, rank, &size, error), "--rank"));
  THRUM_TRY(thrum_reserve_aligned(memory, size, "the truncated model", error));
  return thrum_model_truncate(*memory, size, loaded, rank, model, error);
}

thrum_status model_check_whole(const thrum_model *model, const char *path, const char *command,
                               const char *remedy, thrum_error *error) {
  const int64_t masters = thrum_model_masters(model);
  if (masters == 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "%.200s: the model was precomputed condensed to %lld of %lld coordinates, "
                         "which %s cannot take: precompute it %s",
                         path, (long long)masters, (long long)model->rank, command, remedy);
}

thrum_status model_condense_to(const thrum_model *loaded, int64_t masters, void **memory,
                               const thrum_model **stepped, thrum_error *error) {
  const int64_t count = masters > 0 ? masters : thrum_model_masters(loaded);
  size_t size = 0;
  *stepped = loaded;
  if (count == 0)
    return THRUM_OK;
  THRUM_TRY(
      config_error_in(error, thrum_model_condense_size(loaded, count, &size, error), "--condense"));
  THRUM_TRY(thrum_reserve_aligned(memory, size, "the condensed model", error));
  return thrum_model_condense(*memory, size, loaded, count, stepped, error);
}
