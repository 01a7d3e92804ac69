/* Levels of the actuators of bodies over time: courses as those of loads, of which several may be
 * of one actuator (thrum/actuation.h). The levels of a step are their means over it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_actuation.h"

#include <math.h>
#include <string.h>

#include "scene/scene_access.h"
#include "scene/scene_memory.h"
#include "thrum/external_load.h"

static thrum_status refuse_followed(const scene_body *body, thrum_error *error) {
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "actuators act on coordinates that are stepped, and of body '%s' some "
                         "would follow at rest: step it uncondensed, without a level of detail",
                         body->name);
}

thrum_status scene_actuation_check_followed(const scene_body *body, thrum_error *error) {
  return body->act_count > 0 ? refuse_followed(body, error) : THRUM_OK;
}

static thrum_status check(const scene_body *body, int64_t actuator, double level,
                          const thrum_load *course, thrum_error *error) {
  const int64_t count = thrum_model_actuators(body->model);
  if (actuator < 0 || actuator >= count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "actuator %lld is asked for; the model of this body has %lld",
                           (long long)actuator, (long long)count);
  if (body->derived->condensed || body->detail)
    return refuse_followed(body, error);
  if (!isfinite(level) || course == NULL || isnan(course->from) || isnan(course->until) ||
      !isfinite(course->frequency))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the course of a level is not a number");
  return THRUM_OK;
}

thrum_status thrum_scene_add_actuation(thrum_scene *scene, int32_t number, int64_t actuator,
                                       double level, const thrum_load *course, thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  THRUM_TRY(check(body, actuator, level, course, error));
  if (!scene_grow(&body->acts, body->act_count + 1, sizeof *body->acts))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the course of a level");
  body->acts[body->act_count++] = (scene_act){actuator, level, *course, *course};
  scene->revision++;
  scene->stirred++;
  scene_actuation_retime(scene);
  return THRUM_OK;
}

void scene_actuation_retime(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->body_count; n++)
    for (int64_t k = 0; k < scene->bodies[n]->act_count; k++) {
      scene_act *act = scene->bodies[n]->acts + k;
      act->now = act->course;
      act->now.from -= scene->origin;
      act->now.until -= scene->origin;
    }
}

thrum_status scene_actuation_set(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  if (body->act_count == 0)
    return THRUM_OK;
  double levels[THRUM_ACTUATORS_MAX];
  const int64_t count = thrum_model_actuators(body->model);
  const int64_t step = scene->steps - scene->origin_step;
  memset(levels, 0, (size_t)count * sizeof *levels);
  for (int64_t k = 0; k < body->act_count; k++)
    levels[body->acts[k].actuator] +=
        body->acts[k].level * thrum_load_mean(&body->acts[k].now, step, scene->dt);
  return thrum_state_set_actuation(body->derived->model, body->state, levels, error);
}

double scene_actuation_work(const scene_body *body) {
  double work[THRUM_ACTUATORS_MAX], sum = 0.0;
  const thrum_model *model = body->derived->model;
  if (thrum_model_actuators(model) == 0 ||
      thrum_state_actuation_work(model, body->state, work, NULL) < 0)
    return 0.0;
  for (int64_t k = 0; k < thrum_model_actuators(model); k++)
    sum += work[k];
  return sum;
}
