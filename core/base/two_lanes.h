/* Two numbers at a time, in a register where every processor of the kind has one (SSE2 on x86-64),
 * and products of three rows with vectors that sum in 4 lanes, i mod 4. What is left of a row goes
 * into the first lane. The lanes are added as (0 + 2) + (1 + 3), so the bits are the same on every
 * machine (docs/determinism.md). Private to Thrum's libraries.
 * Cost: 3 n multiplications and additions, two at a time.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_TWO_LANES_H
#define THRUM_CORE_BASE_TWO_LANES_H

#include <stdint.h>

#if defined(__SSE2__) && !defined(THRUM_TWO_LANES_PLAIN)

#include <emmintrin.h>

typedef __m128d thrum_two;

static inline thrum_two thrum_two_all(double x) {
  return _mm_set1_pd(x);
}

static inline thrum_two thrum_two_load(const double *p) {
  return _mm_loadu_pd(p);
}

static inline void thrum_two_store(double *p, thrum_two v) {
  _mm_storeu_pd(p, v);
}

static inline thrum_two thrum_two_add(thrum_two v, thrum_two w) {
  return _mm_add_pd(v, w);
}

static inline thrum_two thrum_two_multiply(thrum_two v, thrum_two w) {
  return _mm_mul_pd(v, w);
}

#else

typedef struct thrum_two {
  double a, b;
} thrum_two;

static inline thrum_two thrum_two_all(double x) {
  return (thrum_two){x, x};
}

static inline thrum_two thrum_two_load(const double *p) {
  return (thrum_two){p[0], p[1]};
}

static inline void thrum_two_store(double *p, thrum_two v) {
  p[0] = v.a;
  p[1] = v.b;
}

static inline thrum_two thrum_two_add(thrum_two v, thrum_two w) {
  return (thrum_two){v.a + w.a, v.b + w.b};
}

static inline thrum_two thrum_two_multiply(thrum_two v, thrum_two w) {
  return (thrum_two){v.a * w.a, v.b * w.b};
}

#endif

/* sum += p q */
static inline void thrum_two_gather(thrum_two *sum, thrum_two p, thrum_two q) {
  *sum = thrum_two_add(*sum, thrum_two_multiply(p, q));
}

/* (0 + 2) + (1 + 3) of the lanes 0, 1 and 2, 3. */
static inline double thrum_two_sum(thrum_two low, thrum_two high) {
  double both[2];
  thrum_two_store(both, thrum_two_add(low, high));
  return both[0] + both[1];
}

/* Row `axis` of rows of n; those of a solid, which has no coordinates, are NULL. */
static inline const double *thrum_rows_row(const double *rows, int64_t n, int axis) {
  return n > 0 ? rows + axis * n : rows;
}

/* u = rows x, of three rows of n that follow each other. */
static inline void thrum_rows_times(int64_t n, const double *rows, const double *x, double u[3]) {
  const double *second = thrum_rows_row(rows, n, 1), *third = thrum_rows_row(rows, n, 2);
  thrum_two sum[6];
  double rest[3] = {0.0, 0.0, 0.0};
  int64_t i = 0;
  for (int k = 0; k < 6; k++)
    sum[k] = thrum_two_all(0.0);
  for (; i + 4 <= n; i += 4) {
    const thrum_two low = thrum_two_load(x + i), high = thrum_two_load(x + i + 2);
    thrum_two_gather(sum + 0, thrum_two_load(rows + i), low);
    thrum_two_gather(sum + 1, thrum_two_load(rows + i + 2), high);
    thrum_two_gather(sum + 2, thrum_two_load(second + i), low);
    thrum_two_gather(sum + 3, thrum_two_load(second + i + 2), high);
    thrum_two_gather(sum + 4, thrum_two_load(third + i), low);
    thrum_two_gather(sum + 5, thrum_two_load(third + i + 2), high);
  }

  // what no four are left of
  for (; i < n; i++) {
    rest[0] += rows[i] * x[i];
    rest[1] += second[i] * x[i];
    rest[2] += third[i] * x[i];
  }
  for (int axis = 0; axis < 3; axis++)
    u[axis] = thrum_two_sum(sum[2 * axis], sum[2 * axis + 1]) + rest[axis];
}

