/* The stepper of the full order: the mesh of the model, unreduced, under the same loads and from
 * the same start. The mathematics is that of precompute/full/. Fields have 3 vertex_count
 * components. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/run/stepper.h"
#include "driver/run/stepper_loads.h"
#include "driver/spec/shared_options.h"
#include "platform/allocate.h"
#include "platform/threads.h"

typedef struct full_stepper {
  const simulate_request *request;
  const thrum_model *model;
  thrum_full *body;
  stepper_loads loads; /* as fields */
  double *unit;        /* 3 fields: M 1 along each axis; owned, with the next */
  double *speed;       /* a field */
  int64_t fallback_steps;
  double work_actuators, work_moved; /* of them, and the magnitudes of all steps [J] */
} full_stepper;

/* --- opening ---------------------------------------------------------------------------------- */

static thrum_full_def def_of(const simulate_request *request, const thrum_model *model) {
  static const thrum_full_scheme schemes[] = {
      [THRUM_INTEGRATOR_IMEXV] = THRUM_FULL_ENERGY,
      [THRUM_INTEGRATOR_NEWMARK] = THRUM_FULL_NEWMARK,
      [THRUM_INTEGRATOR_VERLET] = THRUM_FULL_CENTRAL,
      [THRUM_INTEGRATOR_MIDPOINT] = THRUM_FULL_MIDPOINT,
      [THRUM_INTEGRATOR_ENERGY] = THRUM_FULL_ENERGY,
  };

  // options of the integrators have the same names in both orders
  thrum_full_def def = thrum_default_full_def();
  def.scheme = schemes[request->def.integrator];
  def.dt = request->def.dt;
  def.damping_alpha = request->def.damping_alpha;
  def.damping_beta = request->def.damping_beta;
  def.newmark_beta = request->def.newmark_beta;
  def.newmark_gamma = request->def.newmark_gamma;
  if (request->def.tolerance > 0.0)
    def.tolerance = request->def.tolerance;
  def.iterations_max = request->def.iterations_max;
  def.solver = request->solver;
  def.shared = request->shared;
  def.quadrature = request->quadrature;
  def.law = law_of_run(request->law_given, request->law, model);
  def.plastic = request->def.plastic;
  return def;
}

/* forces += the load at its full strength. */
static thrum_status add_load(const full_stepper *self, const load_spec *load, double *forces,
                             thrum_error *error) {
  if (!load->gravity)
    return load_spec_fill(self->model, load, forces, error);
  thrum_full_add_gravity(self->body, load->vector, forces);
  return THRUM_OK;
}

static thrum_status fill_loads(full_stepper *self, thrum_error *error) {
  const simulate_request *request = self->request;
  const int64_t size = self->loads.size;
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    thrum_full_add_gravity(self->body, unit, self->unit + axis * size);
  }
  for (int64_t n = 0; n < request->load_count; n++)
    THRUM_TRY(add_load(self, &request->loads[n], self->loads.directions + n * size, error));
  return THRUM_OK;
}

/* The body at the equilibrium under all starts of static:. */
static thrum_status rest_at_equilibrium(full_stepper *self, thrum_error *error) {
  const simulate_request *request = self->request;
  thrum_full_equilibrium found;
  int64_t count = 0;
  for (int64_t n = 0; n < request->start_count; n++) {
    if (request->starts[n].kind != START_STATIC)
      continue;
    THRUM_TRY(add_load(self, &request->starts[n].load, self->loads.force, error));
    count++;
  }
  if (count == 0)
    return THRUM_OK;
  THRUM_TRY(thrum_full_rest(self->body, self->loads.force, NULL, &found, error));
  memset(self->loads.force, 0, (size_t)self->loads.size * sizeof(double));
  return thrum_full_set_force(self->body, NULL, error);
}

