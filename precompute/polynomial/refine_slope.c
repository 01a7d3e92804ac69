/* Slope of the error of the force in single precision, see refine_slope.h.
 *
 * The same as thrum_refine_objective, whose comment has the mathematics. Points lie side by side,
 * so that the compiler makes vectors of the loops over them; but points of another law are taken
 * one by one, in double precision. Symmetric matrices are xx, yy, zz, xy, yz, zx.
 *
 * Cost: five products of states x 9 points x rank, and 400 operations for each state and point.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/refine_slope.h"

#include <cblas.h>
#include <stddef.h>

#include "precompute/polynomial/quartic_stress.h"

#define ROWS 9 /* components of a gradient */

int64_t thrum_refine_slope_work(int64_t points, int64_t rank, int64_t states) {
  return states * (3 * ROWS * points + rank);
}

/* C:E. */
static inline void stress_of(float lambda, float twice_mu, const float e[6], float s[6]) {
  const float pressure = lambda * (e[0] + e[1] + e[2]);
  for (int c = 0; c < 6; c++)
    s[c] = (c < 3 ? pressure : 0) + twice_mu * e[c];
}

/* sym(G^T D). */
static inline void mixed_strain(const float g[9], const float d[9], float e[6]) {
  e[0] = g[0] * d[0] + g[3] * d[3] + g[6] * d[6];
  e[1] = g[1] * d[1] + g[4] * d[4] + g[7] * d[7];
  e[2] = g[2] * d[2] + g[5] * d[5] + g[8] * d[8];
  e[3] = 0.5f * (g[0] * d[1] + g[3] * d[4] + g[6] * d[7] + g[1] * d[0] + g[4] * d[3] + g[7] * d[6]);
  e[4] = 0.5f * (g[1] * d[2] + g[4] * d[5] + g[7] * d[8] + g[2] * d[1] + g[5] * d[4] + g[8] * d[7]);
  e[5] = 0.5f * (g[2] * d[0] + g[5] * d[3] + g[8] * d[6] + g[0] * d[2] + g[3] * d[5] + g[6] * d[8]);
}

/* e + sym D. */
static inline void add_linear_strain(const float d[9], const float e[6], float sum[6]) {
  sum[0] = e[0] + d[0];
  sum[1] = e[1] + d[4];
  sum[2] = e[2] + d[8];
  sum[3] = e[3] + 0.5f * (d[1] + d[3]);
  sum[4] = e[4] + 0.5f * (d[5] + d[7]);
  sum[5] = e[5] + 0.5f * (d[2] + d[6]);
}

/* p += G S. */
static inline void add_product(const float g[9], const float s[6], float p[9]) {
  for (int k = 0; k < 3; k++) {
    const float *row = g + 3 * k;
    p[3 * k] += row[0] * s[0] + row[1] * s[3] + row[2] * s[5];
    p[3 * k + 1] += row[0] * s[3] + row[1] * s[1] + row[2] * s[4];
    p[3 * k + 2] += row[0] * s[5] + row[1] * s[4] + row[2] * s[2];
  }
}

/* A symmetric matrix as a matrix. */
static inline void spread(const float s[6], float p[9]) {
  p[0] = s[0];
  p[4] = s[1];
  p[8] = s[2];
  p[1] = p[3] = s[3];
  p[5] = p[7] = s[4];
  p[2] = p[6] = s[5];
}

/* C:N and C:E at the gradient g, N = G^T G / 2 and E = N + sym G (18.2). */
static inline void stresses_of(float lambda, float twice_mu, const float g[9], float t[6],
                               float s[6]) {
  float n[6], e[6];
  mixed_strain(g, g, n);
  for (int c = 0; c < 6; c++)
    n[c] *= 0.5f;
  add_linear_strain(g, n, e);
  stress_of(lambda, twice_mu, n, t);
  stress_of(lambda, twice_mu, e, s);
}

/* Component c of point p of one state, n points side by side, and back. */
static void take_matrix(const float *from, int64_t n, int64_t p, double m[3][3]) {
  for (int c = 0; c < ROWS; c++)
    m[c / 3][c % 3] = from[c * n + p];
}

static void put_matrix(double m[3][3], int64_t n, int64_t p, float *to) {
  for (int c = 0; c < ROWS; c++)
    to[c * n + p] = (float)m[c / 3][c % 3];
}

