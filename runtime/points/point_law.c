/* Laws at cubature points, see point_law.h. A law is evaluated point by point: its rotations and
 * invariants take more time than what eight lanes would save of them (docs/mathematics/18).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/points/point_law.h"

#include <math.h>
#include <string.h>

#include "runtime/material/plastic_flow.h"

/* The gradient of one lane times a factor. */
static void take_gradient(const thrum_point_lanes *at, int64_t lane, double factor,
                          double gradient[3][3]) {
  for (int c = 0; c < 9; c++)
    gradient[c / 3][c % 3] = factor * at->gradient[8 * c + lane];
}

/* The stress of small strains; returns their energy. */
static double linear_stress(double lambda, double mu, double g[3][3], double stress[3][3]) {
  const double pressure = lambda * (g[0][0] + g[1][1] + g[2][2]);
  double twice = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      stress[i][j] = mu * (g[i][j] + g[j][i]) + (i == j ? pressure : 0);
      twice += stress[i][j] * g[i][j];
    }
  return 0.5 * twice;
}

/* F_p^-1 - 1 of one lane; false where nothing has flowed. */
static bool take_plastic(const thrum_point_lanes *at, int64_t lane, double plastic[3][3]) {
  if (at->plastic)
    memcpy(plastic, at->plastic + 9 * lane, 9 * sizeof(double));
  return at->plastic != NULL;
}

/* The energy and the stress of one lane by its law, at F = F_e F_p. */
static double whole_stress(const thrum_point_lanes *at, int64_t lane, double g[3][3],
                           double stress[3][3]) {
  double plastic[3][3];
  if (!take_plastic(at, lane, plastic))
    return thrum_law_stress(at->law[lane], at->lambda[lane], at->mu[lane], g, stress);
  return thrum_flowed_stress(at->law[lane], at->lambda[lane], at->mu[lane], g, plastic, stress);
}

/* The tangent of one lane by its law: both of its indices of F_e are drawn back. */
static void whole_tangent(const thrum_point_lanes *at, int64_t lane, double g[3][3],
                          double whole[9][9]) {
  double plastic[3][3], elastic[3][3], matrix[3][3];
  if (!take_plastic(at, lane, plastic)) {
    thrum_law_tangent(at->law[lane], at->lambda[lane], at->mu[lane], g, whole);
    return;
  }
  thrum_elastic_gradient(g, plastic, elastic);
  thrum_law_tangent(at->law[lane], at->lambda[lane], at->mu[lane], elastic, whole);
  for (int i = 0; i < 9; i++) {
    memcpy(matrix, whole[i], sizeof matrix);
    thrum_draw_back(plastic, matrix);
    memcpy(whole[i], matrix, sizeof matrix);
  }

  // the columns as the rows
  for (int j = 0; j < 9; j++) {
    for (int i = 0; i < 9; i++)
      matrix[i / 3][i % 3] = whole[i][j];
    thrum_draw_back(plastic, matrix);
    for (int i = 0; i < 9; i++)
      whole[i][j] = matrix[i / 3][i % 3];
  }
}

void thrum_point_law_stress(const thrum_point_lanes *at, double *energy, double *stress) {
  memset(energy, 0, 8 * sizeof *energy);
  memset(stress, 0, 72 * sizeof *stress);
  for (int64_t k = 0; k < at->count; k++) {
    double g[3][3], whole[3][3], linear[3][3];
    take_gradient(at, k, 1, g);
    const double all = whole_stress(at, k, g, whole);
    energy[k] = all - linear_stress(at->lambda[k], at->mu[k], g, linear);
    for (int c = 0; c < 9; c++)
      stress[8 * c + k] = whole[c / 3][c % 3] - linear[c / 3][c % 3];
  }
}

void thrum_point_law_tangent(const thrum_point_lanes *at, double *tangent) {
  memset(tangent, 0, sizeof(double[81][8]));
  for (int64_t k = 0; k < at->count; k++) {
    double g[3][3], whole[9][9], unit[3][3], linear[3][3];
    take_gradient(at, k, 1, g);
    whole_tangent(at, k, g, whole);

    // a column for each entry of F
    for (int j = 0; j < 9; j++) {
      memset(unit, 0, sizeof unit);
      unit[j / 3][j % 3] = 1;
      linear_stress(at->lambda[k], at->mu[k], unit, linear);
      for (int i = 0; i < 9; i++)
        tangent[8 * (9 * i + j) + k] = whole[i][j] - linear[i / 3][i % 3];
    }
  }
}

#define SHARE 0.01 /* size of the gradients whose differences are taken */

void thrum_point_law_terms(const thrum_point_lanes *at, double *energy, double *stress) {
  memset(energy, 0, 8 * sizeof *energy);
  memset(stress, 0, 72 * sizeof *stress);
  for (int64_t k = 0; k < at->count; k++) {
    double g[3][3], whole[3][3], linear[3][3], square = 0;
    for (int c = 0; c < 9; c++)
      square += at->gradient[8 * c + k] * at->gradient[8 * c + k];
    if (!(square > 0))
      continue;

    // even parts: of P(h) + P(-h) = h^2 P'' + ..., and of the energies 2 h^4 times that of degree 4
    const double h2 = SHARE * SHARE / square;
    for (int sign = -1; sign <= 1; sign += 2) {
      take_gradient(at, k, sign * sqrt(h2), g);
      energy[k] += thrum_law_stress(at->law[k], at->lambda[k], at->mu[k], g, whole) / (2 * h2 * h2);
      energy[k] -= linear_stress(at->lambda[k], at->mu[k], g, linear) / (2 * h2 * h2);
      for (int c = 0; c < 9; c++)
        stress[8 * c + k] += (whole[c / 3][c % 3] - linear[c / 3][c % 3]) / (2 * h2);
    }
  }
}