/* Adds the other starts, which come through u = U q and v = U p. */
static thrum_status add_starts(full_stepper *self, thrum_error *error) {
  const simulate_request *request = self->request;
  const thrum_model *model = self->model;
  double q[THRUM_RANK_MAX] = {0}, p[THRUM_RANK_MAX] = {0};
  int64_t count = 0;
  for (int64_t n = 0; n < request->start_count; n++) {
    double q_of[THRUM_RANK_MAX] = {0}, p_of[THRUM_RANK_MAX] = {0};
    if (request->starts[n].kind == START_STATIC)
      continue;
    THRUM_TRY(start_specs_make(model, &request->starts[n], 1, q_of, p_of, error));
    for (int64_t i = 0; i < model->rank; i++) {
      q[i] += q_of[i];
      p[i] += p_of[i];
    }
    count++;
  }
  if (count == 0)
    return THRUM_OK;

  // the other starts come on top of the equilibrium
  double *u = self->loads.after, *rest = self->loads.before;
  thrum_full_get(self->body, rest, NULL);
  THRUM_TRY(thrum_displacement(model, q, 0, model->vertex_count, u, error));
  THRUM_TRY(thrum_displacement(model, p, 0, model->vertex_count, self->speed, error));
  for (int64_t c = 0; c < self->loads.size; c++)
    u[c] += rest[c];
  return thrum_full_set(self->body, u, self->speed, error);
}

/* --- stepping --------------------------------------------------------------------------------- */

static thrum_status set_force(full_stepper *self, int64_t step, thrum_error *error) {
  const int64_t size = self->loads.size;
  double mean[3];
  if (!stepper_loads_act(&self->loads))
    return THRUM_OK;
  if (stepper_loads_sum(&self->loads, step, mean)) {
    for (int64_t c = 0; c < size; c++)
      self->loads.inertia[c] = -(mean[0] * self->unit[c] + mean[1] * self->unit[size + c] +
                                 mean[2] * self->unit[2 * size + c]);
    stepper_loads_add_inertia(&self->loads);
  }
  return thrum_full_set_force(self->body, self->loads.force, error);
}

/* The mean levels of the actuators over a step. */
static thrum_status set_levels(const full_stepper *self, int64_t step, thrum_error *error) {
  const simulate_request *request = self->request;
  double levels[THRUM_ACTUATORS_MAX];
  if (request->actuate_count == 0)
    return THRUM_OK;
  actuate_specs_levels(self->model, request->actuates, request->actuate_count, step,
                       request->def.dt, levels);
  return thrum_full_set_actuation(self->body, levels, error);
}

static thrum_status advance(void *stepper, int64_t step, thrum_error *error) {
  full_stepper *self = stepper;
  const int64_t shorter = thrum_full_report_get(self->body).substep_steps;
  THRUM_TRY(set_force(self, step, error));
  THRUM_TRY(set_levels(self, step, error));
  const double before = thrum_full_acting_energy(self->body);
  THRUM_TRY(thrum_full_step(self->body, error));
  const double work = before - thrum_full_acting_energy(self->body);
  self->work_actuators += work;
  self->work_moved += fabs(work);
  if (stepper_loads_act(&self->loads)) {
    thrum_full_get(self->body, self->loads.after, NULL);
    stepper_loads_count_work(&self->loads);
    stepper_loads_next(&self->loads);
  }

  // shorter steps in place of one are its only fallback
  if (thrum_full_report_get(self->body).substep_steps == shorter)
    return THRUM_OK;
  self->fallback_steps++;
  return THRUM_FELL_BACK;
}

static int64_t steps(const void *stepper) {
  const full_stepper *self = stepper;
  return thrum_full_report_get(self->body).steps;
}

/* --- reading ---------------------------------------------------------------------------------- */

static thrum_status energies(void *stepper, int32_t body, thrum_energies *energies_of,
                             thrum_error *error) {
  const full_stepper *self = stepper;
  (void)body;
  const thrum_full_energies found = thrum_full_energy(self->body);
  if (!isfinite(found.total))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the energy of this state is beyond the range of finite numbers");
  *energies_of = (thrum_energies){found.kinetic, found.potential, found.total, NAN};
  return THRUM_OK;
}

/* The coordinates nearest to the body, U^T M u. */
static thrum_status coordinates(void *stepper, int32_t body, double *q, thrum_error *error) {
  full_stepper *self = stepper;
  (void)body;
  (void)error;
  thrum_full_get(self->body, self->loads.after, NULL);
  thrum_full_project(self->body, self->loads.after, q);
  return THRUM_OK;
}

