/* Green's strain and principal stretches, from the eigenvalues of the strain.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/principal.h"

#include <math.h>
#include <string.h>

#include "runtime/material/jacobi.h"

void thrum_green_strain(double gradient[3][3], double green[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double twice = gradient[i][j] + gradient[j][i];
      for (int k = 0; k < 3; k++)
        twice += gradient[k][i] * gradient[k][j];
      green[i][j] = twice / 2;
    }
}

void thrum_principal_stretches(double green[3][3], double grown[3], double axes[3][3]) {
  double diagonal[3][3];
  memcpy(diagonal, green, sizeof diagonal);
  thrum_jacobi(3, diagonal[0], axes[0]);

  // sqrt(1 + 2 e) - 1; rounding may put 1 + 2 e of a flat element below zero
  for (int k = 0; k < 3; k++)
    grown[k] = 2 * diagonal[k][k] / (1 + sqrt(fmax(1 + 2 * diagonal[k][k], 0)));
}

void thrum_principal_tensor(const double value[3], double axes[3][3], double tensor[3][3]) {
  memset(tensor, 0, 9 * sizeof(double));
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        tensor[i][j] += value[k] * axes[i][k] * axes[j][k];
}
