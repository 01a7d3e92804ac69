/* Strain and stress of one linear tetrahedron: StVK, design 1. About 80 operations for E and S, 100
 * more for sigma. The eigenvalues of the 3 x 3 strain are those of Jacobi's rotations (Golub and
 * Van Loan, Matrix Computations, 8.5), which need no function of libm that rounds differently
 * elsewhere, and are exact to rounding for equal eigenvalues too.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/readout/tet_strain.h"

#include <math.h>

#include "core/base/vec3.h"
#include "thrum/stress.h"

#define SWEEPS 16     /* quadratic convergence: about 5 are needed */
#define NOTHING 1e-17 /* of the diagonal: entries this small are 0 */
#define FLAT 1e150    /* cotangent of twice an angle whose square would overflow */

/* Place of component (i, j) among the six. */
static const int place[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

void thrum_tet_gradient(const double u[12], const double shape[9], double gradient[3][3]) {
  for (int i = 0; i < 3; i++) {
    // edges, so that a shift gives exact zeros
    const double e1 = u[3 + i] - u[i], e2 = u[6 + i] - u[i], e3 = u[9 + i] - u[i];
    for (int j = 0; j < 3; j++)
      gradient[i][j] = e1 * shape[j] + e2 * shape[3 + j] + e3 * shape[6 + j];
  }
}

void thrum_tet_green(double g[3][3], double strain[6]) {
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++)
      strain[place[i][j]] =
          0.5 * (g[i][j] + g[j][i] + (g[0][i] * g[0][j] + g[1][i] * g[1][j] + g[2][i] * g[2][j]));
}

void thrum_tet_second_piola(double lambda, double mu, const double strain[6], double stress[6]) {
  const double pressure = lambda * (strain[0] + strain[1] + strain[2]);
  for (int c = 0; c < 6; c++)
    stress[c] = 2 * mu * strain[c] + (c < 3 ? pressure : 0);
}

double thrum_tet_volume_ratio(double g[3][3]) {
  const double a = 1 + g[0][0], b = 1 + g[1][1], c = 1 + g[2][2];
  return a * (b * c - g[1][2] * g[2][1]) - g[0][1] * (g[1][0] * c - g[1][2] * g[2][0]) +
         g[0][2] * (g[1][0] * g[2][1] - b * g[2][0]);
}

void thrum_tet_cauchy(double g[3][3], double ratio, const double second_piola[6],
                      double cauchy[6]) {
  double f[3][3], fs[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      f[i][j] = g[i][j] + (i == j ? 1 : 0);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      fs[i][j] = f[i][0] * second_piola[place[0][j]] + f[i][1] * second_piola[place[1][j]] +
                 f[i][2] * second_piola[place[2][j]];
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++)
      cauchy[place[i][j]] = (fs[i][0] * f[j][0] + fs[i][1] * f[j][1] + fs[i][2] * f[j][2]) / ratio;
}

double thrum_von_mises(const double s[6]) {
  const double xy = s[0] - s[1], yz = s[1] - s[2], zx = s[2] - s[0];
  return sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3 * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]));
}

/* One Jacobi rotation that makes a[p][q] zero. */
static void rotate(double a[3][3], int p, int q) {
  const int r = 3 - p - q;
  if (a[p][q] == 0)
    return;
  const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);

  // where theta squared overflows the rotation is by nearly nothing
  const double t = fabs(theta) > FLAT
                       ? 0.5 / theta
                       : (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));

  // the third row and column mix by the same rotation
  const double c = 1 / sqrt(t * t + 1), s = t * c;
  const double pr = a[p][r], qr = a[q][r];
  a[p][p] -= t * a[p][q];
  a[q][q] += t * a[p][q];
  a[p][q] = a[q][p] = 0;
  a[p][r] = a[r][p] = c * pr - s * qr;
  a[q][r] = a[r][q] = s * pr + c * qr;
}

double thrum_tet_least_stretch(const double strain[6], double ratio) {
  double a[3][3], size = 0, sum = 0;
  for (int c = 0; c < 6; c++)
    sum += fabs(strain[c]);
  if (!isfinite(sum))
    return NAN;

  // a convergence test needs the size of the entries
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      a[i][j] = strain[place[i][j]];
      size = fmax(size, fabs(a[i][j]));
    }

  // cyclic Jacobi converges quadratically, so few sweeps suffice
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    if (fabs(a[0][1]) + fabs(a[0][2]) + fabs(a[1][2]) <= NOTHING * size)
      break;
    rotate(a, 0, 1);
    rotate(a, 0, 2);
    rotate(a, 1, 2);
  }

  // the stretch squared is 1 + 2 e; the sign tells an inverted tetrahedron
  const double square = 1 + 2 * fmin(a[0][0], fmin(a[1][1], a[2][2]));
  // rounding may make the square of a flat tetrahedron negative
  const double stretch = square > 0 ? sqrt(square) : 0;
  return ratio < 0 ? -stretch : stretch;
}

double thrum_tet_stretch_bound(const double e[6]) {
  const double square =
      e[0] * e[0] + e[1] * e[1] + e[2] * e[2] + 2 * (e[3] * e[3] + e[4] * e[4] + e[5] * e[5]);
  const double least = 1 - 2 * sqrt(square);
  return least > 0 ? sqrt(least) : 0;
}

void thrum_tet_law_second_piola(thrum_law law, double lambda, double mu, double g[3][3],
                                const double strain[6], double ratio, double stress[6]) {
  if (law == THRUM_LAW_STVK) {
    thrum_tet_second_piola(lambda, mu, strain, stress);
    return;
  }

  // another law gives P, from which S is F^-1 P
  static const int row[6] = {0, 1, 2, 0, 1, 0}, column[6] = {0, 1, 2, 1, 2, 2};
  double first[3][3], f[3][3], cofactor[3][3];
  thrum_law_stress(law, lambda, mu, g, first);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      f[i][j] = g[i][j] + (i == j ? 1 : 0);

  // the inverse is the transposed cofactor over J
  for (int i = 0; i < 3; i++)
    thrum_cross3(f[(i + 1) % 3], f[(i + 2) % 3], cofactor[i]);
  for (int c = 0; c < 6; c++) {
    const int i = row[c], j = column[c];
    stress[c] = (cofactor[0][i] * first[0][j] + cofactor[1][i] * first[1][j] +
                 cofactor[2][i] * first[2][j]) /
                ratio;
  }
}
