/* Measurements of an accelerator, for `thrum bench accelerator`. SPDX-License-Identifier:
 * Apache-2.0
 */
#ifndef THRUM_BENCH_MEASURE_ACCELERATOR_H
#define THRUM_BENCH_MEASURE_ACCELERATOR_H

#include "bench/measure.h"
#include "thrum/accelerator.h"

/* A crowd on an accelerator (thrum/accelerator.h), each body with another swing. */
typedef struct bench_accelerator {
  bench_step step; /* what is asked for; of the results only dt */
  int64_t bodies;
  int32_t device, single; /* thrum_accelerator_def */
  int64_t steps;          /* of a batch */
  thrum_accelerator_info info;
  double body_steps;          /* a second, of the wall */
  double operations;          /* of the products with coefficients, in a step of a body */
  double gflops, peak_gflops; /* of these products, and of the device */
  double error; /* largest difference of q from that of thrum_step, over the largest q */
} bench_accelerator;

thrum_status bench_accelerator_run(const thrum_model *model, bench_accelerator *bench,
                                   thrum_error *error);

/* The whole mesh of a model on an accelerator, by the midpoint rule, beside the full-order body. */
typedef struct bench_mesh_body {
  bench_step step;        /* dt, swing, batches and steps are read */
  int32_t device, single; /* thrum_accelerator_def */
  int64_t steps;          /* of a batch */
  thrum_accelerator_info info;
  int64_t vertices, tets;
  double iterations, solver_iterations; /* a step: of Newton, of conjugate gradients */
  double ms,
      ms_here;  /* a step, of the wall: there, and by one core with a sparse Cholesky factor */
  double error; /* largest difference of both ends, over the largest displacement */
} bench_mesh_body;

thrum_status bench_mesh_body_run(const thrum_model *model, bench_mesh_body *bench,
                                 thrum_error *error);

#endif
