/* Sums over the modes of a step, private to the runtime: in 8 lanes, i mod 8, that are added as
 * those of a kernel (runtime/kernel.h). Not a pass of one: what is summed has mostly just been
 * written, two numbers at a time, and a wide load would wait for all of them.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_SUMS_H
#define THRUM_RUNTIME_SUMS_H

#include <stddef.h>
#include <stdint.h>

/* a_i b_i w_i; w NULL: a_i b_i. */
static inline double thrum_sum_term(const double *a, const double *b, const double *w, int32_t i) {
  return w ? a[i] * b[i] * w[i] : a[i] * b[i];
}

/* Their sum over n modes. */
static inline double thrum_sum_of(int32_t n, const double *a, const double *b, const double *w) {
  double lane[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  int32_t i = 0;
  for (; i + 8 <= n; i += 8)
    for (int32_t s = 0; s < 8; s++)
      lane[s] += thrum_sum_term(a, b, w, i + s);
  // the rest two by two, so that every lane has its place in a register
  const int32_t left = n - i;
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
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

#endif
