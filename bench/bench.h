/* Statistics of times and the processor's name, for all measurements.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_BENCH_BENCH_H
#define THRUM_BENCH_BENCH_H

#include <stdint.h>

#include "thrum/thrum.h"

typedef struct bench_time {
  double minimum; /* [us] */
  double median;  /* [us] */
} bench_time;

/* Minimum and median of `count` >= 1 samples, which are sorted. */
bench_time bench_summary(double *samples, int64_t count);

/* Name of this machine's processor, as the system says; static storage. */
const char *bench_processor(void);

#endif
