/* One step of a scene: loads, then bodies of one model side by side (thrum/batch.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_actuation.h"
#include "scene/scene_condensed.h"
#include "scene/scene_contact.h"
#include "scene/scene_coupled.h"
#include "scene/scene_free_body.h"
#include "scene/scene_loads.h"
#include "scene/scene_obstacle.h"
#include "scene/scene_pairs.h"
#include "scene/scene_shape.h"
#include "scene/scene_state.h"
#include "scene/scene_wind.h"

#include <math.h>
#include <string.h>

#include "thrum/external_load.h"

/* The load of the step to come. */
static thrum_status load(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  scene_wrench *wrench = &body->wrench;
  *wrench = (scene_wrench){{0}, {0}};
  if (body->inertia_work != NULL)
    THRUM_TRY(scene_body_read(body, false, error));
  THRUM_TRY(scene_actuation_set(scene, body, error));
  scene_loads_sum(scene, body, wrench);
  if (scene->air > 0 && body->surface_count > 0)
    THRUM_TRY(scene_wind_add(scene, body, wrench, error));

  // what is read after this would have the slaves answer to a load that has not acted yet
  if (body->derived->condensed) {
    THRUM_TRY(scene_body_read(body, false, error));
    return scene_condensed_load(body, scene->base_motion_count > 0, error);
  }
  return THRUM_OK;
}

/* Does `task` for each index below `count`, by the scene's workers. */
static void for_all(thrum_scene *scene, int32_t count, void (*task)(void *, int32_t, int32_t)) {
  if (scene->run != NULL && count > 1) {
    scene->run(scene->run_context, count, task, scene);
    return;
  }
  for (int32_t n = 0; n < count; n++)
    task(scene, n, 0);
}

/* The load of body n, and what came of it. */
static void load_task(void *of, int32_t n, int32_t worker) {
  thrum_scene *scene = of;
  scene_body *body = scene->bodies[n];
  scene->side_error[n] = (thrum_error){0};
  scene_lend(scene, body, worker);
  body->stepped = body->status < 0 ? THRUM_OK : load(scene, body, scene->side_error + n);
}

/* Adds up the work of a step on a body. THRUM_NOT_FINITE where it, or what follows the coordinates
 * that were stepped, is beyond the finite numbers: what was added up before stays. */
static thrum_status count_work(const thrum_scene *scene, scene_body *body, thrum_error *error) {
  const thrum_model *model = body->derived->model;
  body->q_known = body->p_known = false;
  THRUM_TRY(scene_body_read(body, false, error));

  // work of the base apart from that of loads and gravity
  const double all = thrum_load_work(body->force, body->before, body->q, model->rank);
  const double base = scene->base_motion_count > 0
                          ? thrum_load_work(body->inertia, body->before, body->q, model->rank)
                          : 0;
  if (!isfinite(body->work_load + (all - base)) || !isfinite(body->work_base + base))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the work of its loads is beyond the range of finite numbers");
  body->work_load += all - base;
  body->work_base += base;
  memcpy(body->before, body->q, (size_t)model->rank * sizeof *body->q);
  return THRUM_OK;
}

/* The same after a step with this status; returns what came of both. */
static thrum_status count_step(const thrum_scene *scene, scene_body *body, thrum_status stepped,
                               thrum_error *error) {
  if (stepped < 0)
    return stepped;
  const thrum_status counted = count_work(scene, body, error);
  return counted < 0 ? counted : stepped;
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

/* Does the body make its step by itself or in a group, and not side by side with others? */
static bool is_apart(const scene_body *body) {
  return body->group >= 0 || body->inertia_work != NULL || scene_steps_alone(body);
}

/* Steps a group of bodies that are near each other. */
static void group_task(thrum_scene *scene, int32_t worker) {
  thrum_error detail = {0};
  const int32_t first = scene_pairs_step(scene, worker, &detail);
  for (int32_t n = first; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    if (body->group != first)
      continue;
    scene->side_error[n] = detail;
    body->stepped = count_step(scene, body, body->stepped, scene->side_error + n);
  }
}

/* The first tasks step groups, one each; those behind them step body after body where it touches
 * obstacles or is pulled, since contact may take several attempts, or where its rotation is coupled
 * to its shape, and hand its load to its state otherwise. */
static void contact_task(void *of, int32_t index, int32_t worker) {
  thrum_scene *scene = of;
  const int32_t number = index - scene->pairs.group_count;
  if (number < 0) {
    group_task(scene, worker);
    return;
  }

  // bodies of a group are stepped with it
  scene_body *body = scene->bodies[number];
  thrum_error *error = scene->side_error + number;
  if (body->status < 0 || body->group >= 0)
    return;

  *error = (thrum_error){0};
  if (!is_apart(body)) {
    body->stepped = thrum_state_set_force(body->derived->model, body->state, body->force, error);
    return;
  }

  // the scratch is the worker's
  scene_lend(scene, body, worker);
  const thrum_status stepped = scene_steps_alone(body) ? scene_touch_step(scene, body, error)
                                                       : scene_coupled_step(body, error);
  body->stepped = count_step(scene, body, stepped, error);
}

/* The bodies of a model that go on, into scene->side from `from` on; their number. */
static int32_t gather(thrum_scene *scene, const scene_model *model, int32_t from) {
  int32_t count = 0;
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    if (body->derived != model || body->status < 0 || is_apart(body))
      continue;
    scene->side[from + count] = body->state;
    scene->side_body[from + count++] = n;
  }
  return count;
}

