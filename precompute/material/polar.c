/* The rotation R nearest to F maximises tr(R^T F). For the rotation of a unit quaternion x that is
 * x^T N x with a symmetric N of 4 x 4, linear in F, so x is the eigenvector of its largest
 * eigenvalue (Horn 1987, doi:10.1364/JOSAA.4.000629). Unlike iterations for the orthogonal factor
 * this needs no inverse of F and always gives a proper rotation. Cost: about 1000 multiply-adds.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/material/polar.h"

#include "precompute/material/jacobi.h"

/* N of tr(R^T F) = x^T N x, F = 1 + G, for quaternions x = (w, x, y, z). */
static void quaternion_form(double g[3][3], double n[4][4]) {
  n[0][0] = 3 + (g[0][0] + g[1][1] + g[2][2]);
  n[1][1] = g[0][0] - g[1][1] - g[2][2] - 1;
  n[2][2] = g[1][1] - g[0][0] - g[2][2] - 1;
  n[3][3] = g[2][2] - g[0][0] - g[1][1] - 1;

  // off the diagonal: skew parts beside w, symmetric parts between the others
  n[0][1] = n[1][0] = g[2][1] - g[1][2];
  n[0][2] = n[2][0] = g[0][2] - g[2][0];
  n[0][3] = n[3][0] = g[1][0] - g[0][1];
  n[1][2] = n[2][1] = g[0][1] + g[1][0];
  n[1][3] = n[3][1] = g[0][2] + g[2][0];
  n[2][3] = n[3][2] = g[1][2] + g[2][1];
}

/* The eigenvector of the largest eigenvalue of n, which is overwritten. */
static void largest_eigenvector(double n[4][4], double found[4]) {
  double vectors[4][4];
  thrum_jacobi(4, n[0], vectors[0]);
  int largest = 0;
  for (int k = 1; k < 4; k++)
    largest = n[k][k] > n[largest][largest] ? k : largest;
  for (int k = 0; k < 4; k++)
    found[k] = vectors[k][largest];
}

void thrum_polar_rotation(double gradient[3][3], double turned[3][3]) {
  double n[4][4], x[4];
  quaternion_form(gradient, n);
  largest_eigenvector(n, x);

  // the matrix of a quaternion, whose length is 1 to rounding, without its 1
  const double scale = 2 / (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double a = x[i + 1], b = x[j + 1], c = x[k + 1];
    turned[i][i] = -scale * (b * b + c * c);
    turned[i][j] = scale * (a * b - x[0] * c);
    turned[j][i] = scale * (a * b + x[0] * c);
  }
}
