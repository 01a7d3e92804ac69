/* The stepper of a reduced model: its state under loads and base motions. The mathematics is the
 * runtime's. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "core/base/pi.h"
#include "driver/model/model_meta.h"
#include "driver/run/coarse_step.h"
#include "driver/run/condensed_check.h"
#include "driver/run/stepper.h"
#include "driver/run/stepper_loads.h"
#include "driver/run/stepper_spin.h"
#include "platform/allocate.h"

#define STEPS_BETWEEN_LOOKS 1024

typedef struct reduced_stepper {
  const simulate_request *request;
  thrum_model damped;       /* a copy with the damping of its modes, where there is any; */
  double *rates;            /* owned */
  const thrum_model *model; /* that is stepped, */
  const thrum_model *shape; /* and shown: another where coordinates follow */
  stepper_loads loads;      /* in coordinates of the shape */
  thrum_state *state;
  double *load; /* of the last step, on all coordinates; owned */
  condensed_check check;
  stepper_spin spin;
  double work_actuators, work_moved; /* of them, and the magnitudes of all steps [J] */
} reduced_stepper;

/* --- opening ---------------------------------------------------------------------------------- */

static thrum_status reduce_loads(reduced_stepper *self, thrum_error *error) {
  static const double still[3] = {0};
  const simulate_request *request = self->request;
  for (int64_t n = 0; n < request->load_count; n++)
    THRUM_TRY(load_spec_reduce(self->shape, &request->loads[n],
                               self->loads.directions + n * self->shape->rank, error));

  // a model without axis_mass cannot be moved by its base: say so before anything is written
  for (int64_t n = 0; n < request->base_motion_count; n++) {
    const thrum_status status =
        thrum_base_motion_load(self->shape, still, self->loads.inertia, error);
    THRUM_TRY(
        config_error_in(error, status, "--base-motion '%.100s'", request->base_motions[n].text));
  }
  return THRUM_OK;
}

/* The present coordinates of the shape, without the static answer to the load. */
static thrum_status read_shape(const reduced_stepper *self, double *q) {
  double x[THRUM_RANK_MAX];
  THRUM_TRY(thrum_state_get(self->model, self->state, x, NULL, NULL));
  thrum_condensed_shape(self->model, x, NULL, q);
  return THRUM_OK;
}

/* q and p of the starts, or those that are given (rank of the shape each; NULL: none), which the
 * vectors of the loads have room for. */
static thrum_status set_start(reduced_stepper *self, const double *given_q, const double *given_p,
                              thrum_error *error) {
  const simulate_request *request = self->request;
  const thrum_state_def *def = &request->def;
  double *q = self->loads.before, *p = self->loads.after;
  thrum_error detail = {0};

  // a condensed model starts in coordinates that are stepped
  const size_t entries = (size_t)self->shape->rank;
  if (given_q == NULL)
    THRUM_TRY(start_specs_make(self->shape, request->starts, request->start_count, q, p, error));
  for (size_t i = 0; given_q != NULL && i < entries; i++) {
    q[i] = given_q[i];
    p[i] = given_p[i];
  }
  for (int64_t n = 0; n < request->start_count; n++)
    if (request->starts[n].kind == START_MODE && request->starts[n].mode > self->model->rank)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--start %s: of the condensed model only coordinates 1 to %lld start",
                             request->starts[n].text, (long long)self->model->rank);

  // the refusals of the library are put into words of the options
  if (def->split_rule == THRUM_SPLIT_COUNT && def->explicit_count > self->model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--split %d: the model has only %lld modes", (int)def->explicit_count,
                           (long long)self->model->rank);
  thrum_status status = thrum_state_create(self->model, def, &self->state, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "%s%s",
                           status == THRUM_UNSUPPORTED && isfinite(def->plastic.yield) ? "--yield: "
                                                                                       : "",
                           detail.message);

  // the state refuses a start that no step could continue
  status = thrum_state_set(self->model, self->state, q, p, error);
  THRUM_TRY(config_error_in(error, status, request->start_count > 0 ? "--start" : "--dt"));
  THRUM_TRY(stepper_spin_open(request, self->model, q, p, &self->spin, error));

  // what looks at the motion begins at the same start
  condensed_check_start(&self->check, request, q, p);
  condensed_check_damp(&self->check, def, 1);
  return read_shape(self, self->loads.before);
}

