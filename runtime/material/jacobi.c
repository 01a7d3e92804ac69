/* Jacobi's method: rotations of two rows and columns at a time until nothing is left beside the
 * diagonal, in four to six sweeps (Golub, Van Loan, Matrix Computations, section 8.5). Cost of a
 * sweep: 6 size^3 multiply-adds.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/jacobi.h"

#include <math.h>
#include <stdbool.h>

#define NOTHING 1e-17 /* of the two entries beside it on the diagonal: an entry this small is 0 */

enum { SWEEPS_MAX = 12 }; // beyond the six, for what is not finite

/* Columns p and q of `size` rows, whose entries are `row` apart and whose columns are `column`
 * apart, become c p - s q and s p + c q. */
static void turn(int size, double *matrix, int row, int column, int p, int q, double c, double s) {
  for (int k = 0; k < size; k++) {
    double *at = matrix + k * row;
    const double a = at[p * column], b = at[q * column];
    at[p * column] = c * a - s * b;
    at[q * column] = s * a + c * b;
  }
}

/* One rotation that makes the entry (p, q) zero. */
static void rotate_pair(int size, double *matrix, double *vectors, int p, int q) {
  // the smaller of the two angles: t = tan
  const double apart = matrix[q * size + q] - matrix[p * size + p];
  const double theta = apart / (2 * matrix[p * size + q]);
  const double t = copysign(1, theta) / (fabs(theta) + sqrt(theta * theta + 1));
  const double c = 1 / sqrt(t * t + 1), s = t * c;

  // columns, rows, and the columns of the eigenvectors
  turn(size, matrix, size, 1, p, q, c, s);
  turn(size, matrix, 1, size, p, q, c, s);
  turn(size, vectors, size, 1, p, q, c, s);
  matrix[p * size + q] = matrix[q * size + p] = 0;
}

void thrum_jacobi(int size, double *matrix, double *vectors) {
  for (int k = 0; k < size * size; k++)
    vectors[k] = k / size == k % size ? 1 : 0;

  // an entry that does not change the diagonal beside it counts as zero
  bool done = false;
  for (int sweep = 0; sweep < SWEEPS_MAX && !done; sweep++) {
    done = true;
    for (int p = 0; p < size - 1; p++)
      for (int q = p + 1; q < size; q++) {
        const double beside = fabs(matrix[p * size + p]) + fabs(matrix[q * size + q]);
        if (fabs(matrix[p * size + q]) > NOTHING * beside) {
          rotate_pair(size, matrix, vectors, p, q);
          done = false;
        }
      }
  }
}
