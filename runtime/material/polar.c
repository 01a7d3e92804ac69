/* The rotation R nearest to F maximises tr(R^T F). For the rotation of a unit quaternion x that is
 * x^T N x with a symmetric N of 4 x 4, linear in F, so x is the eigenvector of its largest
 * eigenvalue (Horn 1987, doi:10.1364/JOSAA.4.000629). Unlike iterations for the orthogonal factor
 * this needs no inverse of F and always gives a proper rotation.
 *
 * Rayleigh quotients from the identity find it in two to four solves, 60 multiply-adds each, and
 * what they find is checked to be the largest. Beside half a turn and inverted elements, where they
 * fail, Jacobi's method takes about 1000.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/polar.h"

#include <stdbool.h>

#include "core/base/vec3.h"
#include "runtime/material/jacobi.h"

#define SOLVES_MAX 8
#define SMALL_CHANGE 1e-20 /* square of a change whose third power is below rounding */
#define SINGULAR 1e-6      /* determinant over the third power of the trace: nearly half a turn */

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

/* The eigenvector (1, u) of an eigenvalue: (value 1 - M) u = b, where b and M are the other parts
 * of n. False where the matrix on the left is not positive definite, which with interlacing says
 * that the value is the largest. */
static bool solve_vector(double n[4][4], double value, double u[3]) {
  double matrix[3][3], cofactor[3][3];
  const double *b = &n[0][1];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      matrix[i][j] = (i == j ? value : 0) - n[i + 1][j + 1];
  for (int i = 0; i < 3; i++)
    thrum_cross3(matrix[(i + 1) % 3], matrix[(i + 2) % 3], cofactor[i]);

  // the leading minors
  const double determinant = thrum_dot3(matrix[0], cofactor[0]);
  const double trace = matrix[0][0] + matrix[1][1] + matrix[2][2];
  if (!(matrix[0][0] > 0 && cofactor[2][2] > 0 && determinant > SINGULAR * trace * trace * trace))
    return false;
  for (int i = 0; i < 3; i++)
    u[i] = thrum_dot3(cofactor[i], b) / determinant;
  return true;
}

/* Rayleigh quotient iteration from the identity, which converges with the third power. */
static bool iterate_eigenvector(double n[4][4], double found[4]) {
  double *u = found + 1, before[3] = {0, 0, 0}, value = n[0][0];
  found[0] = 1;
  for (int solve = 0; solve < SOLVES_MAX; solve++) {
    if (!solve_vector(n, value, u))
      return false;

    // the quotient, and how far the vector went
    double square = 1, change = 0, form = n[0][0];
    for (int i = 0; i < 3; i++) {
      change += (u[i] - before[i]) * (u[i] - before[i]);
      square += u[i] * u[i];
      form += u[i] * (2 * n[0][i + 1] + thrum_dot3(&n[i + 1][1], u));
      before[i] = u[i];
    }
    value = form / square;
    if (change <= SMALL_CHANGE * square)
      return true;
  }
  return false;
}

void thrum_polar_rotation(double gradient[3][3], double turned[3][3]) {
  double n[4][4], x[4];
  quaternion_form(gradient, n);
  if (!iterate_eigenvector(n, x))
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
