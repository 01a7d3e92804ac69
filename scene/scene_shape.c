/* The present coordinates of a body, with those that follow at rest (thrum/condensed_model.h), and
 * where its points are. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_shape.h"

#include "scene/scene_actuation.h"
#include "scene/scene_free_body.h"
#include "scene/scene_placement.h"

#include <string.h>

#include "core/base/finite.h"
#include "thrum/condensed_model.h"

double scene_stiffening(const scene_body *body) {
  const thrum_model_scaling *by = &body->derived->by;
  return by->stiffness / (by->length * by->length * by->density);
}

static thrum_status check_slaves(const scene_body *body, const double *values, thrum_error *error) {
  const int64_t masters = body->derived->rank;
  if (thrum_all_finite(values + masters, body->model->rank - masters))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_NOT_FINITE,
                         "coordinates that follow the others at rest are beyond the range of "
                         "finite numbers");
}

/* The slaves of body->q, and of body->p if `p`, from the masters there. THRUM_NOT_FINITE where one
 * overflows. */
static thrum_status read_slaves(scene_body *body, bool p, thrum_error *error) {
  const thrum_model *stepped = body->derived->model, *shape = body->model;
  const int64_t masters = stepped->rank;
  double x[THRUM_RANK_MAX], v[THRUM_RANK_MAX];
  memcpy(x, body->q, (size_t)masters * sizeof *x);

  // the slaves at rest, and their static answer to the load of the last step
  const double scale = scene_stiffening(body);
  thrum_condensed_shape(stepped, x, NULL, body->q);
  for (int64_t h = masters; h < shape->rank; h++)
    body->q[h] = body->g * body->q[h] + body->answered[h] / (scale * shape->omega2[h]) +
                 body->pulled[h] / (scale * shape->omega2[h]);

  THRUM_TRY(check_slaves(body, body->q, error));

  if (!p)
    return THRUM_OK;
  memcpy(v, body->p, (size_t)masters * sizeof *v);
  thrum_condensed_velocity(stepped, x, v, body->p);
  for (int64_t h = masters; h < shape->rank; h++)
    body->p[h] *= body->g;
  return check_slaves(body, body->p, error);
}

thrum_status scene_body_read(scene_body *body, bool p, thrum_error *error) {
  if (body->q_known && (!p || body->p_known))
    return THRUM_OK;
  THRUM_TRY(thrum_state_get(body->derived->model, body->state, body->q, p ? body->p : NULL, error));
  if (body->derived->condensed)
    THRUM_TRY(read_slaves(body, p, error));
  body->q_known = true;
  body->p_known = body->p_known || p;
  return THRUM_OK;
}

scene_counts scene_body_counts(const scene_body *body) {
  const thrum_state_report now = thrum_state_report_get(body->state);
  scene_counts counts = body->before_state;
  counts.fallback_steps += now.newton_steps + now.energy_steps + now.substep_steps;
  counts.dissipated += now.dissipated;
  counts.plastic_work += now.plastic_work;
  counts.work_actuators += scene_actuation_work(body);
  return counts;
}

void scene_point(const scene_body *body, const double rest[3], const double *rows,
                 double position[3], double velocity[3]) {
  const int64_t r = body->model->rank, rank = scene_shown(body);
  double x[3], v[3];

  // place and velocity in the frame of the body
  for (int axis = 0; axis < 3; axis++) {
    double u = 0, speed = 0;
    for (int64_t i = 0; i < rank; i++) {
      u += rows[axis * r + i] * body->q[i];
      speed += velocity ? rows[axis * r + i] * body->p[i] : 0.0;
    }
    x[axis] = body->derived->by.length * rest[axis] + body->k * u;
    v[axis] = body->k * speed;
  }

  scene_to_world(&body->here, x, position);
  for (int axis = 0; axis < 3; axis++)
    position[axis] += body->here.origin[axis];
  if (velocity == NULL)
    return;

  // a free body's point moves with the whole of it too
  scene_to_world(&body->here, v, velocity);
  if (!body->free)
    return;
  double centre[3], whole[3];
  scene_free_centre(body, centre);
  const double arm[3] = {position[0] - centre[0], position[1] - centre[1], position[2] - centre[2]};
  scene_free_velocity(body, arm, whole);
  for (int axis = 0; axis < 3; axis++)
    velocity[axis] += whole[axis];
}
