/* Measurements of the runtime's speed, for `thrum bench`: each fills a result and prints nothing.
 * Times are in microseconds, the minimum and the median of the repetitions. Variants that are
 * compared alternate within one run, because times of two runs are not comparable.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MEASURE_H
#define THRUM_BENCH_MEASURE_H

#include <stdbool.h>
#include <stdint.h>

#include "bench/bench.h"
#include "thrum/thrum.h"

typedef struct bench_step {
  thrum_state_def def; /* dt is replaced when implicit_wanted >= 0 */
  int implicit_wanted; /* exactly so many implicit modes, by choosing dt; -1: dt as it is */
  double swing;        /* of the first mode, if it were linear and alone [m] */
  int64_t batches;     /* >= 1 */
  int64_t steps;       /* of a batch; 0: about 5 ms of them */
  bench_time time;     /* of a step */
  double dt;           /* [s] */
  double iterations;   /* a step */
  double factorisations;
  int32_t implicit_modes;
  int64_t steps_measured; /* of a batch */
  double operations;      /* of a step's passes over coefficients, without the stability monitor */
  double coefficients;    /* that they read */
} bench_step;

thrum_status bench_step_run(const thrum_model *model, bench_step *bench, thrum_error *error);

/* Refuses more implicit modes than there are. */
thrum_status bench_check_implicit(int64_t rank, int64_t wanted, thrum_error *error);

/* def.dt for the implicit modes wanted; the momentum (rank) of the state at its start; the state
 * there. */
thrum_status bench_step_choose_dt(const thrum_model *model, bench_step *bench, thrum_error *error);
thrum_status bench_step_momentum(const thrum_model *model, const bench_step *bench, double *p,
                                 thrum_error *error);
thrum_status bench_step_start(const thrum_model *model, const bench_step *bench, thrum_state *state,
                              thrum_error *error);

/* Many bodies of one model, each with another swing, stepped one by one and together in turns. */
typedef struct bench_batch {
  bench_step step; /* what is asked for; of the results only dt */
  int64_t bodies;
  bench_time alone;    /* thrum_step, of one step of one body */
  bench_time together; /* thrum_batch_step, likewise */
  double iterations;   /* a step */
  int32_t implicit_modes;
  double state_bytes, workspace_bytes;
  bool same_bits; /* both ways ended in the same states */
} bench_batch;

thrum_status bench_batch_run(const thrum_model *model, bench_batch *bench, thrum_error *error);

typedef struct bench_kernels {
  thrum_kernel_id kernel; /* in: asked for; out: used */
  int64_t implicit;       /* |I| of the last two passes */
  int64_t batches;
  bench_time time[THRUM_PASS_COUNT];
  double operations[THRUM_PASS_COUNT];   /* of a pass */
  double coefficients[THRUM_PASS_COUNT]; /* that it reads */
} bench_kernels;

/* Bytes of a coefficient as the model has them packed. */
static inline double bench_coefficient_bytes(const thrum_model *model) {
  return model->packed_single ? (double)sizeof(float) : (double)sizeof(double);
}

/* Terms of degree 3 and 4 of so many coordinates. */
double bench_terms(int64_t rank);

thrum_status bench_kernels_run(const thrum_model *model, bench_kernels *bench, thrum_error *error);

/* u = U q of a body of random numbers. */
typedef struct bench_displacement {
  int64_t vertices, rank, repetitions;
  bench_time dgemv;         /* OpenBLAS on one thread, the same U in double precision */
  bench_time dgemv_columns; /* the same with U stored column by column */
  bench_time plain;         /* thrum_displacement, all vertices, double precision */
  bench_time surface;       /* thrum_surface_positions, rest positions added, stride 3 */
  bench_time normals;       /* thrum_surface_normals, about two triangles a vertex */
  double ratio;             /* surface over dgemv, minima */
  double ratio_columns;     /* surface over dgemv_columns, minima */
  double ratio_median;      /* the same, medians */
  double bytes_surface;     /* of U as the surface holds it */
  double difference;        /* largest |surface - dgemv|, over the largest displacement */
} bench_displacement;

/* Fills what the first three fields ask for. */
thrum_status bench_displacement_run(bench_displacement *bench, thrum_error *error);

#endif
