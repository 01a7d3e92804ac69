/* The model that targets without one of their own use. Header only.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_RANDOM_H
#define THRUM_TESTS_FUZZ_RANDOM_H

#include "tests/support/random_model.h"
#include "thrum/thrum.h"

/* A random model of a rank, with a mesh of so many vertices, or none of 0; made in the first call,
 * whose numbers all later ones must have. */
static inline const thrum_model *fuzz_random_model(int64_t rank, int64_t vertices) {
  static random_model made;
  if (made.omega2 == NULL) {
    random_model_make(&made, 21, rank, 1.0, 12.0, 0.5);
    if (vertices > 0)
      random_model_add_mesh(&made, 3, vertices);
    made.model.identity = thrum_model_identity(&made.model);
  }
  return &made.model;
}

#endif