static void raise_peak(void *stepper, int32_t body, double *peak, int64_t *vertex) {
  const full_stepper *self = stepper;
  (void)body;
  thrum_full_peak(self->body, peak, vertex);
}

static thrum_status displacements(void *stepper, int32_t body, double *u, thrum_error *error) {
  const full_stepper *self = stepper;
  (void)body;
  (void)error;
  thrum_full_get(self->body, u, NULL);
  return THRUM_OK;
}

static thrum_status velocities(void *stepper, double *v) {
  const full_stepper *self = stepper;
  thrum_full_get(self->body, NULL, v);
  return THRUM_OK;
}

static thrum_status snapshot(void *stepper, int32_t body, double *q, double *p,
                             thrum_error *error) {
  full_stepper *self = stepper;
  (void)body;
  (void)error;
  thrum_full_get(self->body, self->loads.after, self->speed);
  thrum_full_project(self->body, self->loads.after, q);
  thrum_full_project(self->body, self->speed, p);
  return THRUM_OK;
}

static void report(const void *stepper, int32_t body, simulate_figures *figures) {
  const full_stepper *self = stepper;
  const thrum_state_def *def = &self->request->def;
  const bool explicit = def->integrator == THRUM_INTEGRATOR_VERLET;
  (void)body;
  figures->full = thrum_full_report_get(self->body);
  figures->report = (thrum_state_report){
      .steps = figures->full.steps,
      .iterations = figures->full.iterations,
      .factorisations = figures->full.factorisations,
      .substep_steps = figures->full.substep_steps,
      .explicit_modes = explicit ? (int32_t)figures->full.free_count : 0,
      .implicit_modes = explicit ? 0 : (int32_t)figures->full.free_count,
  };

  // the loss by damping is not counted in full order
  figures->fallback_steps = self->fallback_steps;
  figures->work_load = self->loads.work_load;
  figures->work_base = self->loads.work_base;
  figures->work_moved = self->loads.work_moved + self->work_moved;
  figures->work_actuators = self->work_actuators;
  figures->plastic_work = figures->full.plastic_work;
  figures->plastic_strain = thrum_full_plastic_strain(self->body);
  figures->dissipated =
      def->damping_alpha > 0 || def->damping_beta > 0 ? NAN : figures->plastic_work;
}

static void close_full(void *stepper) {
  full_stepper *self = stepper;
  thrum_full_free(self->body);
  stepper_loads_close(&self->loads);
  free(self->unit);
  free(self);
}

static const driver_stepper_kind full = {
    .steps_between_looks = 1,
    .stands_after_failure = true,
    .advance = advance,
    .steps = steps,
    .energies = energies,
    .coordinates = coordinates,
    .raise_peak = raise_peak,
    .displacements = displacements,
    .velocities = velocities,
    .snapshot = snapshot,
    .report = report,
    .close = close_full,
};

thrum_status driver_stepper_full(const simulate_request *request, const thrum_model *model,
                                 driver_stepper *stepper, thrum_error *error) {
  const thrum_full_def def = def_of(request, model);
  const size_t size = 3 * (size_t)model->vertex_count;
  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "--full: the model has no basis to see the body by");
  full_stepper *self = NULL;
  THRUM_TRY(thrum_reserve(&self, 1, sizeof *self, "the full order", error));
  *stepper = (driver_stepper){&full, self};
  self->request = request;
  self->model = model;

  // one thread, as every other run, so that times compare
  thrum_threads_set(1);
  THRUM_TRY(thrum_full_create(model, NULL, &def, &self->body, error));
  THRUM_TRY(stepper_loads_open(request, (int64_t)size, &self->loads, error));
  THRUM_TRY(thrum_reserve(&self->unit, 4 * size, sizeof *self->unit, "the fields of the full order",
                          error));
  self->speed = self->unit + 3 * size;

  THRUM_TRY(actuate_specs_check(model, request->actuates, request->actuate_count, error));

  // loads, then the start, which work is counted from
  THRUM_TRY(fill_loads(self, error));
  THRUM_TRY(rest_at_equilibrium(self, error));
  THRUM_TRY(add_starts(self, error));
  thrum_full_get(self->body, self->loads.before, NULL);
  return THRUM_OK;
}
