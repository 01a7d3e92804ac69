/* Free bodies as they are made: their mass, inertia and momentum.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_free_make.h"

#include "scene/scene_coupled.h"
#include "scene/scene_free_body.h"
#include "scene/scene_placement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/vec3.h"

/* L of an angular velocity: J w, where the inverse of J is known; rows of J are cross products of
 * columns of the inverse over its determinant. */
static void find_momentum(const double inverse[9], const double spin[3], double momentum[3]) {
  double products[3][3];
  for (int row = 0; row < 3; row++)
    thrum_cross3(inverse + 3 * ((row + 1) % 3), inverse + 3 * ((row + 2) % 3), products[row]);
  const double determinant =
      inverse[0] * products[0][0] + inverse[1] * products[0][1] + inverse[2] * products[0][2];
  for (int row = 0; row < 3; row++)
    momentum[row] =
        (products[row][0] * spin[0] + products[row][1] * spin[1] + products[row][2] * spin[2]) /
        determinant;
}

/* The rigid frame of the scaled body: lengths by s, the inertia by d s^5. */
static thrum_status make_rigid_frame(const thrum_scene_body_def *def, scene_body *body,
                                     thrum_error *error) {
  THRUM_TRY(thrum_rigid_frame_of(def->model, &body->rigid_frame, error));
  const double s = def->scale, inertia = def->density * (s * s * s * s * s);
  for (int axis = 0; axis < 3; axis++)
    body->rigid_frame.centre[axis] *= s;
  for (int n = 0; n < 9; n++)
    body->rigid_frame.inverse[n] /= inertia;

  // the spin turns the shape of the start where the two are coupled, and the body at rest elsewhere
  double spin[3], momentum[3];
  if (def->coupled) {
    THRUM_TRY(scene_coupled_fit(body, body->derived, &def->state, error));
    THRUM_TRY(scene_coupled_start(body, error));
    thrum_floating_frame_spin(&body->placement, def->spin, &body->rigid_frame);
    memcpy(body->start_momentum, body->rigid_frame.momentum, sizeof body->start_momentum);
  } else {
    scene_to_body(&body->placement, def->spin, spin);
    find_momentum(body->rigid_frame.inverse, spin, momentum);
    scene_to_world(&body->placement, momentum, body->start_momentum);
  }
  if (!thrum_all_finite(body->start_momentum, 3))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "with this spin, scale and density the angular momentum at the start is "
                           "beyond the range of finite numbers");
  return THRUM_OK;
}

thrum_status scene_free_make(const thrum_scene_body_def *def, scene_body *body,
                             thrum_error *error) {
  // a body may be free where its model has rigid modes
  if (!def->free && def->coupled)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a body that is held has no rotation to couple its shape to");
  if (!def->free)
    return THRUM_OK;
  if (def->model->rigid == NULL || !isnormal(def->model->rigid[0]))
    return thrum_error_set(error, THRUM_MISSING,
                           "a free body needs a model that nothing holds: precompute it without "
                           "--fix");

  if (!thrum_all_within(def->velocity, 3, THRUM_PLACE_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the velocity at the start is not within 1e30 m/s");
  THRUM_TRY(make_rigid_frame(def, body, error));

  // room for the loads of a body that turns: their parts along its axes, and what they do to the
  // whole
  const size_t r = (size_t)body->model->rank;
  body->parts = calloc(9 * r, sizeof *body->parts);
  body->moments = calloc(9, sizeof *body->moments);
  body->resultants = calloc(3, sizeof *body->resultants);
  if (!body->parts || !body->moments || !body->resultants)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a free body");

  // rigid modes begin with a shift along x, 1/sqrt(m) in each of its rows
  const double shift = def->model->rigid[0] * body->k;
  body->free = true;
  body->way.mass = 1 / (shift * shift);
  memcpy(body->start_velocity, def->velocity, sizeof body->start_velocity);
  scene_free_reset(body);
  return THRUM_OK;
}

void scene_free_reset(scene_body *body) {
  static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  memset(body->way.position, 0, sizeof body->way.position);
  memcpy(body->way.velocity, body->start_velocity, sizeof body->way.velocity);
  memcpy(body->rigid_frame.attitude, identity, sizeof identity);
  memcpy(body->rigid_frame.momentum, body->start_momentum, sizeof body->start_momentum);
  // it could be settled when the body was made
  if (body->inertia_work != NULL)
    scene_coupled_start(body, NULL);
  scene_free_place(body);
}
