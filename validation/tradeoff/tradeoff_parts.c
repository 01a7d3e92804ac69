/* A trade-off from recipes that were run elsewhere: their bases and runs are put together in the
 * order that one process has them in. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "validation/tradeoff/tradeoff_private.h"

/* Appends one basis of a part with its runs. */
static thrum_status append(tradeoff_solution *s, const tradeoff_result *part, int64_t b,
                           thrum_error *error) {
  tradeoff_result *result = &s->result;
  const size_t room = (size_t)(result->run_count + part->run_count + 1);
  if (result->basis_count == TRADEOFF_BASES_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "more than %d bases at a time",
                           TRADEOFF_BASES_MAX);
  tradeoff_run *runs = realloc(result->runs, room * sizeof *runs);
  if (runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the runs");
  result->runs = runs;

  // runs count bases as the whole does
  for (int64_t n = 0; n < part->run_count; n++) {
    if (part->runs[n].basis != b)
      continue;
    runs[result->run_count] = part->runs[n];
    runs[result->run_count++].basis = result->basis_count;
  }
  result->bases[result->basis_count++] = part->bases[b];
  return THRUM_OK;
}

/* Counts what a part says beside its bases: a recipe that could not be made, and how far the
 * full order is from exact by this basis, which counts where it is the best. */
static void count_part(tradeoff_solution *s, const tradeoff_result *part) {
  if (part->dropped > 0) {
    s->result.dropped += part->dropped;
    s->result.dropped_reason = part->dropped_reason;
  }
  if (part->basis_count > 0 && part->bases[0].error.displacement < s->least_error) {
    s->least_error = part->bases[0].error.displacement;
    s->full_error = part->full_error;
  }
}

static thrum_status take(const tradeoff_solution *s, const tradeoff_recipe *recipe,
                         tradeoff_result *part, thrum_error *error) {
  return s->problem->take(s->problem->take_context, recipe, part, error);
}

/* The whole bases of all recipes come before the condensed ones. */
static thrum_status append_recipes(tradeoff_solution *s, bool condensed, thrum_error *error) {
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < s->problem->recipe_count && status >= 0; n++) {
    tradeoff_result part = {0};
    status = take(s, &s->problem->recipes[n], &part, error);
    if (status >= 0 && !condensed)
      count_part(s, &part);
    for (int64_t b = 0; b < part.basis_count && status >= 0; b++)
      if ((b > 0) == condensed)
        status = append(s, &part, b, error);
    tradeoff_free(&part);
  }
  return status;
}

thrum_status tradeoff_take_recipes(tradeoff_solution *s, thrum_error *error) {
  THRUM_TRY(append_recipes(s, false, error));
  THRUM_TRY(append_recipes(s, true, error));
  if (s->result.basis_count > 0)
    return THRUM_OK;

  // with no basis left there is nothing to compare
  return s->result.dropped > 0 ? thrum_error_set(error, s->result.dropped_reason.status, "%s",
                                                 s->result.dropped_reason.message)
                               : thrum_error_set(error, THRUM_MISSING, "no basis was tried yet");
}

thrum_status tradeoff_take_recipe(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                  thrum_error *error) {
  tradeoff_result part = {0};
  thrum_status status = take(s, recipe, &part, error);
  if (status >= 0)
    count_part(s, &part);
  for (int64_t b = 0; b < part.basis_count && status >= 0; b++)
    status = append(s, &part, b, error);
  tradeoff_free(&part);
  return status;
}
