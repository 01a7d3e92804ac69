/* Corotational linear material, design 19.2: linear elasticity of the strain e = S - 1 of the polar
 * decomposition F = R S,
 *   density = mu |F - R|^2 + lambda/2 tr(e)^2,
 *   P = 2 mu (F - R) + lambda tr(e) R,
 *   dP = 2 mu dF + lambda tr(R^T dF) R + (lambda tr(e) - 2 mu) dR,
 * where dR = R [w]x with (tr(S) 1 - S) w = a, [a]x = R^T dF - dF^T R. R is a proper rotation, so a
 * tetrahedron that is turned inside out has a negative principal stretch and is pushed back.
 * Sources: Mueller, Gross 2004, Interactive virtual materials (as warped stiffness); Chao, Pinkall,
 * Sanan, Schroeder 2010, doi:10.1145/1778765.1778775 (energy and derivatives).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "runtime/material/material_law_private.h"
#include "runtime/material/polar.h"

#define SINGULAR 1e-12 /* determinant over the third power of the trace: no rotation follows */

/* R of F = 1 + G, F - R, which keeps its digits where both are near 1, and tr(e) = R:(F - R). */
typedef struct decomposed {
  double rotation[3][3], strain[3][3], trace;
} decomposed;

static void decompose(double gradient[3][3], decomposed *d) {
  double turned[3][3];
  thrum_polar_rotation(gradient, turned);
  d->trace = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      d->rotation[i][j] = turned[i][j] + (i == j ? 1 : 0);
      d->strain[i][j] = gradient[i][j] - turned[i][j];
      d->trace += d->rotation[i][j] * d->strain[i][j];
    }
}

double material_law_corotational_stress(double lambda, double mu, double gradient[3][3],
                                        double stress[3][3]) {
  decomposed d;
  decompose(gradient, &d);

  // |F - R| = |S - 1|
  double square = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      square += d.strain[i][j] * d.strain[i][j];
      stress[i][j] = 2 * mu * d.strain[i][j] + lambda * d.trace * d.rotation[i][j];
    }
  return mu * square + lambda / 2 * d.trace * d.trace;
}

/* inverse = (tr(S) 1 - S)^-1 by cofactors. Its eigenvalues are 1/(s_j + s_k) of the principal
 * stretches: where a sum is zero beside the others the rotation is not unique, has no derivative,
 * and the inverse is taken as zero. */
static void spin_inverse(const decomposed *d, double inverse[3][3]) {
  // S - 1 = R^T (F - R)
  double matrix[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      matrix[i][j] = (i == j ? 2 + d->trace : 0) -
                     (d->rotation[0][i] * d->strain[0][j] + d->rotation[1][i] * d->strain[1][j] +
                      d->rotation[2][i] * d->strain[2][j]);

  // rows of cofactors are cross products of the other rows, which are those of the inverse
  for (int i = 0; i < 3; i++)
    thrum_cross3(matrix[(i + 1) % 3], matrix[(i + 2) % 3], inverse[i]);
  const double determinant = thrum_dot3(matrix[0], inverse[0]);
  const double size = fabs(matrix[0][0]) + fabs(matrix[1][1]) + fabs(matrix[2][2]);
  const double scale = determinant > SINGULAR * size * size * size ? 1 / determinant : 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      inverse[i][j] *= scale;
}

/* spin = dR of a change of F in its entry (k, l): R^T dF is row k of R as its column l. */
static void rotation_change(const decomposed *d, double inverse[3][3], int k, int l,
                            double spin[3][3]) {
  const double *row = d->rotation[k];

  // a of [a]x = R^T dF - dF^T R, and the angular change w
  double a[3] = {0, 0, 0}, w[3];
  a[(l + 2) % 3] += row[(l + 1) % 3];
  a[(l + 1) % 3] -= row[(l + 2) % 3];
  for (int i = 0; i < 3; i++)
    w[i] = thrum_dot3(inverse[i], a);

  // R [w]x: each row of R times the cross product's matrix, r x w
  for (int i = 0; i < 3; i++)
    thrum_cross3(d->rotation[i], w, spin[i]);
}

void material_law_corotational_tangent(double lambda, double mu, double gradient[3][3],
                                       double tangent[9][9]) {
  decomposed d;
  double inverse[3][3], spin[3][3];
  decompose(gradient, &d);
  spin_inverse(&d, inverse);
  const double turned = lambda * d.trace - 2 * mu;
  memset(tangent, 0, 81 * sizeof(double));

  // a column for each entry of F, where tr(R^T dF) is that entry of R
  for (int column = 0; column < 9; column++) {
    const int k = column / 3, l = column % 3;
    rotation_change(&d, inverse, k, l, spin);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        tangent[3 * i + j][column] =
            lambda * d.rotation[k][l] * d.rotation[i][j] + turned * spin[i][j];
    tangent[column][column] += 2 * mu;
  }
}

/* With E of Green the strain is e = E - E^2/2 + ..., so mu tr(e^2) + lambda/2 tr(e)^2 has the part
 * -mu tr(E^3) - lambda/2 tr(E) tr(E^2). */
thrum_law_cubic material_law_corotational_cubic(double lambda, double mu) {
  return (thrum_law_cubic){.cube = 0, .mixed = -lambda / 2, .trace = -mu};
}