/* --- stepping --------------------------------------------------------------------------------- */

/* The mean force of all loads and of the base over a step. */
static thrum_status set_force(reduced_stepper *self, int64_t step, thrum_error *error) {
  double mean[3];
  if (!stepper_loads_act(&self->loads))
    return THRUM_OK;
  if (stepper_loads_sum(&self->loads, step, mean)) {
    memset(self->loads.inertia, 0, (size_t)self->shape->rank * sizeof *self->loads.inertia);
    THRUM_TRY(thrum_base_motion_load(self->shape, mean, self->loads.inertia, error));
    stepper_loads_add_inertia(&self->loads);
  }
  memcpy(self->load, self->loads.force, (size_t)self->shape->rank * sizeof *self->load);
  return thrum_state_set_load(self->model, self->state, self->load, error);
}

/* The mean levels of the actuators over a step. */
static thrum_status set_levels(reduced_stepper *self, int64_t step, thrum_error *error) {
  const simulate_request *request = self->request;
  double levels[THRUM_ACTUATORS_MAX];
  if (request->actuate_count == 0)
    return THRUM_OK;
  actuate_specs_levels(self->model, request->actuates, request->actuate_count, step,
                       request->def.dt, levels);
  return thrum_state_set_actuation(self->model, self->state, levels, error);
}

/* Sums up what the actuators have done. */
static void count_work(reduced_stepper *self) {
  double work[THRUM_ACTUATORS_MAX], sum = 0;
  if (!actuate_specs_act(self->model, self->request->actuate_count) ||
      thrum_state_actuation_work(self->model, self->state, work, NULL) < 0)
    return;
  for (int64_t k = 0; k < thrum_model_actuators(self->model); k++)
    sum += work[k];
  self->work_moved += fabs(sum - self->work_actuators);
  self->work_actuators = sum;
}

/* Adds what the slaves would have done in the step that was made. */
static void look_at_vibration(reduced_stepper *self) {
  double x[THRUM_RANK_MAX];
  if (thrum_state_get(self->model, self->state, x, NULL, NULL) >= 0)
    condensed_check_vibrate(&self->check, self->load, NULL, self->request->def.dt, x);
}

static thrum_status advance(void *stepper, int64_t step, thrum_error *error) {
  reduced_stepper *self = stepper;
  THRUM_TRY(set_force(self, step, error));
  THRUM_TRY(set_levels(self, step, error));
  const thrum_status status = stepper_spin_step(&self->spin, self->model, self->state, error);
  if (status >= 0 && self->check.model != NULL)
    look_at_vibration(self);
  if (status >= 0)
    count_work(self);
  if (status < 0 || !stepper_loads_act(&self->loads))
    return status;

  // what the step did for the energy: work of the loads, work of the base
  read_shape(self, self->loads.after);
  stepper_loads_count_work(&self->loads);
  stepper_loads_next(&self->loads);
  return status;
}

static int64_t steps(const void *stepper) {
  const reduced_stepper *self = stepper;
  return thrum_state_report_get(self->state).steps;
}

/* --- reading ---------------------------------------------------------------------------------- */

static thrum_status energies(void *stepper, int32_t body, thrum_energies *found,
                             thrum_error *error) {
  reduced_stepper *self = stepper;
  (void)body;
  THRUM_TRY(thrum_state_energies(self->model, self->state, found, error));
  stepper_spin_add_energy(&self->spin, found);
  if (self->check.model == NULL)
    return THRUM_OK;

  // what condensing leaves out of the kinetic energy
  double x[THRUM_RANK_MAX], v[THRUM_RANK_MAX];
  THRUM_TRY(thrum_state_get(self->model, self->state, x, v, error));
  condensed_check_look(&self->check, x, v, found->potential);
  return THRUM_OK;
}

