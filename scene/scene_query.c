/* Positions, energies and parameters of the bodies of a scene. SPDX-License-Identifier: Apache-2.0
 */
#include "core/base/fp_contract.h"

#include "core/base/finite.h"
#include "scene/scene_access.h"
#include "scene/scene_shape.h"

#include <math.h>
#include <string.h>

/* A body and its q, and p if asked for. */
static thrum_status read_body(const thrum_scene *scene, int32_t number, bool p, scene_body **body,
                              thrum_error *error) {
  THRUM_TRY(scene_body_at(scene, number, body, error));
  return scene_body_read(*body, p, error);
}

/* Heap memory of a body, models apart. */
static size_t bytes_of(const scene_body *body) {
  const size_t r = (size_t)body->model->rank, loads = (size_t)body->load_count;
  const size_t whole = body->free ? loads * (9 * r + 12) : 0;
  return sizeof *body + thrum_state_bytes(body->state) +
         ((9 + loads) * r + whole) * sizeof(double) + 2 * loads * sizeof(thrum_load) +
         (size_t)body->surface_count * (4 * sizeof(double) + sizeof(int32_t)) +
         (size_t)body->touch_count * (sizeof(double) + sizeof(int32_t)) +
         (body->touch != NULL ? body->touch->bytes : 0);
}

thrum_status thrum_scene_body(const thrum_scene *scene, int32_t number, thrum_scene_body_info *info,
                              thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  const scene_counts counts = scene_body_counts(body);

  // the body as it was defined, and as the steps have made it
  *info = (thrum_scene_body_info){
      .name = body->name,
      .model = body->model,
      .stepped = body->derived->model,
      .rank = body->derived->rank,
      .condensed = body->derived->condensed,
      .shown = scene_shown(body),
      .scale = body->derived->by.length,
      .stiffness = body->derived->by.stiffness,
      .density = body->derived->by.density,
      .integrator = body->def.integrator,
      .damping_alpha = body->def.damping_alpha,
      .damping_beta = body->def.damping_beta,
      .status = body->status,
      .fallback_steps = counts.fallback_steps,
      .work_load = body->work_load,
      .work_base = body->work_base,
      .work_actuators = counts.work_actuators,
      .dissipated = counts.dissipated,
      .plastic_work = counts.plastic_work,
      .plastic_strain = thrum_state_plastic_strain(body->state),
      .point_stiffness = thrum_state_point_stiffness(body->state),
      .free = body->free,
      .mass = body->way.mass,
      .report = thrum_state_report_get(body->state),
      .bytes = bytes_of(body),
  };

  if (body->touch != NULL)
    info->contact = thrum_contact_report_get(body->touch->contact);
  memcpy(info->colour, body->colour, sizeof info->colour);
  return THRUM_OK;
}

thrum_status thrum_scene_body_stepped_modes(const thrum_scene *scene, int32_t number,
                                            thrum_stepped_mode *modes, thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(scene_body_at(scene, number, &body, error));
  return thrum_state_stepped_modes(body->derived->model, body->state, modes, error);
}

thrum_status thrum_scene_body_energies(thrum_scene *scene, int32_t number,
                                       thrum_scene_energies *energies, thrum_error *error) {
  scene_body *body = NULL;
  thrum_energies of_state;
  THRUM_TRY(read_body(scene, number, false, &body, error));
  THRUM_TRY(thrum_state_energies(body->derived->model, body->state, &of_state, error));

  // the work of the body's weight against its deformation
  double work = 0;
  for (int64_t i = 0; i < scene_shown(body); i++)
    work += body->directions[i] * body->q[i];

  // a free body moves as a whole as well
  const thrum_translation *way = &body->way;
  double kinetic = of_state.kinetic, stored = 0;
  for (int axis = 0; axis < 3 && body->free; axis++) {
    kinetic += 0.5 * way->mass * way->velocity[axis] * way->velocity[axis];
    work += way->mass * scene->gravity[axis] * way->position[axis];
  }
  if (body->free)
    kinetic += thrum_rigid_frame_energy(&body->rigid_frame, &body->placement);
  if (body->touch != NULL)
    stored = thrum_contact_report_get(body->touch->contact).stored;

  if (!isfinite(kinetic) || !isfinite(work) || !isfinite(kinetic + of_state.potential - work))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "body '%s': its energy is beyond the range of finite numbers",
                           body->name);

  *energies = (thrum_scene_energies){.kinetic = kinetic,
                                     .potential = of_state.potential,
                                     .gravity = -work,
                                     .contact = stored,
                                     .total = kinetic + of_state.potential + stored - work,
                                     .high = of_state.high};
  return THRUM_OK;
}

thrum_status thrum_scene_body_get(thrum_scene *scene, int32_t number, double *q, double *p,
                                  thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(read_body(scene, number, p != NULL, &body, error));
  const size_t bytes = (size_t)scene_shown(body) * sizeof(double);
  if (q != NULL)
    memcpy(q, body->q, bytes);
  if (p != NULL)
    memcpy(p, body->p, bytes);
  return THRUM_OK;
}

/* q of the model as it was given: g q' on the coordinates in use, zero on the others. */
static void shape(const scene_body *body, double *q) {
  for (int64_t i = 0; i < body->model->rank; i++)
    q[i] = i < scene_shown(body) ? body->g * body->q[i] : 0.0;
}

thrum_status thrum_scene_body_shape(thrum_scene *scene, int32_t number, double *q,
                                    thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(read_body(scene, number, false, &body, error));
  shape(body, q);
  return THRUM_OK;
}

thrum_status thrum_scene_body_positions(thrum_scene *scene, int32_t number,
                                        const thrum_surface *surface, float *out, int64_t stride,
                                        thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(read_body(scene, number, false, &body, error));
  THRUM_TRY(thrum_surface_fits(surface, body->model, error));

  // body->force is made anew in every step
  shape(body, body->force);
  return thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, body->force, 0,
                                 thrum_surface_vertex_count(surface), out, stride, error);
}

thrum_status thrum_scene_body_vertex(thrum_scene *scene, int32_t number, int64_t vertex,
                                     double position[3], double velocity[3], thrum_error *error) {
  scene_body *body = NULL;
  THRUM_TRY(read_body(scene, number, velocity != NULL, &body, error));
  THRUM_TRY(scene_vertex_check(body, vertex, error));
  const thrum_model *model = body->model;
  double x[3], v[3] = {0};
  scene_point(body, model->vertices + 3 * vertex, model->basis + 3 * vertex * model->rank, x,
              velocity != NULL ? v : NULL);

  // a body that was stopped may have been on its way beyond all numbers
  if (!thrum_all_finite(x, 3) || !thrum_all_finite(v, 3))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "body '%s': a vertex is beyond the range of finite numbers, or as fast",
                           body->name);
  memcpy(position, x, sizeof x);
  if (velocity != NULL)
    memcpy(velocity, v, sizeof v);
  return THRUM_OK;
}

void thrum_scene_body_matrix(const thrum_scene *scene, int32_t number, double matrix[16]) {
  scene_body *body = NULL;
  memset(matrix, 0, 16 * sizeof *matrix);
  matrix[15] = 1;
  if (scene_body_at(scene, number, &body, NULL) < 0)
    return;
  for (int column = 0; column < 3; column++) {
    for (int row = 0; row < 3; row++)
      matrix[4 * column + row] = body->derived->by.length * body->here.axes[3 * row + column];
    matrix[12 + column] = body->here.origin[column];
  }
}
