/* Bodies that go on with other coordinates or another material.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_rebuild.h"

#include "scene/scene_actuation.h"
#include "scene/scene_contact.h"
#include "scene/scene_coupled.h"
#include "scene/scene_loads.h"
#include "scene/scene_model.h"
#include "scene/scene_pairs_room.h"
#include "scene/scene_shape.h"
#include "scene/scene_skin.h"
#include "scene/scene_state.h"

#include <math.h>
#include <string.h>

thrum_status scene_rebuild(thrum_scene *scene, scene_body *body, const thrum_state_def *def,
                           int64_t rank, bool condensed, double stiffness, thrum_error *error) {
  scene_model *derived = NULL;
  thrum_state *state = NULL;
  scene_touch *touch = NULL;
  scene_skin *skin = NULL;
  thrum_model_scaling by = body->derived->by;
  by.stiffness = stiffness;
  THRUM_TRY(scene_body_read(body, true, error));
  if (condensed) {
    THRUM_TRY(scene_actuation_check_followed(body, error));
    THRUM_TRY(scene_slopes_make(body, error));
  }
  THRUM_TRY(scene_model_take(scene, body->model, rank, condensed, &by, &derived, error));
  // coordinates that come are at rest, or go on from where they followed
  for (int64_t i = scene_shown(body); i < rank; i++)
    body->q[i] = body->p[i] = 0;

  thrum_rigid_frame frame = body->rigid_frame;
  thrum_status status =
      scene_state_make(scene, derived->model, def, body->q, body->p, &state, error);
  if (isfinite(def->plastic.yield) || thrum_state_plastic_strain(body->state) > 0)
    THRUM_THEN(status, thrum_state_take_plastic(state, body->state, error));
  if (body->inertia_work != NULL) {
    THRUM_THEN(status, scene_coupled_fit(body, derived, def, error));
    THRUM_THEN(status, thrum_floating_frame_settle(derived->inertia, body->q, body->p, &frame,
                                                   body->inertia_work, error));
  }
  THRUM_THEN(status, scene_make_room(scene, scene->body_count, error));
  THRUM_THEN(status, scene_skin_take(scene, body, derived, &skin, error));
  THRUM_THEN(status, scene_touch_make(scene, body, derived, state, &touch, error));

  // room for its touches, which snapshots know, comes last
  THRUM_THEN(status, scene_pairs_room(scene, body, skin, error));
  if (status < 0) {
    scene_touch_free(touch);
    scene_skin_drop(scene, skin);
    thrum_state_destroy(state);
    scene_model_drop(scene, derived);
    return status;
  }

  // nothing can fail any more: the new parts take the place of the old, and what the state has
  // counted is kept
  body->before_state = scene_body_counts(body);

  // slaves that begin to follow answer to the load that they stand under
  if (condensed && !body->derived->condensed) {
    scene_wrench wrench = {{0}, {0}};
    scene_loads_sum(scene, body, &wrench);
    memcpy(body->answered, body->force, (size_t)body->model->rank * sizeof *body->answered);
  }
  scene_skin_drop(scene, body->skin);
  scene_model_drop(scene, body->derived);
  thrum_state_destroy(body->state);
  scene_touch_free(body->touch);
  body->touch = touch;
  body->skin = skin;
  body->derived = derived;
  body->state = state;
  body->rigid_frame = frame;
  body->def = *def;
  memcpy(body->before, body->q, (size_t)rank * sizeof *body->q);
  memset(body->pulled, 0, (size_t)body->model->rank * sizeof *body->pulled);
  if (derived->condensed)
    body->q_known = body->p_known = false;
  scene->revision++;
  return THRUM_OK;
}

thrum_status scene_condense(thrum_scene *scene, int32_t number, int64_t masters,
                            thrum_error *error) {
  scene_body *body = scene->bodies[number];
  if (masters < 0 || masters >= body->model->rank)
    return thrum_error_set_field(error, "condense", THRUM_INVALID_ARGUMENT,
                                 " is %lld; the model can be condensed to 1 to %lld coordinates",
                                 (long long)masters, (long long)body->model->rank - 1);
  return scene_rebuild(scene, body, &body->def, masters > 0 ? masters : body->model->rank,
                       masters > 0, body->derived->by.stiffness, error);
}
