/* Sums in 8 lanes, i mod 8, that are added as a fixed tree (core/polynomial/kernel_private.h).
 * Private to Thrum's libraries. Those over the modes of a step are no passes of a kernel: what is
 * summed has mostly just been written, two numbers at a time, and a wide load would wait for all of
 * them. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_LANE_SUMS_H
#define THRUM_CORE_BASE_LANE_SUMS_H

#include <stddef.h>
#include <stdint.h>

static inline double thrum_lanes_sum(const double lane[8]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/* a_i b_i w_i; w NULL: a_i b_i. */
static inline double thrum_sum_term(const double *a, const double *b, const double *w, int64_t i) {
  return w ? a[i] * b[i] * w[i] : a[i] * b[i];
}

/* ADD(lane, i) for every i < n, the rest two by two so that every lane has its place in a register.
 */
#define THRUM_LANES_EACH(n, ADD)                                                                   \
  do {                                                                                             \
    int64_t each_ = 0;                                                                             \
    for (; each_ + 8 <= (n); each_ += 8)                                                           \
      for (int64_t lane_ = 0; lane_ < 8; lane_++)                                                  \
        ADD(lane_, each_ + lane_);                                                                 \
    const int64_t left_ = (n)-each_;                                                               \
    if (left_ >= 2) {                                                                              \
      ADD(0, each_);                                                                               \
      ADD(1, each_ + 1);                                                                           \
    }                                                                                              \
    if (left_ >= 4) {                                                                              \
      ADD(2, each_ + 2);                                                                           \
      ADD(3, each_ + 3);                                                                           \
    }                                                                                              \
    if (left_ >= 6) {                                                                              \
      ADD(4, each_ + 4);                                                                           \
      ADD(5, each_ + 5);                                                                           \
    }                                                                                              \
    if (left_ == 1)                                                                                \
      ADD(0, each_);                                                                               \
    if (left_ == 3)                                                                                \
      ADD(2, each_ + 2);                                                                           \
    if (left_ == 5)                                                                                \
      ADD(4, each_ + 4);                                                                           \
    if (left_ == 7)                                                                                \
      ADD(6, each_ + 6);                                                                           \
  } while (0)

/* The sum of n of them. */
static inline double thrum_sum_of(int64_t n, const double *a, const double *b, const double *w) {
  double lane[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
#define ADD(s, i) lane[s] += thrum_sum_term(a, b, w, i)
  THRUM_LANES_EACH(n, ADD);
#undef ADD
  return thrum_lanes_sum(lane);
}

/* The sum of (a_i + b_i) c_i. */
static inline double thrum_sum_both(int64_t n, const double *a, const double *b, const double *c) {
  double lane[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
#define ADD(s, i) lane[s] += (a[i] + b[i]) * c[i]
  THRUM_LANES_EACH(n, ADD);
#undef ADD
  return thrum_lanes_sum(lane);
}

/* The sum of (a_i - b_i) c_i. */
static inline double thrum_sum_less(int64_t n, const double *a, const double *b, const double *c) {
  double lane[8] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
#define ADD(s, i) lane[s] += (a[i] - b[i]) * c[i]
  THRUM_LANES_EACH(n, ADD);
#undef ADD
  return thrum_lanes_sum(lane);
}

#endif
