/* Free bodies whose rotation and shape act on each other (thrum/floating_frame.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_coupled.h"

#include "scene/scene_free_body.h"
#include "scene/scene_memory.h"
#include "scene/scene_model.h"

#include "thrum/external_load.h"

/* The work serves steps, and a body's loads on all coordinates of its model. */
static size_t work_count(const scene_body *body, const scene_model *derived) {
  const size_t loads = 9 * (size_t)body->model->rank;
  const size_t steps = thrum_floating_frame_work_count(derived->inertia);
  return steps > loads ? steps : loads;
}

thrum_status scene_coupled_fit(scene_body *body, scene_model *derived, const thrum_state_def *def,
                               thrum_error *error) {
  if (def->integrator != THRUM_INTEGRATOR_ENERGY || def->damping_form != THRUM_DAMPING_REST)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "rotation and shape are coupled by the integrator energy alone, with "
                           "the damping form rest, and this body is stepped by %s: leave out its "
                           "integrator and damping form, or coupled",
                           thrum_integrator_name(def->integrator));
  THRUM_TRY(scene_model_inertia(derived, error));
  if (!scene_grow(&body->inertia_work, (int64_t)work_count(body, derived),
                  sizeof *body->inertia_work))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a coupled body");
  return THRUM_OK;
}

thrum_status scene_coupled_start(scene_body *body, thrum_error *error) {
  return thrum_floating_frame_settle(body->derived->inertia, body->start_q, body->start_p,
                                     &body->rigid_frame, body->inertia_work, error);
}

thrum_status scene_coupled_step(scene_body *body, thrum_error *error) {
  const thrum_model *model = body->derived->model;
  THRUM_TRY(thrum_state_set_force(model, body->state, body->force, error));
  const thrum_status status = thrum_floating_frame_step(
      model, body->state, body->derived->inertia, &body->placement, &body->rigid_frame,
      body->wrench.torque, NULL, body->inertia_work, error);
  if (status < 0)
    return status;
  THRUM_TRY(scene_free_move(body, body->wrench.force, body->def.dt, error));
  scene_free_place(body);
  return status;
}

void scene_coupled_moments(const thrum_scene *scene, const scene_body *body, int64_t step,
                           double moments[9]) {
  const int64_t r = body->model->rank;
  double *parts = body->inertia_work;
  thrum_load_sum(body->now, body->parts, body->load_count, 9 * r, step, scene->dt, parts);
  for (int n = 0; n < 9; n++)
    for (int64_t i = 0; i < body->derived->rank; i++)
      moments[n] += parts[n * r + i] * body->q[i];
}
