/* Time of each pass over the coefficients, by any kernel. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/measure.h"
#include "platform/allocate.h"
#include "platform/clock.h"

#define BATCH_US 1000.0
#define CALLS_MOST 5000.0

typedef struct passes {
  const thrum_model *model;
  thrum_kernel_id kernel;
  int32_t explicit_modes;
  double *q, *v, *result, *work;
} passes;

static void run_pass(const passes *p, int pass) {
  thrum_pass_run(p->model, p->kernel, (thrum_pass)pass, p->explicit_modes, p->q, p->v, p->result,
                 p->work, NULL);
}

/* One batch of each pass in turn, so that a slow moment of the machine meets all of them. */
static void measure(const passes *p, int64_t batches, double *samples, bench_kernels *bench) {
  double calls[THRUM_PASS_COUNT];

  // a batch of each pass takes about BATCH_US
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
    run_pass(p, pass);
    const double began = clock_thread_seconds();
    run_pass(p, pass);
    calls[pass] =
        fmin(CALLS_MOST, ceil(BATCH_US / (1e6 * (clock_thread_seconds() - began) + 1e-3)));
  }

  for (int64_t n = 0; n < batches; n++)
    for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
      const double began = clock_thread_seconds();
      for (int64_t k = 0; k < (int64_t)calls[pass]; k++)
        run_pass(p, pass);
      samples[pass * batches + n] = 1e6 * (clock_thread_seconds() - began) / calls[pass];
    }
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++)
    bench->time[pass] = bench_summary(samples + pass * batches, batches);
}

double bench_terms(int64_t rank) {
  return (double)(thrum_c3_count(rank) + thrum_c4_count(rank));
}

thrum_status bench_kernels_run(const thrum_model *model, bench_kernels *bench, thrum_error *error) {
  const int64_t r = model->rank, n = bench->implicit < r ? bench->implicit : r;
  const size_t doubles = 2 * (size_t)r + thrum_pass_result_count(model) + thrum_work_count(model) +
                         THRUM_PASS_COUNT * (size_t)bench->batches;
  double *memory = thrum_allocate_aligned(doubles * sizeof *memory, "a measurement", error);
  if (!memory)
    return THRUM_OUT_OF_MEMORY;
  memset(memory, 0, doubles * sizeof *memory);
  passes p = {.model = model, .kernel = thrum_kernel_chosen(bench->kernel)};

  // the kernels' scratch first, where it is aligned
  p.work = memory;
  p.q = p.work + thrum_work_count(model);
  p.v = p.q + r;
  p.result = p.v + r;
  p.explicit_modes = (int32_t)(r - n);
  for (int64_t i = 0; i < r; i++) {
    p.q[i] = 1.0 / (double)(i + 1);
    p.v[i] = 1.0 / (double)(i + 2);
  }

  bench->kernel = p.kernel;
  bench->implicit = n;
  measure(&p, bench->batches, p.result + thrum_pass_result_count(model), bench);
  for (int pass = 0; pass < THRUM_PASS_COUNT; pass++) {
    const thrum_pass_cost cost = thrum_pass_cost_of(r, (thrum_pass)pass, r - n);
    bench->coefficients[pass] = cost.coefficients;
    bench->operations[pass] = cost.operations;
  }
  free(memory);
  return THRUM_OK;
}
