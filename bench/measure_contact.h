/* Measures the cost of contact between many bodies, for `thrum bench contact`.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_MEASURE_CONTACT_H
#define THRUM_BENCH_MEASURE_CONTACT_H

#include "bench/bench.h"
#include "thrum/thrum.h"

/* The scenes that take turns: the bodies fall side by side and pass through each other, or could
 * touch and are apart, or the first of them lie in pairs on each other. */
typedef enum bench_contact_scene {
  BENCH_CONTACT_NONE = 0,
  BENCH_CONTACT_APART = 1,
  BENCH_CONTACT_TOUCHING = 2,
  BENCH_CONTACT_SCENES = 3
} bench_contact_scene;

/* A free model with its surface, and what is asked for; then a step of all bodies. */
typedef struct bench_contact {
  const thrum_model *model;
  const int32_t *triangles; /* triangle_count x 3: vertices of the model */
  int64_t triangle_count;
  int64_t bodies, pairs; /* at least 2 x pairs bodies */
  int32_t threads;
  double dt; /* [s] */
  int64_t steps;
  bench_time time[BENCH_CONTACT_SCENES]; /* of a step of the scene */
  double touches;                        /* between bodies, a step of the last scene */
  double sweeps;                         /* the same */
} bench_contact;

thrum_status bench_contact_run(bench_contact *bench, thrum_error *error);

#endif