/* The stresses of one state where points have laws. */
static void take_law_stresses(const thrum_single_points *points, const float *gradient,
                              float *stress) {
  const int64_t n = points->count;
  for (int64_t p = 0; p < n; p++) {
    double g[3][3], at[3][3];
    take_matrix(gradient, n, p, g);
    thrum_nonlinear_stress(points->laws[p], points->lambda[p], points->mu[p], g, at);
    put_matrix(at, n, p, stress);
  }
}

/* Makes each gradient in `along` the change of the stress along it. */
static void take_law_tangents(const thrum_single_points *points, const float *gradient,
                              float *along) {
  const int64_t n = points->count;
  for (int64_t p = 0; p < n; p++) {
    double g[3][3], d[3][3], change[3][3];
    take_matrix(gradient, n, p, g);
    take_matrix(along, n, p, d);
    thrum_nonlinear_tangent(points->laws[p], points->lambda[p], points->mu[p], g, d, change);
    put_matrix(change, n, p, along);
  }
}

/* The stresses (18.3) of one state. */
static void take_stresses(const thrum_single_points *points, const float *restrict gradient,
                          float *restrict stress) {
  const int64_t n = points->count;
  if (points->laws) {
    take_law_stresses(points, gradient, stress);
    return;
  }
  for (int64_t p = 0; p < n; p++) {
    const float lambda = points->lambda[p], twice_mu = 2 * points->mu[p];
    float g[ROWS], t[6], s[6], at[ROWS];
    for (int c = 0; c < ROWS; c++)
      g[c] = gradient[c * n + p];
    stresses_of(lambda, twice_mu, g, t, s);
    spread(t, at);
    add_product(g, s, at);
    for (int c = 0; c < ROWS; c++)
      stress[c * n + p] = at[c];
  }
}

/* Makes each gradient in `along` the change of the stress along it (18.4), of one state. */
static void take_tangents(const thrum_single_points *points, const float *restrict gradient,
                          float *restrict along) {
  const int64_t n = points->count;
  if (points->laws) {
    take_law_tangents(points, gradient, along);
    return;
  }
  for (int64_t p = 0; p < n; p++) {
    const float lambda = points->lambda[p], twice_mu = 2 * points->mu[p];
    float g[ROWS], d[ROWS], t[6], s[6], dn[6], de[6], dt[6], ds[6], at[ROWS];
    for (int c = 0; c < ROWS; c++) {
      g[c] = gradient[c * n + p];
      d[c] = along[c * n + p];
    }
    stresses_of(lambda, twice_mu, g, t, s);
    mixed_strain(g, d, dn);
    add_linear_strain(d, dn, de);
    stress_of(lambda, twice_mu, dn, dt);
    stress_of(lambda, twice_mu, de, ds);
    spread(dt, at);
    add_product(d, s, at);
    add_product(g, ds, at);
    for (int c = 0; c < ROWS; c++)
      along[c * n + p] = at[c];
  }
}

/* product (states x 9 points) = rows (states x rank) gradients^T. */
static void along_gradients(const thrum_single_points *points, int states, const float *rows,
                            float *product) {
  const int n = (int)(ROWS * points->count), r = (int)points->rank;
  cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasTrans, states, n, r, 1, rows, r, points->gradients,
              r, 0, product, n);
}

void thrum_refine_slope(const thrum_single_points *points, const thrum_single_samples *samples,
                        float *slope, float *work) {
  const int n = (int)(ROWS * points->count), r = (int)points->rank, states = (int)samples->count;
  const size_t all = (size_t)states * (size_t)n;
  float *gradient = work, *stress = gradient + all, *along = stress + all, *residual = along + all;

  // forces of the points
  along_gradients(points, states, samples->q, gradient);
  for (int s = 0; s < states; s++)
    take_stresses(points, gradient + (int64_t)s * n, stress + (int64_t)s * n);
  cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, states, r, n, 1, stress, n,
              points->gradients, r, 0, residual, r);

  // how far they are off, times the scale once more and the share of a state
  for (int s = 0; s < states; s++)
    for (int i = 0; i < r; i++) {
      float *at = residual + (int64_t)s * r + i;
      const float scale = samples->scale[s];
      *at = scale / (float)states * (scale * *at - samples->force[(int64_t)s * r + i]);
    }

  // stresses by residuals, and changes of the stress by states
  along_gradients(points, states, residual, along);
  for (int s = 0; s < states; s++)
    take_tangents(points, gradient + (int64_t)s * n, along + (int64_t)s * n);
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, r, states, 1, stress, n, residual, r, 0,
              slope, r);
  cblas_sgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, r, states, 1, along, n, samples->q, r, 1,
              slope, r);
}