static thrum_status coordinates(void *stepper, int32_t body, double *q, thrum_error *error) {
  const reduced_stepper *self = stepper;
  double x[THRUM_RANK_MAX];
  (void)body;
  THRUM_TRY(thrum_state_get(self->model, self->state, x, NULL, error));
  thrum_condensed_shape(self->model, x, self->load, q);
  return THRUM_OK;
}

static thrum_status displacements(void *stepper, int32_t body, double *u, thrum_error *error) {
  const reduced_stepper *self = stepper;
  double q[THRUM_RANK_MAX];
  THRUM_TRY(coordinates(stepper, body, q, error));
  return thrum_displacement(self->shape, q, 0, self->shape->vertex_count, u, error);
}

static thrum_status snapshot(void *stepper, int32_t body, double *q, double *p,
                             thrum_error *error) {
  const reduced_stepper *self = stepper;
  double x[THRUM_RANK_MAX], v[THRUM_RANK_MAX];
  (void)body;
  THRUM_TRY(thrum_state_get(self->model, self->state, x, v, error));
  thrum_condensed_shape(self->model, x, NULL, q);
  thrum_condensed_velocity(self->model, x, v, p);
  return THRUM_OK;
}

static void report(const void *stepper, int32_t body, simulate_figures *figures) {
  const reduced_stepper *self = stepper;
  (void)body;
  figures->report = thrum_state_report_get(self->state);
  figures->fallback_steps =
      figures->report.newton_steps + figures->report.energy_steps + figures->report.substep_steps;
  figures->work_load = self->loads.work_load;
  figures->work_base = self->loads.work_base;
  figures->work_moved = self->loads.work_moved + self->work_moved;
  figures->dissipated = figures->report.dissipated;
  figures->work_actuators = self->work_actuators;
  figures->plastic_work = figures->report.plastic_work;
  figures->plastic_strain = thrum_state_plastic_strain(self->state);
  figures->point_stiffness = thrum_state_point_stiffness(self->state);
  stepper_spin_now(&self->spin, figures->spin);
  if (self->shape != self->model)
    condensed_check_report(&self->check, self->model, figures);
}

static void close_reduced(void *stepper) {
  reduced_stepper *self = stepper;
  stepper_loads_close(&self->loads);
  thrum_state_destroy(self->state);
  stepper_spin_close(&self->spin);
  condensed_check_close(&self->check);
  free(self->load);
  free(self->rates);
  free(self);
}

static const driver_stepper_kind reduced = {
    .steps_between_looks = STEPS_BETWEEN_LOOKS,
    .stands_after_failure = true,
    .advance = advance,
    .steps = steps,
    .energies = energies,
    .coordinates = coordinates,
    .displacements = displacements,
    .snapshot = snapshot,
    .report = report,
    .close = close_reduced,
};

/* Steps a copy of the model in which each linear mode has its damping ratio. */
static thrum_status damp_modes(reduced_stepper *self, thrum_error *error) {
  const thrum_model *model = self->model;
  THRUM_TRY(
      thrum_reserve(&self->rates, model->rank, sizeof *self->rates, "a run of this model", error));
  const int64_t modes = model_meta_modes(thrum_condensed_shape_model(model));
  damping_spec_rates(&self->request->modal, model->omega2, model->rank,
                     modes < model->rank ? modes : model->rank, self->rates);
  self->damped = *model;
  self->damped.damping = self->rates;
  self->model = &self->damped;
  return THRUM_OK;
}

thrum_status driver_stepper_reduced(const simulate_request *request, const thrum_model *model,
                                    driver_stepper *stepper, thrum_error *error) {
  return driver_stepper_reduced_from(request, model, NULL, NULL, stepper, error);
}

