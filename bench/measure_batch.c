/* Many bodies of one model on one core: thrum_step for each against thrum_batch_step for all. Both
 * start from the same snapshots and take turns, so that each finds the machine as the other does.
 * Times are the processor's: a pass over the bodies is long, and others may run meanwhile.
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "bench/measure.h"
#include "core/base/alignment_check.h"
#include "platform/allocate.h"
#include "platform/clock.h"

#define WARM_STEPS 40
#define STEPS 20

/* The bodies' blocks, one after the other, twice, and what they start from. */
typedef struct herd {
  const thrum_model *model;
  int64_t bodies, steps;
  size_t stride, workspace_size;
  unsigned char *alone, *together, *snapshot;
  void *workspace;
  thrum_state **states; /* of `together` */
  double *samples;
  thrum_scope memory;
} herd;

static thrum_state *body(unsigned char *blocks, const herd *h, int64_t n) {
  return (thrum_state *)(void *)(blocks + (size_t)n * h->stride);
}

static thrum_status herd_make(const thrum_model *model, const bench_batch *bench, herd *h,
                              thrum_error *error) {
  // the sizes of a state and of the workspace
  size_t size = 0;
  thrum_status status = thrum_state_size(model, &bench->step.def, &size, error);
  THRUM_THEN(status, thrum_batch_size(model, &h->workspace_size, error));
  if (status < 0)
    return status;

  // each body has a state of its own
  h->model = model;
  h->bodies = bench->bodies;
  h->steps = bench->step.steps > 0 ? bench->step.steps : STEPS;
  h->stride = thrum_round_up(size);

  // memory for bodies that step alone, for those that step together, and for the start of both
  const size_t count = (size_t)h->bodies;
  h->memory = thrum_scope_begin("the bodies", error);
  h->alone = thrum_scope_allocate_aligned(&h->memory, count * h->stride);
  h->together = thrum_scope_allocate_aligned(&h->memory, count * h->stride);
  h->snapshot = thrum_scope_allocate_aligned(&h->memory, count * h->stride);
  h->workspace = thrum_scope_allocate_aligned(&h->memory, h->workspace_size);
  h->states = thrum_scope_allocate(&h->memory, h->bodies, sizeof *h->states);
  h->samples =
      thrum_scope_allocate(&h->memory, 2 * h->steps * bench->step.batches, sizeof *h->samples);
  THRUM_TRY(h->memory.status);

  // every body starts with a swing of its own
  memset(h->snapshot, 0, count * h->stride);
  for (int64_t n = 0; n < h->bodies && status >= 0; n++) {
    thrum_state *state = NULL;
    status = thrum_state_init(h->snapshot + (size_t)n * h->stride, size, model, &bench->step.def,
                              &state, error);
    // bodies swing by half of the swing up to all of it
    bench_step start = bench->step;
    start.swing *= 0.5 + 0.5 * (double)(n + 1) / (double)h->bodies;
    THRUM_THEN(status, bench_step_start(model, &start, state, error));
    for (int k = 0; k < WARM_STEPS && status >= 0; k++)
      status = thrum_step(model, state, error);
    h->states[n] = body(h->together, h, n);
  }

  return status;
}

/* One step of every body, and its time for one body. */
static thrum_status step_alone(herd *h, double *sample, thrum_error *error) {
  thrum_status status = THRUM_OK;
  const double began = clock_thread_seconds();
  for (int64_t n = 0; n < h->bodies && status >= 0; n++)
    status = thrum_step(h->model, body(h->alone, h, n), error);
  *sample = 1e6 * (clock_thread_seconds() - began) / (double)h->bodies;
  return status;
}

static thrum_status step_together(herd *h, double *sample, thrum_error *error) {
  const double began = clock_thread_seconds();
  const thrum_status status = thrum_batch_step(h->model, h->states, h->bodies, NULL, h->workspace,
                                               h->workspace_size, error);
  *sample = 1e6 * (clock_thread_seconds() - began) / (double)h->bodies;
  return status;
}

/* The minimum and the median of each step over the batches, and the means of those over the steps:
 * a step is short enough to be left undisturbed once, a batch is not. */
static bench_time mean_summary(double *samples, int64_t steps, int64_t batches) {
  bench_time mean = {0, 0};
  for (int64_t k = 0; k < steps; k++) {
    const bench_time time = bench_summary(samples + k * batches, batches);
    mean.minimum += time.minimum / (double)steps;
    mean.median += time.median / (double)steps;
  }
  return mean;
}

static thrum_status measure(herd *h, bench_batch *bench, thrum_error *error) {
  const size_t bytes = (size_t)h->bodies * h->stride;
  const double steps = (double)(h->steps * h->bodies);
  const int64_t batches = bench->step.batches;
  double *alone = h->samples, *together = h->samples + h->steps * batches;

  // both ways step in turns from the same snapshot
  for (int64_t b = 0; b < batches; b++) {
    thrum_status status = THRUM_OK;
    memcpy(h->alone, h->snapshot, bytes);
    memcpy(h->together, h->snapshot, bytes);
    for (int64_t k = 0; k < h->steps && status >= 0; k++) {
      status = step_alone(h, alone + k * batches + b, error);
      THRUM_THEN(status, step_together(h, together + k * batches + b, error));
    }
    if (status < 0)
      return status;
  }

  bench->alone = mean_summary(alone, h->steps, batches);
  bench->together = mean_summary(together, h->steps, batches);
  bench->same_bits = true;
  bench->iterations = 0;

  // both ways must end in the same bits
  for (int64_t n = 0; n < h->bodies; n++) {
    const thrum_state *alone_n = body(h->alone, h, n), *together_n = body(h->together, h, n);
    if (memcmp(alone_n, together_n, thrum_state_kept_bytes(alone_n)) != 0)
      bench->same_bits = false;
    const thrum_state_report before = thrum_state_report_get(body(h->snapshot, h, n));
    const thrum_state_report after = thrum_state_report_get(body(h->together, h, n));
    bench->iterations += (double)(after.iterations - before.iterations) / steps;
    bench->implicit_modes = after.implicit_modes;
  }
  bench->step.dt = bench->step.def.dt;
  bench->state_bytes = (double)h->stride;
  bench->workspace_bytes = (double)h->workspace_size;
  return THRUM_OK;
}

thrum_status bench_batch_run(const thrum_model *model, bench_batch *bench, thrum_error *error) {
  herd h;
  memset(&h, 0, sizeof h);
  thrum_status status = THRUM_OK;
  if (bench->step.implicit_wanted >= 0)
    status = bench_step_choose_dt(model, &bench->step, error);
  THRUM_THEN(status, herd_make(model, bench, &h, error));
  THRUM_THEN(status, measure(&h, bench, error));
  thrum_scope_free(&h.memory);
  return status < 0 ? status : THRUM_OK;
}
