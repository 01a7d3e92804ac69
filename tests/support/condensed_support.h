/* Condensed models for tests: one heap block each, made by calls that must succeed. Header only.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_CONDENSED_SUPPORT_H
#define THRUM_TESTS_SUPPORT_CONDENSED_SUPPORT_H

#include "tests/support/state_support.h"
#include "thrum/condensed_model.h"

/* Condenses `model` to its first coordinates; returns the memory of *condensed, which is freed. */
static inline void *condense(const thrum_model *model, int64_t masters,
                             const thrum_model **condensed) {
  size_t size = 0;
  thrum_error error;
  if (thrum_model_condense_size(model, masters, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  if (thrum_model_condense(memory, size, model, masters, condensed, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return memory;
}

#endif
