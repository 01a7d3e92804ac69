/* The outcome of a precomputation, which its table, its JSON line and meta show.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_OUTCOME_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_OUTCOME_H

#include "driver/make/element_order.h"
#include "driver/make/precompute_request.h"
#include "driver/make/precompute_touch.h"
#include "driver/make/precompute_train.h"
#include "driver/model/split_at.h"

/* The facts known once the model is made; seconds are wall-clock times. */
typedef struct precompute_outcome {
  const precompute_request *request;
  const thrum_mesh *mesh;
  const thrum_precomputed *result;
  element_order order;    /* with the errors that the precompute found, where it did */
  int64_t fixed_count;    /* vertices with any component held */
  train_outcome training; /* of --train; freed with the result */
  touch_outcome touch;    /* of --touch */
  bool flagged;
  double dt; /* of the split */
  split_counts split;
  double began; /* clock_seconds() when the command started */
  double seconds_mesh;
  double seconds_write;
  double seconds_total;
} precompute_outcome;

#endif
