/* Vectors of 3 and matrices of 3 x 3, row-major, and boxes of points. Private to Thrum's libraries.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_VEC3_H
#define THRUM_CORE_BASE_VEC3_H

#include <math.h>
#include <stdint.h>

static inline double thrum_dot3(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void thrum_cross3(const double a[3], const double b[3], double out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void thrum_subtract3(const double a[3], const double b[3], double out[3]) {
  for (int i = 0; i < 3; i++)
    out[i] = a[i] - b[i];
}

/* a . (b x c); of three edges from a corner of a tetrahedron six times its signed volume. */
static inline double thrum_triple3(const double a[3], const double b[3], const double c[3]) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The edges of a tetrahedron from its first corner; `v`: its corners among the vertices. */
static inline void thrum_tet_edges(const double *vertices, const int32_t v[4], double edges[3][3]) {
  for (int a = 0; a < 3; a++)
    thrum_subtract3(vertices + 3 * (int64_t)v[a + 1], vertices + 3 * (int64_t)v[0], edges[a]);
}

/* The box of `count` points (x, y, z). */
static inline void thrum_box3(const double *points, int64_t count, double least[3],
                              double most[3]) {
  for (int axis = 0; axis < 3; axis++) {
    least[axis] = INFINITY;
    most[axis] = -INFINITY;
    for (int64_t n = 0; n < count; n++) {
      least[axis] = fmin(least[axis], points[3 * n + axis]);
      most[axis] = fmax(most[axis], points[3 * n + axis]);
    }
  }
}

/* Length of the diagonal of their box. */
static inline double thrum_box3_diagonal(const double *points, int64_t count) {
  double least[3], most[3], square = 0.0;
  thrum_box3(points, count, least, most);
  for (int axis = 0; axis < 3; axis++)
    square += (most[axis] - least[axis]) * (most[axis] - least[axis]);
  return sqrt(square);
}

/* Length of its longest side. */
static inline double thrum_box3_longest(const double *points, int64_t count) {
  double least[3], most[3], longest = 0.0;
  thrum_box3(points, count, least, most);
  for (int axis = 0; axis < 3; axis++)
    longest = fmax(longest, most[axis] - least[axis]);
  return longest;
}

/* y = A x */
static inline void thrum_apply3(const double a[9], const double x[3], double y[3]) {
  for (int i = 0; i < 3; i++)
    y[i] = thrum_dot3(a + 3 * i, x);
}

/* y = A^T x */
static inline void thrum_apply3_transposed(const double a[9], const double x[3], double y[3]) {
  for (int i = 0; i < 3; i++)
    y[i] = a[i] * x[0] + a[3 + i] * x[1] + a[6 + i] * x[2];
}

/* out = A B */
static inline void thrum_multiply3(const double a[9], const double b[9], double out[9]) {
  for (int i = 0; i < 3; i++)
    thrum_apply3_transposed(b, a + 3 * i, out + 3 * i);
}

/* Solves A x = b by elimination with pivots; false where A is singular. */
static inline int thrum_solve3(const double a[9], const double b[3], double x[3]) {
  // the right-hand side is eliminated as a fourth column
  double m[3][4];
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++)
      m[i][j] = a[3 * i + j];
    m[i][3] = b[i];
  }

  // the largest entry of the column as pivot keeps the factors below one
  for (int pivot = 0; pivot < 3; pivot++) {
    int best = pivot;
    for (int i = pivot + 1; i < 3; i++)
      if (m[i][pivot] * m[i][pivot] > m[best][pivot] * m[best][pivot])
        best = i;

    for (int j = 0; j < 4; j++) {
      const double swap = m[pivot][j];
      m[pivot][j] = m[best][j];
      m[best][j] = swap;
    }
    if (m[pivot][pivot] == 0.0)
      return 0;

    for (int i = pivot + 1; i < 3; i++) {
      const double factor = m[i][pivot] / m[pivot][pivot];
      for (int j = pivot; j < 4; j++)
        m[i][j] -= factor * m[pivot][j];
    }
  }

  // the triangle that is left gives x from its last row up
  for (int i = 2; i >= 0; i--) {
    double sum = m[i][3];
    for (int j = i + 1; j < 3; j++)
      sum -= m[i][j] * x[j];
    x[i] = sum / m[i][i];
  }
  return 1;
}

#endif
