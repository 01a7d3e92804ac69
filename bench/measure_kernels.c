/* Time of each pass over the coefficients, by any kernel. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/measure.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "runtime/polynomial/polynomial_private.h"

#define BATCH_US 1000.0
#define CALLS_MOST 5000.0
#define PAIRS_OPERATIONS 4.0 /* with a number of those by pairs */

typedef struct passes {
  const thrum_model *model;
  const thrum_kernel *by;
  int32_t split;
  double *q, *v, *force, *tangent, *restricted, *work;
} passes;

static void run_pass(const passes *p, bench_pass pass) {
  // the names of the enum are those of BENCH_PASSES
  switch (pass) {
  case BENCH_PASS_energy:
    p->force[0] = thrum_strain_energy_by(p->by, p->model, p->q, p->work);
    break;
  case BENCH_PASS_force:
    thrum_internal_force_by(p->by, p->model, p->q, p->force, p->work);
    break;
  case BENCH_PASS_tangent:
    thrum_tangent_stiffness_by(p->by, p->model, p->q, p->tangent, p->work);
    break;
  case BENCH_PASS_tangent_vector:
    thrum_tangent_product_by(p->by, p->model, p->q, p->v, p->force, p->work);
    break;

  case BENCH_PASS_restrict:
    thrum_polynomial_restrict(p->by, p->model, p->split, p->q, p->restricted, p->work);
    break;
  default:
    thrum_restricted_hessian(p->by, p->model, p->split, p->restricted, p->q + p->split, p->tangent,
                             p->work);
    break;
  }
}

/* One batch of each pass in turn, so that a slow moment of the machine meets all of them. */
static void measure(const passes *p, int64_t batches, double *samples, bench_kernels *bench) {
  double calls[BENCH_PASS_COUNT];

  // a batch of each pass takes about BATCH_US
  for (int pass = 0; pass < BENCH_PASS_COUNT; pass++) {
    run_pass(p, (bench_pass)pass);
    const double began = clock_seconds();
    run_pass(p, (bench_pass)pass);
    calls[pass] = fmin(CALLS_MOST, ceil(BATCH_US / (1e6 * (clock_seconds() - began) + 1e-3)));
  }

  for (int64_t n = 0; n < batches; n++)
    for (int pass = 0; pass < BENCH_PASS_COUNT; pass++) {
      const double began = clock_seconds();
      for (int64_t k = 0; k < (int64_t)calls[pass]; k++)
        run_pass(p, (bench_pass)pass);
      samples[pass * batches + n] = 1e6 * (clock_seconds() - began) / calls[pass];
    }
  for (int pass = 0; pass < BENCH_PASS_COUNT; pass++)
    bench->time[pass] = bench_summary(samples + pass * batches, batches);
}

double bench_terms(int64_t rank) {
  return (double)(thrum_c3_count(rank) + thrum_c4_count(rank));
}

static double pairs_numbers(int64_t rank) {
  const double pairs = (double)thrum_pack_first(rank);
  return 0.5 * pairs * (pairs + 1.0);
}

double bench_tangent_coefficients(int64_t rank) {
  return thrum_pairs_count(rank) > 0 ? pairs_numbers(rank) : bench_terms(rank);
}

double bench_tangent_operations(int64_t rank) {
  return (thrum_pairs_count(rank) > 0 ? PAIRS_OPERATIONS : 6.0) * bench_tangent_coefficients(rank);
}

/* Counts the operations of the passes and the coefficients that they read, with n of r modes
 * implicit. */
static void count(int64_t r, int64_t n, bench_kernels *bench) {
  static const double each[BENCH_PASS_COUNT] = {
#define X(name, operations, text) operations,
      BENCH_PASSES(X)
#undef X
  };
  for (int pass = 0; pass < BENCH_PASS_COUNT; pass++) {
    double numbers = bench_terms(r);
    if (pass == BENCH_PASS_restricted_tangent)
      numbers = bench_terms(n);
    else if (pass == BENCH_PASS_restrict)
      numbers -= bench_terms(n) + bench_terms(r - n);

    // the tangents may read pairs in place of lists
    double operations = each[pass] * numbers;
    if (pass == BENCH_PASS_tangent) {
      numbers = bench_tangent_coefficients(r);
      operations = bench_tangent_operations(r);
    } else if (pass == BENCH_PASS_tangent_vector && r <= THRUM_PAIRS_VECTOR_RANK_MOST) {
      numbers = pairs_numbers(r);
      operations = PAIRS_OPERATIONS * numbers;
    }
    bench->coefficients[pass] = numbers;
    bench->operations[pass] = operations;
  }
}

thrum_status bench_kernels_run(const thrum_model *model, bench_kernels *bench, thrum_error *error) {
  const int64_t r = model->rank, n = bench->implicit < r ? bench->implicit : r;
  const size_t doubles = (size_t)(3 * r + r * r + thrum_restricted_count(n)) +
                         thrum_work_count(model) + BENCH_PASS_COUNT * (size_t)bench->batches;
  double *memory = thrum_allocate_aligned(doubles * sizeof *memory, "a measurement", error);
  if (!memory)
    return THRUM_OUT_OF_MEMORY;
  memset(memory, 0, doubles * sizeof *memory);
  passes p = {.model = model, .by = thrum_kernel_get((int32_t)bench->kernel)};

  // the kernels' scratch first, where it is aligned
  p.work = memory;
  p.q = p.work + thrum_work_count(model);
  p.v = p.q + r;
  p.force = p.v + r;
  p.tangent = p.force + r;
  p.restricted = p.tangent + r * r;
  p.split = (int32_t)(r - n);

  for (int64_t i = 0; i < r; i++) {
    p.q[i] = 1.0 / (double)(i + 1);
    p.v[i] = 1.0 / (double)(i + 2);
  }
  bench->kernel = p.by->id;
  bench->implicit = n;
  measure(&p, bench->batches, p.restricted + thrum_restricted_count(n), bench);
  count(r, n, bench);
  free(memory);
  return THRUM_OK;
}
