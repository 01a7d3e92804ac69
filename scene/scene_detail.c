/* Level of detail: a body that is far from the eye, or still, steps fewer coordinates, the others
 * following (thrum_scene_set_condensed), and steps all that it had when it is near or moves again.
 *
 * Coordinates that begin to follow jump from y to y(x). The jump of a vertex is at most
 * k sum_h |y_h - y_h(x)| max |U_h|, r operations; where that bound is too large, the jump itself is
 * looked at. The speed of the deformation is bounded in the same way, by the velocities and by how
 * far the shape has come since the last update, which sees what answers a load at rest as well.
 * scene_still.c looks at what is about to act on the body.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_detail.h"

#include "scene/scene_access.h"
#include "scene/scene_actuation.h"
#include "scene/scene_loads.h"
#include "scene/scene_model.h"
#include "scene/scene_placement.h"
#include "scene/scene_rebuild.h"
#include "scene/scene_shape.h"
#include "scene/scene_skin.h"
#include "scene/scene_still.h"

#include "core/base/finite.h"
#include "core/base/pi.h"
#include "core/base/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/condensed_model.h"

#define NEAR_AGAIN 0.9 /* of `beyond`: what comes no closer stays far, so that nothing flickers */
#define BOUND_OVER 8.0 /* a bound this many times too large is not worth a look at the vertices */
#define AHEAD 2        /* times the steps since the last update are looked ahead */
#define AHEAD_MOST 256 /* steps */

/* --- setting ---------------------------------------------------------------------------------- */

void scene_detail_free(thrum_scene *scene, scene_body *body) {
  scene_detail *detail = body->detail;
  if (detail == NULL)
    return;
  scene_model_drop(scene, detail->followed);
  scene_model_drop(scene, detail->whole);
  free(detail->peaks);
  free(detail);
  body->detail = NULL;
}

void scene_detail_restart(scene_body *body) {
  if (body->detail == NULL)
    return;
  body->detail->seen.last_time = -1;
  body->detail->seen.quiet_since = 0;
  body->detail->seen.last_steps = 0;
  body->detail->seen.far = 0;
}

static thrum_status check(const scene_body *body, const thrum_scene_detail *def,
                          thrum_error *error) {
  if (body->model->basis == NULL || body->model->vertices == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "a level of detail needs a model with a basis and its vertices");
  if (body->inertia_work != NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "body '%s' is coupled to its rotation, which takes all of its "
                           "coordinates: it has no level of detail",
                           body->name);
  THRUM_TRY(scene_actuation_check_followed(body, error));
  if (def->masters < 1 || def->masters >= body->derived->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a level of detail of %lld coordinates is asked for; the body steps "
                           "%lld, so 1 to %lld would be fewer",
                           (long long)def->masters, (long long)body->derived->rank,
                           (long long)body->derived->rank - 1);
  if (!(def->jump > 0) || !isfinite(def->jump))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the jump is %g m; it must be above 0",
                           def->jump);
  if (!(def->beyond >= 0) || !(def->still >= 0) || !isfinite(def->beyond + def->still))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the distance is %g m and the speed %g m/s; neither may be negative",
                           def->beyond, def->still);
  return THRUM_OK;
}

/* The longest row of each basis vector, and the box around the vertices. */
static void measure(const thrum_model *model, scene_detail *detail) {
  // a model without vertices has its middle at the origin
  double low[3] = {0}, high[3] = {0};
  if (model->vertex_count > 0)
    thrum_box3(model->vertices, model->vertex_count, low, high);

  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *rows = model->basis + 3 * v * model->rank;
    for (int64_t i = 0; i < model->rank; i++) {
      const double x = rows[i], y = rows[model->rank + i], z = rows[2 * model->rank + i];
      detail->peaks[i] = fmax(detail->peaks[i], sqrt(x * x + y * y + z * z));
    }
  }
  for (int axis = 0; axis < 3; axis++) {
    detail->middle[axis] = 0.5 * (low[axis] + high[axis]);
    detail->half[axis] = 0.5 * (high[axis] - low[axis]);
  }
}

