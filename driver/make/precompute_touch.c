/* Touch modes. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/precompute_touch.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/clock.h"

/* Finds how much of the rank is left for touch modes beside the usual basis. */
static thrum_status find_room(const precompute_request *request, int64_t usual, int64_t *room,
                              thrum_error *error) {
  *room = request->rank_max - usual;
  if (*room > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "--touch: rank %lld of the usual basis leaves nothing of %lld; raise "
                         "--rank-max, or lower --rank",
                         (long long)usual, (long long)request->rank_max);
}

/* Do the touch modes follow? Else they are stepped: points have no polynomial of some coordinates,
 * and what is condensed to its linear modes has them among what follows. */
static bool follow(const precompute_request *request) {
  return !request->touch_stepped && !request->condense && !request->options.cubature;
}

/* The model with the shapes in its basis; *base becomes it. */
static thrum_status step_shapes(const precompute_task *task, const double *fields, int64_t count,
                                thrum_precomputed *base, thrum_error *error) {
  thrum_precompute_options both = task->options;
  thrum_precomputed made = {0};
  both.trained = fields;
  both.trained_count = count;
  both.rank = base->model.rank + count;
  task->progress->basis = "with touch modes, ";
  THRUM_TRY(thrum_precompute(task->mesh, task->fixed, &both, &made, error));
  thrum_precomputed_free(base);
  *base = made;
  return THRUM_OK;
}

/* The shapes that `touch` finds beside *base, which follow it or become a part of it. */
static thrum_status add_shapes(const precompute_task *task, thrum_touch *touch,
                               touch_outcome *outcome, thrum_precomputed *base,
                               thrum_error *error) {
  int64_t room = 0;
  double *fields = NULL;
  THRUM_TRY(find_room(task->request, base->model.rank, &room, error));
  THRUM_TRY(thrum_reserve(&fields, 3 * task->mesh->vertex_count * room, sizeof *fields,
                          "the touch modes", error));
  config_progress_update(&task->progress->bar, "touch modes", 0.5);
  thrum_status status =
      thrum_touch_shapes(touch, &base->model, TOUCH_FOLLOWS, room, fields, &outcome->shapes, error);

  if (outcome->shapes > 0 && follow(task->request))
    THRUM_THEN(status, thrum_touch_follow(touch, &base->model, fields, outcome->shapes,
                                          &outcome->followers, error));
  else if (outcome->shapes > 0)
    THRUM_THEN(status, step_shapes(task, fields, outcome->shapes, base, error));
  free(fields);
  return status;
}

thrum_status precompute_touch(const precompute_task *task, touch_outcome *outcome,
                              thrum_precomputed *result, thrum_error *error) {
  // the usual basis, and how it follows
  const double began = clock_seconds();
  thrum_precomputed made = {0};
  thrum_touch *touch = NULL;
  task->progress->basis = "usual basis, ";
  THRUM_TRY(thrum_precompute(task->mesh, task->fixed, &task->options, &made, error));
  config_progress_update(&task->progress->bar, "answers to pulls", 0);
  thrum_status status = thrum_touch_create(&made.model, &touch, error);
  if (status >= 0)
    thrum_touch_measure(touch, &made.model, &outcome->before);

  // what it lacks
  const bool follows = status >= 0 && outcome->before.worst >= TOUCH_FOLLOWS;
  if (!follows)
    THRUM_THEN(status, add_shapes(task, touch, outcome, &made, error));
  if (status >= 0) {
    const bool beside = outcome->followers.count > 0;
    thrum_touch_measure(touch, beside ? &outcome->followers.model : &made.model, &outcome->after);
    memcpy(outcome->at, task->mesh->vertices + 3 * (int64_t)outcome->after.vertex,
           sizeof outcome->at);
    outcome->judged = true;
    outcome->missed = outcome->after.worst < TOUCH_FOLLOWS;
    outcome->seconds = clock_seconds() - began;
    for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
      outcome->seconds -= made.seconds[stage];
  }

  thrum_touch_free(touch);
  if (status < 0) {
    precompute_touch_free(outcome);
    thrum_precomputed_free(&made);
  } else {
    *result = made;
  }
  return status;
}

void precompute_touch_free(touch_outcome *outcome) {
  thrum_touch_followers_free(&outcome->followers);
}

void touch_coverage_json(cJSON *object, const char *key, const thrum_touch_coverage *coverage,
                         const double at[3]) {
  cJSON *item = cJSON_AddObjectToObject(object, key);
  json_number(item, "worst", coverage->worst);
  json_number(item, "mean", coverage->mean);
  json_number(item, "worst_direction", coverage->direction);
  json_number(item, "worst_direction_vertex", coverage->direction_vertex + 1);
  if (at != NULL) {
    json_number(item, "vertex", coverage->vertex + 1);
    json_numbers(item, "at_m", at, 3);
  }
  json_number(item, "places", (double)coverage->places);
  json_number(item, "stiff_places", (double)coverage->stiff);
}
