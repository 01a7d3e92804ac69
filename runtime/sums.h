/* Sums in 8 lanes, i mod 8, that are added as a fixed tree (runtime/kernel.h). Private to the
 * runtime. Those over the modes of a step are no passes of a kernel: what is summed has mostly just
 * been written, two numbers at a time, and a wide load would wait for all of them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_SUMS_H
#define THRUM_RUNTIME_SUMS_H

#include <stddef.h>
#include <stdint.h>

static inline double thrum_lanes_sum(const double lane[8]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/* a_i b_i w_i; w NULL: a_i b_i. */
static inline double thrum_sum_term(const double *a, const double *b, const double *w, int64_t i) {
  return w ? a[i] * b[i] * w[i] : a[i] * b[i];
}

/* The sum of n of them. */
static inline double thrum_sum_of(int64_t n, const double *a, const double *b, const double *w) {
  double lane[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  int64_t i = 0;
  for (; i + 8 <= n; i += 8)
    for (int64_t s = 0; s < 8; s++)
      lane[s] += thrum_sum_term(a, b, w, i + s);
  // the rest two by two, so that every lane has its place in a register
  const int64_t left = n - i;
#define ADD(s) lane[s] += thrum_sum_term(a, b, w, i + s)
  if (left >= 2) {
    ADD(0);
    ADD(1);
  }
  if (left >= 4) {
    ADD(2);
    ADD(3);
  }
  if (left >= 6) {
    ADD(4);
    ADD(5);
  }
  if (left == 1)
    ADD(0);
  if (left == 3)
    ADD(2);
  if (left == 5)
    ADD(4);
  if (left == 7)
    ADD(6);
#undef ADD
  return thrum_lanes_sum(lane);
}

#endif