/* Chunks of all bodies that step side by side, as many a model as there are workers. */
static int32_t make_chunks(thrum_scene *scene) {
  int32_t chunks = 0, from = 0;
  for (const scene_model *model = scene->models; model != NULL; model = model->next) {
    const int32_t count = gather(scene, model, from), end = from + count;
    const int32_t share = (count + scene->workers - 1) / scene->workers;
    for (; from < end; from += share)
      scene->chunks[chunks++] = (scene_chunk){
          .model = model, .from = from, .count = end - from < share ? end - from : share};
    from = end;
  }
  return chunks;
}

static void chunk_task(void *of, int32_t index, int32_t worker) {
  thrum_scene *scene = of;
  scene_chunk *chunk = scene->chunks + index;
  const thrum_model *model = chunk->model->model;
  thrum_state *const *states = scene->side + chunk->from;
  thrum_status *statuses = scene->side_status + chunk->from;
  const int32_t *bodies = scene->side_body + chunk->from;
  for (int32_t n = 0; n < chunk->count; n++)
    scene_lend(scene, scene->bodies[bodies[n]], worker);
  if (chunk->count == 1)
    statuses[0] = thrum_step(model, states[0], &chunk->error);
  else
    thrum_batch_step(model, states, chunk->count, statuses, scene_workspace(scene, worker),
                     scene->workspace_size, &chunk->error);

  // what came of each body's step
  for (int32_t n = 0; n < chunk->count; n++) {
    scene_body *body = scene->bodies[bodies[n]];
    thrum_error *error = scene->side_error + bodies[n];
    thrum_status moved = THRUM_OK;
    *error = chunk->error;
    if (statuses[n] >= 0 && body->free)
      moved = scene_free_step(body, &body->wrench, scene->dt, error);
    statuses[n] = count_step(scene, body, moved < 0 ? moved : statuses[n], error);
  }
}

thrum_status thrum_scene_step(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;

  // loads first, then who is near whom
  for_all(scene, scene->body_count, load_task);
  for (int32_t n = 0; n < scene->body_count; n++)
    if (scene->bodies[n]->stepped < 0)
      note(scene->bodies[n], scene->bodies[n]->stepped, scene->side_error + n, &status, error);
  scene_pairs_find(scene);

  // bodies with contact make their steps here
  for_all(scene, scene->pairs.group_count + scene->body_count, contact_task);
  scene_pairs_gather(scene);
  for (int32_t n = 0; n < scene->body_count; n++) {
    scene_body *body = scene->bodies[n];
    if (body->status >= 0 && (body->stepped < 0 || is_apart(body)))
      note(body, body->stepped, scene->side_error + n, &status, error);
  }

  // the others step together with those of the same model
  const int32_t chunks = make_chunks(scene);
  for_all(scene, chunks, chunk_task);
  for (int32_t n = 0; n < chunks; n++)
    for (int32_t m = scene->chunks[n].from; m < scene->chunks[n].from + scene->chunks[n].count; m++)
      note(scene->bodies[scene->side_body[m]], scene->side_status[m],
           scene->side_error + scene->side_body[m], &status, error);
  scene->steps++;
  scene_obstacles_move(scene);
  return status;
}
