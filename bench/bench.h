/* Measurements of the runtime's speed, for `thrum bench`: each fills a result and prints nothing.
 * Times are of a monotonic clock in microseconds, the minimum and the median of the repetitions;
 * what is compared alternates within one run, because times of two runs are not comparable.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_BENCH_H
#define THRUM_BENCH_BENCH_H

#include <stdint.h>

#include "thrum/thrum.h"

typedef struct bench_time {
  double minimum; /* [us] */
  double median;  /* [us] */
} bench_time;

/* Now [us]. */
double bench_now(void);

/* The time that the processor has given this thread [us]: what others run does not count. */
double bench_processor_now(void);

/* Minimum and median of `count` >= 1 samples, which are sorted. */
bench_time bench_summary(double *samples, int64_t count);

/* Name of this machine's processor, as the system says; static storage. */
const char *bench_processor(void);

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
