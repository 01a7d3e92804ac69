/* Rows that are kept of a run, and the forces that acted on its mesh then.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/basis_record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/spec/actuate_spec.h"
#include "platform/allocate.h"
#include "runtime/material/material_law.h"

#define DEGREE 0.017453292519943295 /* [rad] */

/* Why the basis of a model cannot be judged; NULL: it can. */
static const char *why_not(const simulate_request *request, const thrum_model *model) {
  if (request->basis.unless != NULL)
    return request->basis.unless;
  if (request->basis.judging == BASIS_JUDGE_OFF)
    return "it was not asked for";
  if (actuate_specs_act(model, 0))
    return "the mesh that would be asked has no gas";
  if (model->tets == NULL || model->basis == NULL)
    return "the model has no mesh inside";
  if (!isinf(request->def.plastic.yield) || thrum_law_has_yield(model))
    return "the material flows";
  return NULL;
}

thrum_status basis_record_open(const simulate_request *request, const thrum_model *model,
                               basis_record *record, thrum_error *error) {
  const int64_t rank = model->rank;
  const char *why = why_not(request, model);
  *record = (basis_record){.request = request, .model = model, .stride = 1};
  record->estimate = basis_estimate_none(why != NULL ? why : "nothing has moved");
  if (why != NULL)
    return THRUM_OK;

  // one allocation holds the coordinates and velocities of all rows
  THRUM_TRY(thrum_reserve(&record->memory, 2 * rank * (BASIS_ROWS_MAX + 1), sizeof *record->memory,
                          "the judgement of the basis", error));
  for (int64_t n = 0; n <= BASIS_ROWS_MAX; n++)
    record->rows[n] =
        (basis_row){.q = record->memory + 2 * n * rank, .p = record->memory + (2 * n + 1) * rank};
  return THRUM_OK;
}

void basis_record_close(basis_record *record) {
  free(record->memory);
  *record = (basis_record){.memory = NULL};
}

static void keep(const basis_record *record, basis_row *row, int64_t step, double size,
                 const double *q, const double *p, const double *placement) {
  const size_t rank = (size_t)record->model->rank;
  row->step = step;
  row->size = size;
  memcpy(row->q, q, rank * sizeof *q);
  memcpy(row->p, p, rank * sizeof *p);
  if (placement != NULL)
    memcpy(row->placement, placement, sizeof row->placement);
}

/* Lets every other row go. */
static void thin(basis_record *record) {
  for (int64_t n = 0; n < BASIS_ROWS_MAX / 2; n++) {
    const basis_row kept = record->rows[n];
    record->rows[n] = record->rows[2 * n];
    record->rows[2 * n] = kept;
  }
  record->count = BASIS_ROWS_MAX / 2;
  record->stride *= 2;
}

void basis_record_note(basis_record *record, int64_t step, const double *q, const double *p,
                       const double *placement) {
  double size = 0;
  if (record->memory == NULL)
    return;
  for (int64_t i = 0; i < record->model->rank; i++)
    size += q[i] * q[i];

  // rows as far apart as there is room for, and the one of the largest motion
  if (record->count == BASIS_ROWS_MAX && record->seen % record->stride == 0)
    thin(record);
  if (record->seen++ % record->stride == 0)
    keep(record, &record->rows[record->count++], step, size, q, p, placement);
  if (size > record->rows[BASIS_ROWS_MAX].size)
    keep(record, &record->rows[BASIS_ROWS_MAX], step, size, q, p, placement);
}

/* --- forces ----------------------------------------------------------------------------------- */

/* The mean of a load's course about the end of a step. */
static double course_at(const thrum_load *course, int64_t step, double dt) {
  const double after = thrum_load_mean(course, step, dt);
  return step > 0 ? 0.5 * (after + thrum_load_mean(course, step - 1, dt)) : after;
}

/* forces -= what the base makes of the inertia of the body. */
static void add_base(const basis_record *record, const double *masses, int64_t step,
                     double *forces) {
  const simulate_request *request = record->request;
  const double dt = request->def.dt;
  const int64_t earlier = step > 0 ? step - 1 : step;
  double before[3], after[3];
  base_motions_mean(request->base_motions, request->base_motion_count, step, dt, after);
  base_motions_mean(request->base_motions, request->base_motion_count, earlier, dt, before);
  for (int64_t c = 0; c < 3 * record->model->vertex_count; c++)
    forces[c] -= masses[c / 3] * 0.5 * (before[c % 3] + after[c % 3]);
}

void basis_record_add_spin(const basis_record *record, const double *masses, double *forces) {
  const thrum_model *model = record->model;
  double spin[3], centre[3] = {0}, whole = 0;
  for (int64_t c = 0; c < 3 * model->vertex_count; c++) {
    centre[c % 3] += masses[c / 3] * model->vertices[c];
    whole += c % 3 == 0 ? masses[c / 3] : 0;
  }
  for (int axis = 0; axis < 3; axis++)
    spin[axis] = DEGREE * record->request->spin[axis];

  // m (|w|^2 d - (w d) w) with d from the centre of mass
  const double square = spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2];
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double d[3], along = 0;
    for (int axis = 0; axis < 3; axis++) {
      d[axis] = model->vertices[3 * v + axis] - centre[axis] / whole;
      along += spin[axis] * d[axis];
    }
    for (int axis = 0; axis < 3; axis++)
      forces[3 * v + axis] += masses[v] * (square * d[axis] - along * spin[axis]);
  }
}

thrum_status basis_record_load(const basis_record *record, const double *masses,
                               const load_spec *load, double *forces, thrum_error *error) {
  const int64_t all = 3 * record->model->vertex_count;
  memset(forces, 0, (size_t)all * sizeof *forces);
  if (!load->gravity)
    return load_spec_fill(record->model, load, forces, error);
  for (int64_t c = 0; c < all; c++)
    forces[c] = masses[c / 3] * load->vector[c % 3];
  return THRUM_OK;
}

thrum_status basis_record_forces(const basis_record *record, const double *masses, int64_t step,
                                 double *one, double *forces, thrum_error *error) {
  const simulate_request *request = record->request;
  const int64_t all = 3 * record->model->vertex_count;
  memset(forces, 0, (size_t)all * sizeof *forces);
  for (int64_t n = 0; n < request->load_count; n++) {
    const double share = course_at(&request->loads[n].course, step, request->def.dt);
    if (share == 0)
      continue;
    THRUM_TRY(basis_record_load(record, masses, &request->loads[n], one, error));
    for (int64_t c = 0; c < all; c++)
      forces[c] += share * one[c];
  }
  if (request->base_motion_count > 0)
    add_base(record, masses, step, forces);
  if (simulate_spins(request))
    basis_record_add_spin(record, masses, forces);
  return THRUM_OK;
}
