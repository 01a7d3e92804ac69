/* One step of a scene: loads, then bodies of one model side by side (thrum/batch.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <string.h>

#include "scene/scene_private.h"
#include "thrum/external_load.h"

/* The load of the step to come. */
static thrum_status load(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  scene_wrench *wrench = &body->wrench;
  *wrench = (scene_wrench){{0}, {0}};
  scene_loads_sum(scene, body, wrench);
  if (scene->air > 0 && body->surface_count > 0)
    THRUM_TRY(scene_wind_add(scene, body, wrench, error));

  // what is read after this would have the slaves answer to a load that has not acted yet
  if (body->derived->condensed) {
    THRUM_TRY(scene_body_read(body, false, error));
    scene_condensed_load(body, scene->base_motion_count > 0);
  }
  return THRUM_OK;
}

/* A body that touches obstacles or is pulled makes its step here, since contact may take several
 * attempts; one that is near others has made it with its group. */
static thrum_status push(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  if (body->group >= 0)
    return body->stepped;
  if (scene_steps_alone(body))
    return scene_touch_step(scene, body, error);
  return thrum_state_set_force(body->derived->model, body->state, body->force, error);
}

/* Adds up the work and the losses of a step for a body. */
static void count_work(const thrum_scene *scene, scene_body *body) {
  const thrum_model *model = body->derived->model;
  body->q_known = body->p_known = false;
  if (scene_body_read(body, false, NULL) < 0)
    return;

  // work of the base apart from that of loads and gravity
  const double all = thrum_load_work(body->force, body->before, body->q, model->rank);
  const double base = scene->base_motion_count > 0
                          ? thrum_load_work(body->inertia, body->before, body->q, model->rank)
                          : 0;
  body->work_load += all - base;
  body->work_base += base;
  if (body->derived->condensed)
    scene_condensed_extrapolate(body);
  memcpy(body->before, body->q, (size_t)model->rank * sizeof *body->q);
}

/* The bodies of a model that go on, into scene->side; their number. */
static int32_t gather(thrum_scene *scene, const scene_model *model) {
  int32_t count = 0;
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    if (body->derived != model || body->status < 0 || body->group >= 0 || scene_steps_alone(body))
      continue;
    scene->side[count] = body->state;
    scene->side_body[count++] = n;
  }
  return count;
}

/* Keeps what came of one body's step; the first failure is the scene's. */
static void note(scene_body *body, thrum_status status, const thrum_error *detail,
                 thrum_status *scene_status, thrum_error *error) {
  if (status < 0) {
    body->status = status;
    if (*scene_status >= 0)
      *scene_status =
          thrum_error_set(error, status, "body '%s': %s", body->name,
                          detail->message[0] != 0 ? detail->message : thrum_status_text(status));
  } else if (status > 0 &&
             (*scene_status == THRUM_OK || (*scene_status > 0 && status < *scene_status))) {
    *scene_status = status;
  }
}

static void step_model(thrum_scene *scene, const scene_model *model, thrum_status *status,
                       thrum_error *error) {
  thrum_error detail = {0};
  const int32_t count = gather(scene, model);
  if (count == 1)
    scene->side_status[0] = thrum_step(model->model, scene->side[0], &detail);
  else if (count > 1)
    thrum_batch_step(model->model, scene->side, count, scene->side_status, scene->workspace,
                     scene->workspace_size, &detail);

  // what came of each body's step
  for (int32_t n = 0; n < count; n++) {
    scene_body *body = scene->bodies[scene->side_body[n]];
    if (scene->side_status[n] >= 0 && body->free)
      scene_free_step(body, &body->wrench, scene->dt);
    if (scene->side_status[n] >= 0)
      count_work(scene, body);
    note(body, scene->side_status[n], &detail, status, error);
  }
}

thrum_status thrum_scene_step(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;

  // loads first, then who is near whom
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    thrum_error detail = {0};
    if (body->status < 0)
      continue;
    const thrum_status loaded = load(scene, body, &detail);
    if (loaded < 0)
      note(body, loaded, &detail, &status, error);
  }
  scene_pairs_find(scene);

  // bodies with contact make their steps here, groups with their first body
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    thrum_error detail = {0};
    if (body->status < 0)
      continue;
    if (body->group == n)
      scene_pairs_step(scene, n, &detail);
    const thrum_status pushed = push(scene, body, &detail);
    const bool stepped = body->group >= 0 || scene_steps_alone(body);
    if (pushed >= 0 && stepped)
      count_work(scene, body);
    if (pushed < 0 || stepped)
      note(body, pushed, &detail, &status, error);
  }

  // the others step together with those of the same model
  for (const scene_model *model = scene->models; model != NULL; model = model->next)
    step_model(scene, model, &status, error);
  scene->steps++;
  scene_obstacles_move(scene);
  return status;
}
