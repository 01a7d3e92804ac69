/* The stepper of a scene: all bodies of a scene file in the world.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_stepper.h"

#include <math.h>

#include "driver/record/run_placement.h"
#include "driver/scene/scene_run_account.h"
#include "driver/scene/scene_run_contact.h"
#include "driver/scene/scene_run_couple.h"
#include "driver/scene/scene_run_crossed.h"
#include "driver/scene/scene_run_judge.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_output.h"

#define STEPS_BETWEEN_LOOKS 1024
#define STEPS_BETWEEN_DETAIL 8

/* How many coordinates the bodies step, from where the eye is now. */
static thrum_status update_detail(scene_run *run, int64_t step, thrum_error *error) {
  double eye[3];
  for (int axis = 0; axis < 3; axis++)
    eye[axis] = run->spec.eye[axis] + (double)step * run->dt * run->spec.eye_velocity[axis];
  THRUM_TRY(thrum_scene_set_eye(run->scene, eye, error));
  return thrum_scene_update_detail(run->scene, error);
}

/* Is the body stepped as its check has it? One that steps fewer coordinates for a while is not. */
static bool is_checked(const scene_run *run, int32_t n) {
  thrum_scene_body_info info;
  if (run->bodies[n].check.model == NULL)
    return false;
  thrum_scene_body(run->scene, n, &info, NULL);
  return info.stepped == run->bodies[n].check.model;
}

/* Adds what the slaves of a condensed body would have done in the step that was made. */
static thrum_status look_at_vibration(const scene_run *run, int32_t n, thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  const thrum_model *stepped = body->check.model;
  double q[THRUM_RANK_MAX], load[THRUM_RANK_MAX], contact[THRUM_RANK_MAX];
  THRUM_TRY(thrum_scene_body_shape(run->scene, n, q, error));
  THRUM_TRY(thrum_scene_body_contact_load(run->scene, n, contact, error));

  // the shape has the slaves' answer to the loads
  thrum_condensed_shape(stepped, q, NULL, load);
  for (int64_t h = stepped->rank; h < body->model->rank; h++)
    load[h] = body->model->omega2[h] * (q[h] - load[h]);

  // the check takes times of the model as it is in the file
  condensed_check_vibrate(&body->check, load, contact, body->pace * run->dt, q);
  return THRUM_OK;
}

static thrum_status advance(void *stepper, int64_t step, thrum_error *error) {
  scene_run *run = stepper;
  if (run->has_detail && step % STEPS_BETWEEN_DETAIL == 0)
    THRUM_TRY(update_detail(run, step, error));
  const thrum_status status = thrum_scene_step(run->scene, error);
  run->failed = status < 0;
  scene_run_note_depths(run);
  scene_run_note_turns(run);

  // the check of a condensed body follows every step
  for (int32_t n = 0; n < run->run.body_count && status >= 0; n++)
    if (is_checked(run, n))
      THRUM_TRY(look_at_vibration(run, n, error));
  return status;
}

/* The scene counts a step that only some bodies made. */
static int64_t steps(const void *stepper) {
  const scene_run *run = stepper;
  return thrum_scene_steps(run->scene) - run->failed;
}

/* Looks at a condensed body in the coordinates and the energies of its model as it is in the file.
 */
static thrum_status look_at_condensed(const scene_run *run, int32_t n, const thrum_energies *now,
                                      thrum_error *error) {
  scene_body_run *body = &run->bodies[n];
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  thrum_scene_body_info info;
  thrum_scene_body(run->scene, n, &info, NULL);
  THRUM_TRY(thrum_scene_body_get(run->scene, n, NULL, p, error));
  THRUM_TRY(thrum_scene_body_shape(run->scene, n, q, error));

  // V' = e s^3 V; a scale of all velocities leaves the slaves' share of the kinetic energy
  const double scale = info.stiffness * info.scale * info.scale * info.scale;
  condensed_check_look(&body->check, q, p, now->potential / scale);
  return THRUM_OK;
}

/* Gravity and contact are left out of the total, as in the run of one body. */
static thrum_status energies(void *stepper, int32_t body, thrum_energies *found,
                             thrum_error *error) {
  const scene_run *run = stepper;
  thrum_scene_energies now;
  THRUM_TRY(thrum_scene_body_energies(run->scene, body, &now, error));
  *found = (thrum_energies){now.kinetic, now.potential, now.kinetic + now.potential, now.high};
  if (is_checked(run, body))
    return look_at_condensed(run, body, found, error);
  return THRUM_OK;
}