/* Keeps the models of both levels, as the body is scaled now, so that a change makes none. */
static thrum_status hold(thrum_scene *scene, const scene_body *body, scene_detail *detail,
                         thrum_error *error) {
  const thrum_model_scaling *by = &body->derived->by;
  if (detail->followed != NULL && detail->followed->by.stiffness == by->stiffness)
    return THRUM_OK;
  scene_model *followed = NULL, *whole = NULL;
  const int64_t near = detail->near > 0 ? detail->near : body->model->rank;
  THRUM_TRY(scene_model_take(scene, body->model, detail->def.masters, true, by, &followed, error));
  const thrum_status status =
      scene_model_take(scene, body->model, near, detail->near > 0, by, &whole, error);
  if (status < 0) {
    scene_model_drop(scene, followed);
    return status;
  }
  scene_model_drop(scene, detail->followed);
  scene_model_drop(scene, detail->whole);
  detail->followed = followed;
  detail->whole = whole;
  return THRUM_OK;
}

thrum_status thrum_scene_set_detail(thrum_scene *scene, int32_t number,
                                    const thrum_scene_detail *def, thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  if (def == NULL) {
    scene->revision += body->detail != NULL;
    scene_detail_free(scene, body);
    return THRUM_OK;
  }
  THRUM_TRY(check(body, def, error));
  if (body->tied > 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "body '%s' is or was linked, and cannot have a level of detail",
                           body->name);

  // the new one is whole before the old one goes
  scene_detail *detail = calloc(1, sizeof *detail);
  double *peaks = calloc(2 * (size_t)body->model->rank, sizeof *peaks);
  if (detail == NULL || peaks == NULL) {
    free(detail);
    free(peaks);
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a level of detail");
  }
  *detail = (scene_detail){.def = *def,
                           .near = body->derived->condensed ? body->derived->rank : 0,
                           .peaks = peaks,
                           .last = peaks + body->model->rank,
                           .seen = {.last_time = -1,
                                    .quiet_since = thrum_scene_time(scene),
                                    .last_steps = scene->steps,
                                    .stirred = scene->stirred,
                                    .report = {.set = 1}}};
  measure(body->model, detail);
  const thrum_status status = hold(scene, body, detail, error);
  if (status < 0) {
    free(peaks);
    free(detail);
    return status;
  }
  scene_detail_free(scene, body);
  body->detail = detail;
  scene->revision++;
  return THRUM_OK;
}

thrum_status thrum_scene_set_eye(thrum_scene *scene, const double eye[3], thrum_error *error) {
  if (!thrum_all_within(eye, 3, THRUM_PLACE_MAX))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the place of the eye is not within 1e30 m");
  memcpy(scene->eye, eye, sizeof scene->eye);
  return THRUM_OK;
}

thrum_status thrum_scene_body_detail(const thrum_scene *scene, int32_t number,
                                     thrum_scene_detail_report *report, thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  *report = body->detail != NULL ? body->detail->seen.report : (thrum_scene_detail_report){0};

  // the steps since the last update count as well
  if (report->reduced)
    report->reduced_steps += scene->steps - body->detail->seen.last_steps;
  return THRUM_OK;
}

/* --- looking ---------------------------------------------------------------------------------- */

/* The same, of the vertex that moves furthest. */
static double largest(const scene_body *body, const double *q, const double *other) {
  const thrum_model *model = body->model;
  double most = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double *row = model->basis + 3 * v * model->rank;
    double square = 0;
    for (int axis = 0; axis < 3; axis++, row += model->rank) {
      double sum = 0;
      for (int64_t i = 0; i < model->rank; i++)
        sum += row[i] * (q[i] - other[i]);
      square += sum * sum;
    }
    most = fmax(most, square);
  }
  return body->k * sqrt(most);
}

