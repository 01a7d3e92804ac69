/* A run of the full order: the mesh of the model, unreduced, under the same loads and from the same
 * start. The mathematics is that of full/. SPDX-License-Identifier: Apache-2.0 */
#include "driver/simulate_full.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "io/json.h"
#include "platform/threads.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"

/* What a run of the full order has besides. Fields are 3 vertex_count. */
struct simulate_full {
  thrum_full *body;
  double *memory;
  double *directions;             /* load_count fields */
  double *unit;                   /* 3 fields: M 1 along each axis */
  double *forces, *inertia;       /* of the step */
  double *before, *after, *speed; /* u before and after it; v */
};

int simulate_full_check(simulate_request *request) {
  thrum_state_def *def = &request->def;
  if (!request->full)
    return COMMAND_DONE;
  if (!request->integrator_named)
    def->integrator = THRUM_INTEGRATOR_ENERGY;
  if (def->integrator == THRUM_INTEGRATOR_IMEXV)
    return config_usage("simulate",
                        "--full: imexv splits the modes of a reduced model; take energy, "
                        "newmark, midpoint or verlet");
  if (def->damping_form == THRUM_DAMPING_TANGENT)
    return config_usage("simulate", "--full takes --damping-form rest only");
  if (request->stress)
    return config_usage("simulate", "--stress is of a reduced model; leave it out with --full");
  request->monitor = false;
  return COMMAND_DONE;
}

static thrum_full_def def_of(const simulate_request *request) {
  static const thrum_full_scheme schemes[] = {
      [THRUM_INTEGRATOR_IMEXV] = THRUM_FULL_ENERGY,
      [THRUM_INTEGRATOR_NEWMARK] = THRUM_FULL_NEWMARK,
      [THRUM_INTEGRATOR_VERLET] = THRUM_FULL_CENTRAL,
      [THRUM_INTEGRATOR_MIDPOINT] = THRUM_FULL_MIDPOINT,
      [THRUM_INTEGRATOR_ENERGY] = THRUM_FULL_ENERGY,
  };
  thrum_full_def def = thrum_default_full_def();
  def.scheme = schemes[request->def.integrator];
  def.dt = request->def.dt;
  def.damping_alpha = request->def.damping_alpha;
  def.damping_beta = request->def.damping_beta;
  def.newmark_beta = request->def.newmark_beta;
  def.newmark_gamma = request->def.newmark_gamma;
  def.tolerance = request->def.tolerance;
  def.iterations_max = request->def.iterations_max;
  def.solver = request->solver;
  return def;
}

static int64_t field_size(const simulation *run) {
  return 3 * run->model->vertex_count;
}

static thrum_status allocate(simulation *run, thrum_error *error) {
  simulate_full *full = run->full;
  const size_t size = (size_t)field_size(run);
  full->memory = calloc(size * (size_t)(8 + run->request->load_count), sizeof *full->memory);
  if (full->memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "no memory for the fields of the full order");
  full->unit = full->memory;
  full->forces = full->unit + 3 * size;
  full->inertia = full->forces + size;
  full->before = full->inertia + size;
  full->after = full->before + size;
  full->speed = full->after + size;
  full->directions = full->speed + size;
  return THRUM_OK;
}

/* forces += the load at its full strength. */
static thrum_status add_load(const simulation *run, const cli_load *load, double *forces,
                             thrum_error *error) {
  if (!load->gravity)
    return cli_load_fill(run->model, load, forces, error);
  thrum_full_add_gravity(run->full->body, load->vector, forces);
  return THRUM_OK;
}

static thrum_status fill_loads(simulation *run, thrum_error *error) {
  simulate_full *full = run->full;
  const simulate_request *request = run->request;
  thrum_status status = THRUM_OK;
  for (int axis = 0; axis < 3; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    thrum_full_add_gravity(full->body, unit, full->unit + axis * field_size(run));
  }
  for (int64_t n = 0; n < request->load_count && status >= 0; n++)
    status = add_load(run, &request->loads[n], full->directions + n * field_size(run), error);
  return status;
}

/* Starts of static: are equilibria of the full order; the others come through u = U q, v = U p. */
static thrum_status make_start(simulation *run, thrum_error *error) {
  simulate_full *full = run->full;
  const simulate_request *request = run->request;
  const thrum_model *model = run->model;
  const int64_t rank = model->rank;
  thrum_status status = THRUM_OK;
  int64_t resting = 0, others = 0;
  for (int64_t n = 0; n < request->start_count && status >= 0; n++) {
    const cli_start *start = &request->starts[n];
    resting += start->kind == CLI_START_STATIC;
    if (start->kind == CLI_START_STATIC)
      status = add_load(run, &start->load, full->forces, error);
    else
      status = cli_starts_make(model, start, 1, run->before, run->after, error);
    if (start->kind == CLI_START_STATIC)
      continue;
    others++;
    for (int64_t i = 0; i < rank; i++) {
      run->q[i] += run->before[i];
      run->p[i] += run->after[i];
      run->before[i] = run->after[i] = 0;
    }
  }
  if (status >= 0 && resting > 0) {
    thrum_full_equilibrium found;
    status = thrum_full_rest(full->body, full->forces, NULL, &found, error);
    if (status >= 0)
      status = thrum_full_set_force(full->body, NULL, error);
  }
  if (status < 0 || others == 0)
    return status;
  thrum_full_get(full->body, full->before, NULL);
  status = thrum_displacement(model, run->q, 0, model->vertex_count, full->after, error);
  if (status >= 0)
    status = thrum_displacement(model, run->p, 0, model->vertex_count, full->speed, error);
  for (int64_t c = 0; c < field_size(run) && status >= 0; c++)
    full->after[c] += full->before[c];
  return status >= 0 ? thrum_full_set(full->body, full->after, full->speed, error) : status;
}

