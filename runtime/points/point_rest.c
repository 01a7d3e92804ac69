/* The stiffness that no cubature point stands for, of a body that may flow (18.7). With that of the
 * points, K = sum_p w_p G_p^T C G_p, and that of the whole body, W = diag(omega^2), let
 * K v = l W v, v^T W v = 1. Then
 *
 *   V(q) = 1/2 (q - q_p)^T D (q - q_p) + sum_p w_p psi(F F_p^-1 at q - X q),
 *   D = sum over l < 1 of (1 - l) W v v^T W,  X = sum over l > 1 of (1 - 1/sqrt(l)) v v^T W,
 *   q_p = W^-1 sum_p w_p G_p^T C e_p,
 *
 * where e_p is the strain of F_p. No term of V is ever negative, so a flow, which lowers V, takes
 * no more than start and loads have given. Until something flows, V is that of (18.5) where X is
 * zero.
 *
 * Cost: shapes are found once, by Jacobi's method, in some 50 rank^3 products and sums. The release
 * of a flow takes 18 of them for each coordinate of each point that has flowed, and 2 rank^2; a
 * product with X takes rank^2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/points/point_rest.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "runtime/material/jacobi.h"
#include "runtime/material/material_law.h"
#include "runtime/material/principal.h"

static double dot(const double *a, const double *b, int64_t count) {
  double sum = 0;
  for (int64_t i = 0; i < count; i++)
    sum += a[i] * b[i];
  return sum;
}

/* The stress lambda tr(e) 1 + 2 mu e of point p, times its weight. */
static void stress_at(const thrum_model *model, int64_t p, double strain[3][3],
                      double stress[3][3]) {
  const double weight = model->point_weights[p];
  const double mu = weight * model->point_moduli[model->point_count + p];
  const double pressure =
      weight * model->point_moduli[p] * (strain[0][0] + strain[1][1] + strain[2][2]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      stress[i][j] = mu * (strain[i][j] + strain[j][i]) + (i == j ? pressure : 0);
}

/* to (count) += sum of the stress and the gradients of the coordinates from `first` on. */
static void scatter(const thrum_model *model, int64_t p, double stress[3][3], int64_t first,
                    int64_t count, double *to) {
  for (int c = 0; c < THRUM_POINT_ROWS; c++) {
    const double *row = model->point_gradients + (THRUM_POINT_ROWS * p + c) * model->rank + first;
    for (int64_t i = 0; i < count; i++)
      to[i] += stress[c / 3][c % 3] * row[i];
  }
}

void thrum_rest_shares(const thrum_model *model, double *shapes, double *shares, double *work) {
  const int64_t r = model->rank;

  // K, of which rows hold what lies right of the diagonal
  memset(work, 0, (size_t)(r * r) * sizeof *work);
  for (int64_t p = 0; p < model->point_count; p++)
    for (int64_t i = 0; i < r; i++) {
      double gradient[3][3], stress[3][3];
      for (int c = 0; c < THRUM_POINT_ROWS; c++)
        gradient[c / 3][c % 3] = model->point_gradients[(THRUM_POINT_ROWS * p + c) * r + i];
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < a; b++)
          gradient[a][b] = gradient[b][a] = 0.5 * (gradient[a][b] + gradient[b][a]);
      stress_at(model, p, gradient, stress);
      scatter(model, p, stress, i, r - i, work + i * r + i);
    }

  // in units of W; a coordinate without stiffness has none at the points
  for (int64_t i = 0; i < r; i++)
    shares[i] = model->omega2[i] > 0 ? 1 / sqrt(model->omega2[i]) : 0;
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++)
      work[i * r + j] = work[j * r + i] = work[i * r + j] * shares[i] * shares[j];

  // eigenvectors come in columns
  thrum_jacobi((int)r, work, shapes);
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j <= i; j++) {
      const double below = shapes[i * r + j] * shares[i], above = shapes[j * r + i] * shares[j];
      shapes[i * r + j] = above;
      shapes[j * r + i] = below;
    }
  for (int64_t i = 0; i < r; i++)
    shares[i] = fmax(work[i * r + i], 0);
}

/* The strains U - 1 of the plastic deformation R U whose inverse, less 1, is given; false where
 * there is none. */
