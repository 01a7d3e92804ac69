/* How long `thrum precompute` takes against the size of the mesh and the rank, for `thrum bench
 * precompute`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MEASURE_PIPELINE_H
#define THRUM_BENCH_MEASURE_PIPELINE_H

#include "precompute/precompute.h"

/* One run on a clamped beam of cubic cells, 3.5 times as long as thick, in a process of its own, so
 * that its memory is its own; then, in another one, the Gram product's DSYRK alone. */
typedef struct bench_pipeline {
  int64_t wanted; /* tets */
  int64_t modes, rank;
  int threads;
  bool syrk; /* time the DSYRK too: 6 tets x (rank + rank (rank + 1) / 2) doubles of memory */
  int64_t tets, free_dofs, factor_nonzeros;
  double seconds[THRUM_STAGE_COUNT], cpu_seconds[THRUM_STAGE_COUNT], flops[THRUM_STAGE_COUNT];
  double total, cpu_total; /* of the stages [s] */
  double peak_mb;
  double syrk_seconds, syrk_cpu_seconds; /* one DSYRK of that size, by one call; NaN: not timed */
} bench_pipeline;

/* Fills what the first five fields ask for. */
thrum_status bench_pipeline_run(bench_pipeline *bench, thrum_error *error);

/* Exponent p of y ~ x^p by least squares in logarithms over `count` points; NaN below two. */
double bench_exponent(const double *x, const double *y, int64_t count);

#endif
