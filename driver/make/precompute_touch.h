/* precompute --touch: a model that also shows how the body answers pulls at its surface.
 *
 * The usual model is made first; what it lacks of the static answers to pulls all over the surface
 * then gives touch modes beside its rank (precompute/model/touch.h). They follow what acts on the
 * body (precompute/model/touch_follow.h), and the usual model is stepped, unless they are to be
 * stepped as well.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_TOUCH_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_TOUCH_H

#include "driver/make/precompute_progress.h"
#include "io/json.h"
#include "precompute/model/touch_follow.h"

/* The share of the body's give by which a model with touch modes follows every visible place. */
#define TOUCH_FOLLOWS 0.8

/* The outcome; a zeroed one is of a model without touch modes. */
typedef struct touch_outcome {
  int64_t shapes;                     /* touch modes */
  thrum_touch_followers followers;    /* those that are not stepped, beside the result; owned */
  thrum_touch_coverage before, after; /* of the usual basis, and with them */
  double at[3];                       /* where the worst place is afterwards [m] */
  bool judged;                        /* the rest is filled */
  bool missed;                        /* the share is not reached */
  double seconds;                     /* beside the stages of the model with them */
} touch_outcome;

/* Makes the usual model of the options and its touch modes up to the request's rank_max: *result is
 * the usual model, and outcome->followers has what follows it; or *result has both. On failure
 * neither is to be freed. */
thrum_status precompute_touch(const precompute_task *task, touch_outcome *outcome,
                              thrum_precomputed *result, thrum_error *error);

void precompute_touch_free(touch_outcome *outcome); /* a zeroed one is fine */

/* Adds how a model follows pulls to a JSON object: worst, mean, the worst
 * direction, the place of the worst, counts. */
void touch_coverage_json(cJSON *object, const char *key, const thrum_touch_coverage *coverage,
                         const double at[3]);

#endif