thrum_status driver_stepper_reduced_from(const simulate_request *request, const thrum_model *model,
                                         const double *q, const double *p, driver_stepper *stepper,
                                         thrum_error *error) {
  reduced_stepper *self = NULL;
  THRUM_TRY(thrum_reserve(&self, 1, sizeof *self, "a run of this model", error));

  // from here on the caller frees what there is
  *stepper = (driver_stepper){&reduced, self};
  self->request = request;
  self->model = model;
  if (damping_spec_given(&request->modal))
    THRUM_TRY(damp_modes(self, error));
  self->shape = thrum_condensed_shape_model(self->model);
  THRUM_TRY(thrum_reserve(&self->load, (size_t)self->shape->rank, sizeof *self->load,
                          "a run of this model", error));

  // how far a condensed body can be believed is a question of the monitor
  if (self->shape != self->model && request->monitor)
    THRUM_TRY(condensed_check_open(self->model, &self->check, error));
  THRUM_TRY(stepper_loads_open(request, self->shape->rank, &self->loads, error));
  THRUM_TRY(reduce_loads(self, error));
  THRUM_TRY(actuate_specs_check(self->shape, request->actuates, request->actuate_count, error));
  return set_start(self, q, p, error);
}

/* --- warnings --------------------------------------------------------------------------------- */

/* A free body has no coordinates for what moves it as a whole. */
static void warn_free(const simulate_request *request) {
  double sum[3] = {0, 0, 0}, largest = 0;
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n];
    if (load->gravity)
      config_warn("--load '%s' moves nothing: nothing holds the body, so it falls without a strain",
                  load->text);
    for (int axis = 0; axis < 3 && !load->gravity && !load->traction; axis++) {
      sum[axis] += load->vector[axis];
      largest = fmax(largest, fabs(load->vector[axis]));
    }
  }

  // a pair of forces that pulls the body apart has no resultant
  if (fabs(sum[0]) + fabs(sum[1]) + fabs(sum[2]) > 1e-9 * largest)
    config_warn(
        "nothing holds the body: the resultant of the loads (%g, %g, %g N at full strength), "
        "which would move it as a whole, has no effect; the rest deforms it",
        sum[0], sum[1], sum[2]);
}

void driver_stepper_reduced_warn(const driver_stepper *stepper) {
  const reduced_stepper *self = stepper->self;
  const simulate_request *request = self->request;
  const int64_t rank = self->shape->rank;

  // what moves a free body as a whole is not in its basis
  if (request->base_motion_count > 0 && self->shape->rigid != NULL)
    config_warn(
        "--base-motion moves nothing: nothing holds the body, so its supports cannot move it");
  if (self->shape->rigid != NULL)
    warn_free(request);

  // loads that the basis does not feel at all
  for (int64_t n = 0; n < request->load_count; n++) {
    bool idle = true;
    for (int64_t i = 0; i < rank; i++)
      idle = idle && self->loads.directions[n * rank + i] == 0;
    if (idle)
      config_warn("--load '%s' moves nothing: it is zero, or all of its vertices are held",
                  request->loads[n].text);
  }

  // loads that the run does not live to see
  for (int64_t n = 0; n < request->load_count; n++)
    if (request->loads[n].course.from >= request->time)
      config_warn("--load '%s' begins at %g s and has no effect: the run ends at %g s",
                  request->loads[n].text, request->loads[n].course.from, request->time);

  // an explicit mode beyond the bound of Stoermer-Verlet (design 4), or of Runge-Kutta, grows from
  // the first step on
  const int32_t count = thrum_state_report_get(self->state).explicit_modes;
  const double dt = request->def.dt;
  const double bound = request->def.integrator == THRUM_INTEGRATOR_RK4 ? 2.828 : 2;
  const double fastest = count > 0 ? sqrt(self->model->omega2[count - 1]) : 0;
  if (dt * fastest >= bound)
    config_warn("explicit mode %d is beyond the stability bound: dt omega = %.3g, not below %.3g; "
                "take --dt below %.2g, or an implicit integrator",
                (int)count, dt * fastest, bound, bound / fastest);

  // starts are those of the shape, which nothing has moved yet
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX] = {0};
  if (thrum_state_get(self->model, self->state, q, p, NULL) >= 0 && self->shape == self->model)
    coarse_step_warn(
        &(coarse_step_motion){.request = request,
                              .model = self->shape,
                              .pace = 1,
                              .directions = self->loads.directions,
                              .q = q,
                              .p = p,
                              .base = request->base_motion_count > 0 && self->shape->rigid == NULL},
        "");

  // where all modes are implicit the run is stable
  if (count == 0)
    coarse_step_warn_slowest(self->model, 1, dt);
}