/* The shape that the body would have with the model `to`, from its present coordinates q. */
static void follow(const thrum_scene *scene, scene_body *body, const scene_model *to,
                   const double *q, double *shape) {
  const int64_t all = body->model->rank;
  memcpy(shape, q, (size_t)all * sizeof *q);
  if (!to->condensed)
    return;

  // the load that it stands under, as rebuild_as in scene_change.c finds it
  const double *load = body->answered;
  if (!body->derived->condensed) {
    scene_wrench wrench = {{0}, {0}};
    scene_loads_sum(scene, body, &wrench);
    load = body->force;
  }

  // as scene_condensed_read: what follows, and its answer to that load
  const double scale = to->by.stiffness / (to->by.length * to->by.length * to->by.density);
  thrum_condensed_shape(to->model, q, NULL, shape);
  for (int64_t h = to->rank; h < all; h++)
    shape[h] = body->g * shape[h] + (load[h] + body->pulled[h]) / (scale * body->model->omega2[h]);
}

/* Fills distance and speed of the report; whether the body is to step the fewer coordinates. The
 * last update was after `before` steps. */
static bool look(const thrum_scene *scene, scene_body *body, int64_t before, const double *q) {
  scene_detail *detail = body->detail;
  const thrum_scene_detail *def = &detail->def;
  const double now = thrum_scene_time(scene);

  // the distance is that from the eye to the middle of the body
  const double rest[3] = {body->derived->by.length * detail->middle[0],
                          body->derived->by.length * detail->middle[1],
                          body->derived->by.length * detail->middle[2]};
  double middle[3], square = 0;
  scene_to_world(&body->here, rest, middle);
  for (int axis = 0; axis < 3; axis++) {
    const double away = middle[axis] + body->here.origin[axis] - scene->eye[axis];
    square += away * away;
  }
  detail->seen.report.distance = sqrt(square);
  detail->seen.far = def->beyond > 0 && detail->seen.report.distance >
                                            (detail->seen.far ? NEAR_AGAIN : 1) * def->beyond;

  // velocities vanish where a vibration turns, and what answers a load at rest has none
  double speed = scene_bound(body, 0, body->p, NULL);
  speed += scene_rigid_speed(body);
  if (detail->seen.last_time >= 0 && now > detail->seen.last_time)
    speed = fmax(speed, scene_bound(body, 0, q, detail->last) / (now - detail->seen.last_time));
  detail->seen.report.speed = speed;

  // what is about to act wakes the body before it does, as does what a call has changed
  const int64_t since = scene->steps - before;
  const int64_t ahead = since < AHEAD_MOST / AHEAD ? AHEAD * (since > 0 ? since : 1) : AHEAD_MOST;
  if (!(speed < def->still) || detail->seen.stirred != scene->stirred ||
      !(scene_coming_speed(scene, body, q, ahead) < def->still))
    detail->seen.quiet_since = now;
  detail->seen.stirred = scene->stirred;
  detail->seen.last_time = now;
  memcpy(detail->last, q, (size_t)body->model->rank * sizeof *q);

  // a period of quiet, and a look before it
  const double omega2 = detail->whole->model->omega2[0];
  const bool still =
      def->still > 0 && now - detail->seen.quiet_since >= THRUM_TWO_PI / sqrt(omega2);
  return detail->seen.far || still;
}

/* The present energy of the body without contact, which a change leaves as it is; 0 where there is
 * none that is finite. */
static double energy_of(thrum_scene *scene, int32_t number) {
  thrum_scene_energies energies;
  if (thrum_scene_body_energies(scene, number, &energies, NULL) < 0)
    return 0;
  return energies.kinetic + energies.potential;
}