thrum_status simulate_full_open(simulation *run, thrum_error *error) {
  const thrum_full_def def = def_of(run->request);
  if (run->model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "--full: the model has no basis to see the body by");
  run->full = calloc(1, sizeof *run->full);
  if (run->full == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the full order");
  // one thread, as every other run, so that times compare
  thrum_threads_set(1);
  thrum_status status = thrum_full_create(run->model, NULL, &def, &run->full->body, error);
  if (status >= 0)
    status = allocate(run, error);
  if (status >= 0)
    status = fill_loads(run, error);
  if (status >= 0)
    status = make_start(run, error);
  if (status >= 0) {
    memset(run->full->forces, 0, (size_t)field_size(run) * sizeof(double));
    thrum_full_get(run->full->body, run->full->before, NULL);
  }
  return status;
}

void simulate_full_close(simulation *run) {
  if (run->full == NULL)
    return;
  thrum_full_free(run->full->body);
  free(run->full->memory);
  free(run->full);
  run->full = NULL;
}

/* Loads and the base's motion of a step. */
static thrum_status set_force(simulation *run, int64_t step) {
  const simulate_request *request = run->request;
  simulate_full *full = run->full;
  const int64_t size = field_size(run);
  if (request->load_count == 0 && request->base_motion_count == 0)
    return THRUM_OK;
  thrum_load_sum(run->courses, full->directions, request->load_count, size, step, request->def.dt,
                 full->forces);
  if (request->base_motion_count > 0) {
    double mean[3];
    cli_base_motions_mean(request->base_motions, request->base_motion_count, step, request->def.dt,
                          mean);
    for (int64_t c = 0; c < size; c++) {
      full->inertia[c] = -(mean[0] * full->unit[c] + mean[1] * full->unit[size + c] +
                           mean[2] * full->unit[2 * size + c]);
      full->forces[c] += full->inertia[c];
    }
  }
  return thrum_full_set_force(full->body, full->forces, &run->figures.stop);
}

thrum_status simulate_full_step(simulation *run, int64_t step) {
  simulate_full *full = run->full;
  simulate_figures *figures = &run->figures;
  const int64_t shorter = thrum_full_report_get(full->body).substep_steps;
  thrum_status status = set_force(run, step);
  if (status >= 0)
    status = thrum_full_step(full->body, &figures->stop);
  if (status < 0)
    return status;
  if (run->request->load_count > 0 || run->request->base_motion_count > 0) {
    thrum_full_get(full->body, full->after, NULL);
    const double all = thrum_load_work(full->forces, full->before, full->after, field_size(run));
    const double base = thrum_load_work(full->inertia, full->before, full->after, field_size(run));
    figures->work_load += all - base;
    figures->work_base += base;
    double *kept = full->before;
    full->before = full->after;
    full->after = kept;
  }
  return thrum_full_report_get(full->body).substep_steps > shorter ? THRUM_FELL_BACK : THRUM_OK;
}

thrum_status simulate_full_see(simulation *run, thrum_energies *energies, thrum_error *error) {
  simulate_full *full = run->full;
  thrum_full_get(full->body, full->after, NULL);
  thrum_full_project(full->body, full->after, run->q);
  thrum_full_peak(full->body, &run->figures.peak, &run->figures.peak_vertex);
  if (energies == NULL)
    return THRUM_OK;
  const thrum_full_energies found = thrum_full_energy(full->body);
  if (!isfinite(found.total))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the energy of this state is beyond the range of finite numbers");
  *energies = (thrum_energies){found.kinetic, found.potential, found.total, NAN};
  return THRUM_OK;
}

thrum_status simulate_full_frame(simulation *run, double time, const double base[3],
                                 thrum_error *error) {
  thrum_full_get(run->full->body, run->output.displacement, NULL);
  return cli_run_output_frame_of(&run->output, time, base, NULL, error);
}

void simulate_full_get(simulation *run) {
  simulate_full *full = run->full;
  thrum_full_get(full->body, full->after, full->speed);
  thrum_full_project(full->body, full->after, run->q);
  thrum_full_project(full->body, full->speed, run->p);
}

thrum_state_report simulate_full_report(const simulation *run) {
  const thrum_full_report found = thrum_full_report_get(run->full->body);
  const bool explicit = run->request->def.integrator == THRUM_INTEGRATOR_VERLET;
  return (thrum_state_report){
      .steps = found.steps,
      .iterations = found.iterations,
      .factorisations = found.factorisations,
      .substep_steps = found.substep_steps,
      .explicit_modes = explicit ? (int32_t)found.free_count : 0,
      .implicit_modes = explicit ? 0 : (int32_t)found.free_count,
  };
}

thrum_full_report simulate_full_figures(const simulation *run) {
  return run->full != NULL ? thrum_full_report_get(run->full->body) : (thrum_full_report){0};
}

void simulate_full_json(const simulate_figures *figures, cJSON *object) {
  static const char *const names[] = {"cholesky", "cg"};
  if (!figures->request->full) {
    cJSON_AddNullToObject(object, "full");
    return;
  }
  cJSON *full = cJSON_AddObjectToObject(object, "full");
  json_number(full, "components", (double)figures->full.free_count);
  cJSON_AddStringToObject(full, "solver", names[figures->request->solver]);
  json_number(full, "solver_iterations", (double)figures->full.solver_iterations);
  json_number(full, "dt_stable", figures->full.dt_stable);
}
