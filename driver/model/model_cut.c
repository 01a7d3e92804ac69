/* See model_cut.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/model_cut.h"

#include "config/message.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

thrum_status model_masters_asked(const thrum_model *loaded, int64_t rank, int64_t condense,
                                 int64_t *masters, thrum_error *error) {
  // all coordinates are a rank as well
  *masters = condense;
  if (rank == 0 || rank == loaded->rank)
    return THRUM_OK;
  if (rank > loaded->rank)
    return thrum_error_set_field(error, "--rank", THRUM_INVALID_ARGUMENT,
                                 ": rank %lld is asked for; the model has 1 to %lld",
                                 (long long)rank, (long long)loaded->rank);

  // coordinates that are not stepped follow, as with --condense
  if (thrum_model_masters(loaded) > 0)
    return thrum_error_set_field(error, "--rank", THRUM_MISSING,
                                 ": the model was precomputed condensed, and coordinates that "
                                 "follow cannot be left out: give --condense 1 to %lld",
                                 (long long)thrum_model_masters(loaded));
  if (condense > 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--rank %lld and --condense %lld both say how many coordinates are "
                           "stepped: leave one out",
                           (long long)rank, (long long)condense);
  if (loaded->point_count > 0)
    return thrum_error_set_field(
        error, "--rank", THRUM_UNSUPPORTED,
        ": the model has cubature points, so its coordinates beyond %lld "
        "cannot follow the others: leave --rank out, or precompute the model "
        "with --rank %lld",
        (long long)rank, (long long)rank);
  *masters = rank;
  return THRUM_OK;
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