static bool plastic_strain(const double *inverse, double strain[3][3]) {
  double transposed[3][3], green[3][3], grown[3], axes[3][3];
  bool any = false;
  for (int c = 0; c < THRUM_POINT_ROWS; c++) {
    transposed[c % 3][c / 3] = inverse[c];
    any = any || inverse[c] != 0;
  }
  if (!any)
    return false;

  // the inverse has the axes of U on its left, and the reciprocal stretches
  thrum_green_strain(transposed, green);
  thrum_principal_stretches(green, grown, axes);
  for (int k = 0; k < 3; k++)
    grown[k] = -grown[k] / (1 + grown[k]);
  thrum_principal_tensor(grown, axes, strain);
  return true;
}

void thrum_rest_prepare(const thrum_model *model, const double *shapes, const double *shares,
                        double *plastic) {
  const int64_t r = model->rank;
  double *shortens = plastic + THRUM_POINT_ROWS * model->point_count + r + 1, *by = shortens + 1;
  memset(shortens, 0, (size_t)(1 + r * r) * sizeof *shortens);
  for (int64_t k = 0; k < r; k++) {
    const double *shape = shapes + k * r;
    if (!(shares[k] > 1))
      continue;
    *shortens = 1;
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++)
        by[i * r + j] += (1 - 1 / sqrt(shares[k])) * shape[i] * (model->omega2[j] * shape[j]);
  }
}

void thrum_rest_release(const thrum_model *model, const double *shapes, const double *shares,
                        double *plastic) {
  const int64_t r = model->rank;
  double force[THRUM_RANK_MAX] = {0}; // W q_p
  double *released = plastic + THRUM_POINT_ROWS * model->point_count;
  memset(released, 0, (size_t)(r + 1) * sizeof *released);

  // points at which nothing has flowed have no part in it
  bool any = false;
  for (int64_t p = 0; p < model->point_count; p++) {
    double strain[3][3], stress[3][3];
    if (!plastic_strain(plastic + THRUM_POINT_ROWS * p, strain))
      continue;
    stress_at(model, p, strain, stress);
    scatter(model, p, stress, 0, r, force);
    any = true;
  }

  // D q_p and 1/2 q_p^T D q_p, along one shape after the other
  for (int64_t k = 0; any && k < r; k++) {
    const double *shape = shapes + k * r, rest = fmax(1 - shares[k], 0);
    const double along = dot(shape, force, r);
    for (int64_t i = 0; i < r; i++)
      released[i] += rest * along * model->omega2[i] * shape[i];
    released[r] += 0.5 * rest * along * along;
  }
}

double thrum_released_energy(const thrum_model *model, const double *q) {
  const double *released = thrum_points_released(model);
  double sum = released[model->rank];
  for (int64_t i = 0; i < model->rank; i++)
    sum -= released[i] * q[i];
  return sum;
}

/* X. */
static const double *shortening(const thrum_model *model) {
  return thrum_points_released(model) + model->rank + 2;
}

void thrum_points_see(const thrum_model *model, const double *q, double *seen) {
  const double *by = shortening(model);
  for (int64_t i = 0; i < model->rank; i++)
    seen[i] = q[i] - dot(by + i * model->rank, q, model->rank);
}

void thrum_points_return(const thrum_model *model, double *force) {
  const double *by = shortening(model);
  const int64_t r = model->rank;
  double less[THRUM_RANK_MAX] = {0};
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++)
      less[j] += by[i * r + j] * force[i];
  for (int64_t j = 0; j < r; j++)
    force[j] -= less[j];
}

void thrum_points_return_tangent(const thrum_model *model, double *tangent) {
  const int64_t r = model->rank;
  double column[THRUM_RANK_MAX];

  // the tangent is symmetric, so its rows serve as columns: rows first, then columns
  for (int64_t i = 0; i < r; i++)
    thrum_points_return(model, tangent + i * r);
  for (int64_t j = 0; j < r; j++) {
    for (int64_t i = 0; i < r; i++)
      column[i] = tangent[i * r + j];
    thrum_points_return(model, column);
    for (int64_t i = 0; i < r; i++)
      tangent[i * r + j] = column[i];
  }

  // rounding leaves it not quite symmetric
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < i; j++)
      tangent[j * r + i] = tangent[i * r + j];
}
