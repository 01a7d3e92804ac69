/* Which law answers, see material_law.h. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/material_law.h"

#include <string.h>

#include "runtime/material/jacobi.h"
#include "runtime/material/material_law_private.h"

double thrum_law_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                        double stress[3][3]) {
  if (law == THRUM_LAW_STVK)
    return material_law_stvk_stress(lambda, mu, gradient, stress);
  return law == THRUM_LAW_COROTATIONAL
             ? material_law_corotational_stress(lambda, mu, gradient, stress)
             : material_law_neo_hookean_stress(lambda, mu, gradient, stress);
}

void thrum_law_tangent(thrum_law law, double lambda, double mu, double gradient[3][3],
                       double tangent[9][9]) {
  if (law == THRUM_LAW_STVK)
    material_law_stvk_tangent(lambda, mu, gradient, tangent);
  else if (law == THRUM_LAW_COROTATIONAL)
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

thrum_law_cubic thrum_law_cubic_of(thrum_law law, double lambda, double mu) {
  if (law == THRUM_LAW_STVK)
    return (thrum_law_cubic){0, 0, 0};
  return law == THRUM_LAW_COROTATIONAL ? material_law_corotational_cubic(lambda, mu)
                                       : material_law_neo_hookean_cubic(lambda, mu);
}

void thrum_law_cubic_stress(const thrum_law_cubic *cubic, double e[3][3], double f[3][3],
                            double stress[3][3]) {
  const double trace_e = e[0][0] + e[1][1] + e[2][2], trace_f = f[0][0] + f[1][1] + f[2][2];
  double product = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      product += e[i][j] * f[i][j];

  // the derivatives of the three invariants, polarised: both strains are symmetric
  const double pressure = 6 * cubic->cube * trace_e * trace_f + 2 * cubic->mixed * product;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double both = 0;
      for (int k = 0; k < 3; k++)
        both += e[i][k] * f[k][j] + f[i][k] * e[k][j];
      stress[i][j] += (i == j ? pressure : 0) +
                      2 * cubic->mixed * (trace_e * f[i][j] + trace_f * e[i][j]) +
                      3 * cubic->trace * both;
    }
}