/* u = rows x and v = rows y at once, with the bits of two calls of thrum_rows_times. */
static inline void thrum_rows_times_both(int64_t n, const double *rows, const double *x,
                                         const double *y, double u[3], double v[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const double *row = thrum_rows_row(rows, n, axis);
    thrum_two sum[4];
    double rest[2] = {0.0, 0.0};
    int64_t i = 0;
    for (int k = 0; k < 4; k++)
      sum[k] = thrum_two_all(0.0);
    for (; i + 4 <= n; i += 4) {
      const thrum_two low = thrum_two_load(row + i), high = thrum_two_load(row + i + 2);
      thrum_two_gather(sum + 0, low, thrum_two_load(x + i));
      thrum_two_gather(sum + 1, high, thrum_two_load(x + i + 2));
      thrum_two_gather(sum + 2, low, thrum_two_load(y + i));
      thrum_two_gather(sum + 3, high, thrum_two_load(y + i + 2));
    }

    // what no four are left of
    for (; i < n; i++) {
      rest[0] += row[i] * x[i];
      rest[1] += row[i] * y[i];
    }
    u[axis] = thrum_two_sum(sum[0], sum[1]) + rest[0];
    v[axis] = thrum_two_sum(sum[2], sum[3]) + rest[1];
  }
}

/* x_i += w_i (rows^T f)_i; w NULL: 1. */
static inline void thrum_rows_push(int64_t n, const double *rows, const double f[3],
                                   const double *w, double *x) {
  const double *second = thrum_rows_row(rows, n, 1), *third = thrum_rows_row(rows, n, 2);
  const thrum_two f0 = thrum_two_all(f[0]), f1 = thrum_two_all(f[1]), f2 = thrum_two_all(f[2]);
  int64_t i = 0;
  for (; i + 2 <= n; i += 2) {
    thrum_two sum = thrum_two_multiply(thrum_two_load(rows + i), f0);
    thrum_two_gather(&sum, thrum_two_load(second + i), f1);
    thrum_two_gather(&sum, thrum_two_load(third + i), f2);
    if (w)
      sum = thrum_two_multiply(thrum_two_load(w + i), sum);
    thrum_two_store(x + i, thrum_two_add(thrum_two_load(x + i), sum));
  }
  for (; i < n; i++) {
    const double sum = rows[i] * f[0] + second[i] * f[1] + third[i] * f[2];
    x[i] += w ? w[i] * sum : sum;
  }
}

/* out = rows diag(w) rows^T, 3 x 3. */
static inline void thrum_rows_square(int64_t n, const double *rows, const double *w,
                                     double out[9]) {
  static const int pairs[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};
  const double *second = thrum_rows_row(rows, n, 1), *third = thrum_rows_row(rows, n, 2);
  thrum_two sum[6];
  double rest[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  int64_t i = 0;
  for (int k = 0; k < 6; k++)
    sum[k] = thrum_two_all(0.0);
  for (; i + 2 <= n; i += 2) {
    const thrum_two weight = thrum_two_load(w + i), a = thrum_two_load(rows + i);
    const thrum_two b = thrum_two_load(second + i), c = thrum_two_load(third + i);
    const thrum_two wa = thrum_two_multiply(weight, a), wb = thrum_two_multiply(weight, b);
    thrum_two_gather(sum + 0, wa, a);
    thrum_two_gather(sum + 1, wa, b);
    thrum_two_gather(sum + 2, wa, c);
    thrum_two_gather(sum + 3, wb, b);
    thrum_two_gather(sum + 4, wb, c);
    thrum_two_gather(sum + 5, thrum_two_multiply(weight, c), c);
  }

  // an odd one, then both halves of the symmetric matrix
  for (; i < n; i++)
    for (int k = 0; k < 6; k++)
      rest[k] += w[i] * rows[pairs[k][0] * n + i] * rows[pairs[k][1] * n + i];
  for (int k = 0; k < 6; k++) {
    double both[2];
    thrum_two_store(both, sum[k]);
    out[3 * pairs[k][0] + pairs[k][1]] = out[3 * pairs[k][1] + pairs[k][0]] =
        both[0] + both[1] + rest[k];
  }
}

#endif
