/* A whole mesh on an accelerator, and the same steps by the full-order body, whose ends are
 * compared. Times are of the wall. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "bench/measure_accelerator.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/full/full.h"

#define STEPS 10

/* Where both start, and where they end: 3 numbers a vertex. */
typedef struct fields {
  double *speed, *there, *here;
  thrum_scope memory;
} fields;

// the velocities of the first mode with which a step's body begins
static thrum_status start(const thrum_model *model, const bench_mesh_body *bench, fields *f,
                          thrum_error *error) {
  double p[THRUM_RANK_MAX];
  THRUM_TRY(bench_step_momentum(model, &bench->step, p, error));
  for (int64_t c = 0; c < 3 * model->vertex_count; c++)
    f->speed[c] = model->basis[c * model->rank] * p[0];
  return THRUM_OK;
}

static thrum_status step_there(const thrum_model *model, bench_mesh_body *bench, fields *f,
                               thrum_error *error) {
  thrum_accelerator_def device = thrum_default_accelerator_def();
  device.device = bench->device;
  device.single = bench->single;
  thrum_accelerator *accelerator = NULL;
  thrum_mesh_body *body = NULL;
  thrum_mesh_body_def def = thrum_default_mesh_body_def();
  def.dt = bench->step.def.dt;
  thrum_status status = thrum_accelerator_create(&device, &accelerator, error);
  THRUM_THEN(status, thrum_accelerator_get_info(accelerator, &bench->info, error));
  THRUM_THEN(status, thrum_mesh_body_create(accelerator, model, &def, &body, error));

  // the first run also compiles
  double best = INFINITY;
  for (int64_t b = 0; b <= bench->step.batches && status >= 0; b++) {
    thrum_mesh_body_report before, after;
    THRUM_THEN(status, thrum_mesh_body_set(body, NULL, f->speed, error));
    THRUM_THEN(status, thrum_mesh_body_get_report(body, &before, error));
    const double began = clock_seconds();
    THRUM_THEN(status, thrum_mesh_body_step(body, bench->steps, error));
    if (b > 0)
      best = fmin(best, clock_seconds() - began);
    THRUM_THEN(status, thrum_mesh_body_get_report(body, &after, error));
    if (status < 0)
      break;
    bench->iterations = (double)(after.iterations - before.iterations) / (double)bench->steps;
    bench->solver_iterations =
        (double)(after.solver_iterations - before.solver_iterations) / (double)bench->steps;
  }
  THRUM_THEN(status, thrum_mesh_body_get(body, f->there, NULL, error));
  bench->ms = 1e3 * best / (double)bench->steps;
  thrum_mesh_body_destroy(body);
  thrum_accelerator_destroy(accelerator);
  return status;
}

static thrum_status step_here(const thrum_model *model, bench_mesh_body *bench, fields *f,
                              thrum_error *error) {
  thrum_full_def def = thrum_default_full_def();
  def.scheme = THRUM_FULL_MIDPOINT;
  def.dt = bench->step.def.dt;
  thrum_full *full;
  THRUM_TRY(thrum_full_create(model, NULL, &def, &full, error));
  double best = INFINITY;
  thrum_status status = THRUM_OK;
  for (int64_t b = 0; b < bench->step.batches && status >= 0; b++) {
    status = thrum_full_set(full, NULL, f->speed, error);
    const double began = clock_seconds();
    for (int64_t k = 0; k < bench->steps && status >= 0; k++)
      status = thrum_full_step(full, error);
    best = fmin(best, clock_seconds() - began);
  }
  bench->ms_here = 1e3 * best / (double)bench->steps;
  thrum_full_get(full, f->here, NULL);
  thrum_full_free(full);
  return status;
}

thrum_status bench_mesh_body_run(const thrum_model *model, bench_mesh_body *bench,
                                 thrum_error *error) {
  if (!model->basis)
    return thrum_error_set(error, THRUM_MISSING, "the model has no mesh and basis");
  fields f = {.memory = thrum_scope_begin("the fields of a mesh", error)};
  bench->steps = bench->step.steps > 0 ? bench->step.steps : STEPS;
  bench->vertices = model->vertex_count;
  bench->tets = model->tet_count;
  double **const all[] = {&f.speed, &f.there, &f.here};
  for (int k = 0; k < 3; k++)
    *all[k] = thrum_scope_allocate(&f.memory, 3 * model->vertex_count, sizeof **all[k]);
  thrum_status status = f.memory.status;
  THRUM_THEN(status, start(model, bench, &f, error));
  THRUM_THEN(status, step_there(model, bench, &f, error));
  THRUM_THEN(status, step_here(model, bench, &f, error));
  double most = 0, off = 0;
  for (int64_t c = 0; c < 3 * model->vertex_count && status >= 0; c++) {
    most = fmax(most, fabs(f.here[c]));
    off = fmax(off, fabs(f.here[c] - f.there[c]));
  }
  bench->error = most > 0 ? off / most : 0;
  thrum_scope_free(&f.memory);
  return status < 0 ? status : THRUM_OK;
}