static thrum_status coordinates(void *stepper, int32_t body, double *q, thrum_error *error) {
  const scene_run *run = stepper;
  return thrum_scene_body_shape(run->scene, body, q, error);
}

/* Displacements in the world, from where the body was placed. */
static thrum_status displacements(void *stepper, int32_t n, double *u, thrum_error *error) {
  const scene_run *run = stepper;
  const scene_body_run *body = &run->bodies[n];
  const int64_t count = body->model->vertex_count;
  double matrix[16], q[THRUM_RANK_MAX];
  THRUM_TRY(thrum_scene_body_shape(run->scene, n, q, error));
  THRUM_TRY(thrum_displacement(body->model, q, 0, count, u, error));
  thrum_scene_body_matrix(run->scene, n, matrix);

  // X + u of the model is carried into the world, and the placed X taken away
  for (int64_t v = 0; v < count; v++) {
    const double *rest = body->model->vertices + 3 * v;
    const double in[3] = {rest[0] + u[3 * v], rest[1] + u[3 * v + 1], rest[2] + u[3 * v + 2]};
    run_placement_point(matrix, in, u + 3 * v);
    for (int axis = 0; axis < 3; axis++)
      u[3 * v + axis] -= body->vertices[3 * v + axis];
  }
  return THRUM_OK;
}

static void placement(const void *stepper, int32_t body, double matrix[16]) {
  const scene_run *run = stepper;
  thrum_scene_body_matrix(run->scene, body, matrix);
}

static thrum_status record_row(void *stepper, int64_t step, double time, thrum_error *error) {
  THRUM_TRY(scene_run_judge_note(stepper, step, error));
  THRUM_TRY(scene_run_look_through(stepper, time, error));
  THRUM_TRY(scene_run_record_account(stepper, step, time, error));
  THRUM_TRY(scene_run_record_contact(stepper, step, time, error));
  THRUM_TRY(scene_run_record_links(stepper, error));
  return scene_run_record_probes(stepper, step, time, error);
}

static thrum_status snapshot(void *stepper, int32_t body, double *q, double *p,
                             thrum_error *error) {
  const scene_run *run = stepper;
  return thrum_scene_body_get(run->scene, body, q, p, error);
}

static void report(const void *stepper, int32_t body, simulate_figures *figures) {
  const scene_run *run = stepper;
  thrum_scene_body_info info;
  thrum_scene_body(run->scene, body, &info, NULL);
  figures->status = info.status;
  figures->report = info.report;
  figures->fallback_steps = info.fallback_steps;
  figures->work_load = info.work_load;
  figures->work_base = info.work_base;
  figures->work_actuators = info.work_actuators;
  figures->work_moved = INFINITY; // bodies and obstacles give and take energy, too
  figures->dissipated = info.dissipated;
  figures->plastic_work = info.plastic_work;
  figures->plastic_strain = info.plastic_strain;
  figures->point_stiffness = info.point_stiffness;
  figures->peak *= info.scale;
  // a level of detail changes the number, and the figures are of the body as it is stepped near
  const condensed_check *check = &run->bodies[body].check;
  thrum_scene_detail_report level;
  thrum_scene_body_detail(run->scene, body, &level, NULL);
  const bool for_now = level.reduced && run->bodies[body].request.condense == 0 &&
                       thrum_model_masters(run->bodies[body].model) == 0;
  if (info.condensed && !for_now)
    condensed_check_report(check, check->model != NULL ? check->model : info.stepped, figures);

  // bodies of one model are stepped together, so none has times of its own
  figures->seconds_step = figures->seconds_read = NAN;
  figures->seconds_output = figures->seconds_plot = figures->seconds_total = NAN;
}

driver_stepper scene_run_stepper(scene_run *run) {
  static const driver_stepper_kind scene = {
      .steps_between_looks = STEPS_BETWEEN_LOOKS,
      .advance = advance,
      .steps = steps,
      .energies = energies,
      .coordinates = coordinates,
      .displacements = displacements,
      .placement = placement,
      .record_row = record_row,
      .snapshot = snapshot,
      .report = report,
  };
  return (driver_stepper){&scene, run};
}
