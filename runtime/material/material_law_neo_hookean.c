/* Stable neo-Hookean material, design (19.2): Smith, De Goes & Kim 2018, doi:10.1145/3180491,
 *   density = m/2 (I - 3) - m/2 log((I + 1)/4) + l/2 (J - a)^2 - l/2 (1 - a)^2,
 *   P = m (1 - 1/(I + 1)) F + l (J - a) cof F,
 * I = |F|^2, J = det F, a = 1 + 3 m/(4 l). At rest the tangent is that of linear elasticity with
 * m = 4/3 mu and l = lambda + 5/6 mu, as the paper has it. It is smooth for every F, also singular
 * and inverted ones.
 *
 * Near rest I - 3 and J - 1 are small differences; they are taken from G = F - 1, and density and
 * stress are written so that what cancels does not occur:
 *   P = 3/4 m (F - cof F) + m (I - 3)/(4 (I + 1)) F + l (J - 1) cof F,
 *   F - cof F = G + G^T - tr(G) 1 - cof G.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>

#include "core/base/vec3.h"
#include "runtime/material/elementary.h"
#include "runtime/material/material_law_private.h"

/* Quantities that the energy and its derivatives share. */
typedef struct invariants {
  double shear, bulk;       /* m and l */
  double deformation[3][3]; /* F */
  double cofactor[3][3];    /* dJ/dF */
  double square, grown;     /* I + 1, and I - 3 */
  double volume;            /* J - 1 */
} invariants;

/* The sum of the principal minors of G and its determinant: J - 1 without tr G. */
static double volume_beyond_trace(double g[3][3]) {
  const double minors = (g[0][0] * g[1][1] - g[0][1] * g[1][0]) +
                        (g[1][1] * g[2][2] - g[1][2] * g[2][1]) +
                        (g[0][0] * g[2][2] - g[0][2] * g[2][0]);
  return minors + thrum_triple3(g[0], g[1], g[2]);
}

static void take_invariants(double lambda, double mu, double g[3][3], invariants *v) {
  v->shear = 4.0 / 3 * mu;
  v->bulk = lambda + 5.0 / 6 * mu;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      v->deformation[i][j] = g[i][j] + (i == j ? 1 : 0);

  // the cofactor's rows are cross products of the other rows
  for (int i = 0; i < 3; i++)
    thrum_cross3(v->deformation[(i + 1) % 3], v->deformation[(i + 2) % 3], v->cofactor[i]);

  const double trace = g[0][0] + g[1][1] + g[2][2];
  v->grown = 2 * trace + thrum_dot3(g[0], g[0]) + thrum_dot3(g[1], g[1]) + thrum_dot3(g[2], g[2]);
  v->square = 4 + v->grown;
  v->volume = trace + volume_beyond_trace(g);
}

double material_law_neo_hookean_stress(double lambda, double mu, double gradient[3][3],
                                       double stress[3][3]) {
  invariants v;
  take_invariants(lambda, mu, gradient, &v);

  const double trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
  const double along = v.shear * v.grown / (4 * v.square), pressure = v.bulk * v.volume;
  double cofactor[3][3]; // of G
  for (int i = 0; i < 3; i++)
    thrum_cross3(gradient[(i + 1) % 3], gradient[(i + 2) % 3], cofactor[i]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double difference =
          gradient[i][j] + gradient[j][i] - (i == j ? trace : 0) - cofactor[i][j];
      stress[i][j] =
          0.75 * v.shear * difference + along * v.deformation[i][j] + pressure * v.cofactor[i][j];
    }

  // with I - 3 = 2 tr G + |G|^2 the traces of both parts cancel
  const double norm = thrum_dot3(gradient[0], gradient[0]) + thrum_dot3(gradient[1], gradient[1]) +
                      thrum_dot3(gradient[2], gradient[2]);
  return 0.75 * v.shear * (norm / 2 - volume_beyond_trace(gradient)) +
         v.shear / 2 * thrum_beyond_logarithm(v.grown / 4) + v.bulk / 2 * v.volume * v.volume;
}

void material_law_neo_hookean_tangent(double lambda, double mu, double gradient[3][3],
                                      double tangent[9][9]) {
  invariants v;
  take_invariants(lambda, mu, gradient, &v);
  const double along = v.shear * (1 - 1 / v.square);
  const double pressure = v.bulk * v.volume - 0.75 * v.shear;
  const double squares = 2 * v.shear / (v.square * v.square);

  // derivatives of both factors of P, and of F itself
  for (int row = 0; row < 9; row++)
    for (int column = 0; column < 9; column++)
      tangent[row][column] =
          squares * v.deformation[row / 3][row % 3] * v.deformation[column / 3][column % 3] +
          v.bulk * v.cofactor[row / 3][row % 3] * v.cofactor[column / 3][column % 3] +
          (row == column ? along : 0);

  // the cofactor (i, j) changes by +- F of the row and the column that are left
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      double *row = tangent[3 * i + j];
      row[3 * i1 + j1] += pressure * v.deformation[i2][j2];
      row[3 * i2 + j2] += pressure * v.deformation[i1][j1];
      row[3 * i1 + j2] -= pressure * v.deformation[i2][j1];
      row[3 * i2 + j1] -= pressure * v.deformation[i1][j2];
    }
}

/* With E of Green, t = tr E, I - 3 = 2 t, and J - 1 = t + (t^2/2 - tr E^2) + (t^3/6 - t tr E^2 +
 * 4/3 tr E^3) + ..., of degrees 1 to 3. */
thrum_law_cubic material_law_neo_hookean_cubic(double lambda, double mu) {
  const double shear = 4.0 / 3 * mu, bulk = lambda + 5.0 / 6 * mu;
  return (thrum_law_cubic){
      .cube = bulk / 2 - 7.0 / 48 * shear, .mixed = 0.75 * shear - bulk, .trace = -shear};
}
