/* Bodies whose stiff coordinates follow the others at rest (thrum/condensed_model.h).
 *
 * The stepped model of a scaled body has q = g q', so its slaves follow as y' = g y(x') and a load
 * f' on them moves them by f' / w'^2, w' the scaled frequency. Forces on the slaves act on the
 * masters through how they follow in the middle of the step to come, which is extrapolated. Contact
 * takes the body as it follows at the start of the step: rest positions and rows of U' such that
 * X' + J x is where the points are, with J = U'_x + U'_y dy/dx.
 *
 * What follows also answers a spring that pulls the body. The compliance of the point by the slaves
 * alone is in series with the spring (thrum_pull), so the masters feel one that is no stiffer than
 * without them, and the slaves are shown by their answer to its force.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_condensed.h"

#include "scene/scene_placement.h"
#include "scene/scene_shape.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/vec3.h"
#include "thrum/condensed_model.h"

/* vector (model's rank) in place: its force on the masters, with the slaves' part left as it is. */
static thrum_status reduce(const scene_body *body, double *vector, thrum_error *error) {
  const thrum_model *stepped = body->derived->model;
  const int64_t masters = stepped->rank, all = body->model->rank;
  double load[THRUM_RANK_MAX], reduced[THRUM_RANK_MAX];
  memcpy(load, vector, (size_t)all * sizeof *load);
  for (int64_t h = masters; h < all; h++)
    load[h] *= body->g;
  THRUM_TRY(thrum_state_reduce_load(stepped, body->state, load, reduced, error));
  memcpy(vector, reduced, (size_t)masters * sizeof *reduced);
  return THRUM_OK;
}

/* Are the body's load, and what its slaves answer to it, finite? */
static bool is_load_finite(const scene_body *body) {
  const thrum_model *shape = body->model;
  const double scale = scene_stiffening(body);
  bool finite = thrum_all_finite(body->force, shape->rank);
  for (int64_t h = body->derived->rank; h < shape->rank; h++)
    finite = finite && isfinite(body->force[h] / (scale * shape->omega2[h]));
  return finite;
}

thrum_status scene_condensed_load(const scene_body *body, bool base, thrum_error *error) {
  // the slaves would keep what the state refuses
  if (!is_load_finite(body))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the load holds a number that is not finite");
  memcpy(body->answered, body->force, (size_t)body->model->rank * sizeof *body->answered);
  if (body->touch == NULL)
    memset(body->pulled, 0, (size_t)body->model->rank * sizeof *body->pulled);
  THRUM_TRY(reduce(body, body->force, error));
  return base ? reduce(body, body->inertia, error) : THRUM_OK;
}

/* dy'_h/dx at the present x, slaves x masters, into the body's slopes. */
static void fill_slopes(const scene_body *body) {
  const thrum_model *stepped = body->derived->model;
  const int64_t masters = stepped->rank, all = body->model->rank;
  double unit[THRUM_RANK_MAX] = {0}, column[THRUM_RANK_MAX];
  for (int64_t i = 0; i < masters; i++) {
    unit[i] = 1;
    thrum_condensed_velocity(stepped, body->q, unit, column);
    unit[i] = 0;
    for (int64_t h = masters; h < all; h++)
      body->slopes[(h - masters) * masters + i] = body->g * column[h];
  }
}

thrum_status scene_condensed_touch(scene_body *body, thrum_error *error) {
  THRUM_TRY(scene_body_read(body, false, error));
  fill_slopes(body);
  scene_touch *touch = body->touch;
  const thrum_model *shape = body->model;
  const int64_t masters = body->derived->rank, all = shape->rank;

  // y' less its linear part, which the rows at x would show twice, and less its answer to pulls:
  // their springs have that in their stiffness
  double offset[THRUM_RANK_MAX];
  const double scale = scene_stiffening(body);
  for (int64_t h = masters; h < all; h++) {
    const double *slope = body->slopes + (h - masters) * masters;
    offset[h] = body->q[h] - body->pulled[h] / (scale * shape->omega2[h]);
    for (int64_t i = 0; i < masters; i++)
      offset[h] -= slope[i] * body->q[i];
  }

  // rows of U' and rest positions of the vertices that may touch
  for (int64_t n = 0; n < touch->count; n++) {
    const int64_t vertex = touch->vertices[n];
    if (vertex < 0)
      continue;
    for (int64_t axis = 0; axis < 3; axis++) {
      const double *row = shape->basis + (3 * vertex + axis) * all;
      double *to = touch->rows + (3 * n + axis) * masters;
      double rest = body->derived->by.length * shape->vertices[3 * vertex + axis];

      // masters move the vertex by themselves, and by the slaves that follow them
      for (int64_t i = 0; i < masters; i++)
        to[i] = body->k * row[i];
      for (int64_t h = masters; h < all; h++) {
        const double *slope = body->slopes + (h - masters) * masters, u = body->k * row[h];
        rest += u * offset[h];
        for (int64_t i = 0; i < masters; i++)
          to[i] += u * slope[i];
      }
      touch->rest[3 * n + axis] = rest;
    }
  }
  return THRUM_OK;
}

void scene_condensed_pull(const scene_body *body, int64_t vertex, thrum_pull *pull) {
  const thrum_model *shape = body->model;
  const int64_t masters = body->derived->rank, all = shape->rank;
  const double scale = scene_stiffening(body);
  const double *rows = shape->basis + 3 * vertex * all;
  memset(pull->give, 0, sizeof pull->give);
  for (int64_t h = masters; h < all; h++) {
    const double u[3] = {body->k * rows[h], body->k * rows[all + h], body->k * rows[2 * all + h]};
    double way[3];
    scene_to_world(&body->here, u, way);
    for (int n = 0; n < 9; n++)
      pull->give[n] += way[n / 3] * way[n % 3] / (scale * shape->omega2[h]);
  }
}
