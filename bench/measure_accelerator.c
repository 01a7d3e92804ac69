/* A crowd of bodies on an accelerator, and thrum_step for some of them, whose ends are compared.
 * Times are of the wall: what a device does is no time of this processor.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "accelerator/peak.h"
#include "bench/measure_accelerator.h"
#include "platform/allocate.h"
#include "platform/clock.h"

#define STEPS 20
#define COMPARED 8 /* bodies that thrum_step steps too */

/* The crowd, where it starts and where it ends. */
typedef struct throng {
  thrum_accelerator *accelerator;
  thrum_crowd *crowd;
  double *start, *end; /* p and q, rank numbers for each body */
  thrum_scope memory;
} throng;

// bodies swing by half of the swing up to all of it
static thrum_status place(const thrum_model *model, bench_accelerator *bench, throng *t,
                          thrum_error *error) {
  const thrum_status status = bench_step_momentum(model, &bench->step, t->start, error);
  for (int64_t n = bench->bodies - 1; n >= 0; n--)
    for (int64_t i = 0; i < model->rank; i++)
      t->start[n * model->rank + i] =
          t->start[i] * (0.5 + 0.5 * (double)(n + 1) / (double)bench->bodies);
  return status;
}

static thrum_status make(const thrum_model *model, bench_accelerator *bench, throng *t,
                         thrum_error *error) {
  thrum_accelerator_def device = thrum_default_accelerator_def();
  device.device = bench->device;
  device.single = bench->single;
  THRUM_TRY(thrum_accelerator_create(&device, &t->accelerator, error));
  THRUM_TRY(thrum_accelerator_get_info(t->accelerator, &bench->info, error));

  thrum_crowd_def def = thrum_default_crowd_def();
  def.count = bench->bodies;
  def.state = bench->step.def;
  bench->operations = crowd_step_operations(model->rank, &def);
  THRUM_TRY(thrum_crowd_create(t->accelerator, model, &def, &t->crowd, error));
  t->memory = thrum_scope_begin("the bodies", error);
  t->start = thrum_scope_allocate(&t->memory, bench->bodies * model->rank, sizeof *t->start);
  t->end = thrum_scope_allocate(&t->memory, bench->bodies * model->rank, sizeof *t->end);
  THRUM_TRY(t->memory.status);
  return place(model, bench, t, error);
}

// the fastest of the batches
static thrum_status measure(const thrum_model *model, bench_accelerator *bench, throng *t,
                            thrum_error *error) {
  double best = INFINITY, peak = INFINITY, operations = 0;
  for (int64_t b = 0; b <= bench->step.batches; b++) {
    THRUM_TRY(thrum_crowd_set(t->crowd, NULL, t->start, model->rank, error));
    double began = clock_seconds();
    THRUM_TRY(thrum_crowd_step(t->crowd, bench->steps, NULL, error));
    const double took = clock_seconds() - began;
    began = clock_seconds();
    THRUM_TRY(accelerator_peak_run(t->accelerator, &operations, error));
    const double ran = clock_seconds() - began;

    // the first of each also compiles
    if (b > 0) {
      best = fmin(best, took);
      peak = fmin(peak, ran);
    }
  }
  bench->body_steps = (double)bench->bodies * (double)bench->steps / best;
  bench->gflops = 1e-9 * bench->body_steps * bench->operations;
  bench->peak_gflops = 1e-9 * operations / peak;
  return thrum_crowd_get(t->crowd, t->end, NULL, model->rank, error);
}

// the same steps by thrum_step
static thrum_status compare(const thrum_model *model, bench_accelerator *bench, const throng *t,
                            thrum_error *error) {
  const int64_t r = model->rank, count = bench->bodies < COMPARED ? bench->bodies : COMPARED;
  double most = 0, off = 0, q[THRUM_RANK_MAX];
  thrum_state_def def = bench->step.def;
  def.tolerance = 1e-13;
  for (int64_t n = 0; n < count; n++) {
    thrum_state *state;
    THRUM_TRY(thrum_state_create(model, &def, &state, error));
    thrum_status status = thrum_state_set(model, state, NULL, t->start + n * r, error);
    for (int64_t k = 0; k < bench->steps && status >= 0; k++)
      status = thrum_step(model, state, error);
    THRUM_THEN(status, thrum_state_get(model, state, q, NULL, error));
    thrum_state_destroy(state);
    if (status < 0)
      return status;
    for (int64_t i = 0; i < r; i++) {
      most = fmax(most, fabs(q[i]));
      off = fmax(off, fabs(q[i] - t->end[n * r + i]));
    }
  }
  bench->error = most > 0 ? off / most : 0;
  return THRUM_OK;
}

thrum_status bench_accelerator_run(const thrum_model *model, bench_accelerator *bench,
                                   thrum_error *error) {
  throng t = {0};
  bench->steps = bench->step.steps > 0 ? bench->step.steps : STEPS;
  thrum_status status = THRUM_OK;
  if (bench->step.implicit_wanted >= 0)
    status = bench_step_choose_dt(model, &bench->step, error);
  THRUM_THEN(status, make(model, bench, &t, error));
  THRUM_THEN(status, measure(model, bench, &t, error));
  THRUM_THEN(status, compare(model, bench, &t, error));
  thrum_crowd_destroy(t.crowd);
  thrum_accelerator_destroy(t.accelerator);
  thrum_scope_free(&t.memory);
  return status < 0 ? status : THRUM_OK;
}