thrum_status scene_detail_wake(thrum_scene *scene, int32_t number, thrum_error *error) {
  scene_body *body = scene->bodies[number];
  if (body->detail == NULL || body->derived == body->detail->whole)
    return THRUM_OK;
  scene_seen *seen = &body->detail->seen;
  THRUM_TRY(scene_condense(scene, number, body->detail->near, error));
  seen->report.reduced_steps += seen->report.reduced ? scene->steps - seen->last_steps : 0;
  seen->last_steps = scene->steps;
  seen->report.reduced = 0;
  seen->report.changes++;
  return THRUM_OK;
}

/* Changes the number of coordinates, where no vertex jumps further than it may. */
static thrum_status change(thrum_scene *scene, int32_t number, const scene_model *to,
                           const double *q, thrum_error *error) {
  scene_body *body = scene->bodies[number];
  scene_detail *detail = body->detail;
  double shape[THRUM_RANK_MAX];
  follow(scene, body, to, q, shape);
  const double most = scene_bound(body, 0, q, shape);
  const bool allowed = most <= detail->def.jump || (most <= BOUND_OVER * detail->def.jump &&
                                                    largest(body, q, shape) <= detail->def.jump);

  // what may not follow yet is stepped whole when it comes back, which never jumps
  int64_t masters = to->condensed ? to->rank : 0;
  const bool back = to == detail->whole;
  if (!allowed && (!back || !body->derived->condensed)) {
    detail->seen.report.put_off++;
    return THRUM_OK;
  }
  if (!allowed)
    masters = 0;

  const double before = energy_of(scene, number);
  THRUM_TRY(scene_condense(scene, number, masters, error));
  THRUM_TRY(scene_body_read(body, false, error));
  detail->seen.report.changes++;
  detail->seen.report.largest_jump =
      fmax(detail->seen.report.largest_jump, largest(body, body->q, q));
  detail->seen.report.energy += energy_of(scene, number) - before;
  detail->seen.report.reduced = !back;
  memcpy(detail->last, body->q, (size_t)body->model->rank * sizeof *q);
  return THRUM_OK;
}

static thrum_status look_and_change(thrum_scene *scene, int32_t number, thrum_error *error) {
  scene_body *body = scene->bodies[number];
  scene_detail *detail = body->detail;
  double q[THRUM_RANK_MAX];
  THRUM_TRY(hold(scene, body, detail, error));
  THRUM_TRY(scene_body_read(body, true, error));
  memcpy(q, body->q, (size_t)body->model->rank * sizeof *q);
  const int64_t before = detail->seen.last_steps;
  if (detail->seen.report.reduced)
    detail->seen.report.reduced_steps += scene->steps - before;
  detail->seen.last_steps = scene->steps;

  // what no longer vibrates touches no other body (scene_pairs.c), so what may touch is left whole
  const bool touches = body->triangle_count > 0 && scene_collides(scene, body, detail->whole);
  const scene_model *to =
      look(scene, body, before, q) && !touches ? detail->followed : detail->whole;
  return to == body->derived ? THRUM_OK : change(scene, number, to, q, error);
}

/* The same, or all that was seen of the body stays as it was. */
static thrum_status update(thrum_scene *scene, int32_t number, thrum_error *error) {
  const scene_body *body = scene->bodies[number];
  const size_t bytes = (size_t)body->model->rank * sizeof(double);
  const scene_seen seen = body->detail->seen;
  double last[THRUM_RANK_MAX];
  memcpy(last, body->detail->last, bytes);
  const thrum_status status = look_and_change(scene, number, error);
  if (status < 0) {
    body->detail->seen = seen;
    memcpy(body->detail->last, last, bytes);
  }
  return status;
}

thrum_status thrum_scene_update_detail(thrum_scene *scene, thrum_error *error) {
  thrum_status status = THRUM_OK;
  for (int32_t n = 0; n < scene->body_count && status >= 0; n++)
    if (scene->bodies[n]->detail != NULL && scene->bodies[n]->status >= 0)
      status = update(scene, n, error);
  return status;
}
