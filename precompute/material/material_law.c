/* Which law answers, see material_law.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/material/material_law.h"

#include <string.h>

#include "precompute/material/jacobi.h"
#include "precompute/material/material_law_private.h"

double thrum_law_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                        double stress[3][3]) {
  return law == THRUM_LAW_COROTATIONAL
             ? material_law_corotational_stress(lambda, mu, gradient, stress)
             : material_law_neo_hookean_stress(lambda, mu, gradient, stress);
}

void thrum_law_tangent(thrum_law law, double lambda, double mu, double gradient[3][3],
                       double tangent[9][9]) {
  if (law == THRUM_LAW_COROTATIONAL)
    material_law_corotational_tangent(lambda, mu, gradient, tangent);
  else
    material_law_neo_hookean_tangent(lambda, mu, gradient, tangent);
}

void thrum_law_make_positive(double tangent[9][9]) {
  double diagonal[9][9], vectors[9][9];
  memcpy(diagonal, tangent, sizeof diagonal);
  thrum_jacobi(9, diagonal[0], vectors[0]);

  // the parts of negative eigenvalues are taken away
  for (int k = 0; k < 9; k++)
    for (int i = 0; i < 9 && diagonal[k][k] < 0; i++)
      for (int j = 0; j < 9; j++)
        tangent[i][j] -= diagonal[k][k] * vectors[i][k] * vectors[j][k];
}
