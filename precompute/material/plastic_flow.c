/* Plastic flow, design (19.4): with the principal stretches s and axes v of F_e and the deviator
 * d = dev(s - 1), where |d| is beyond the yield,
 *   F_p^-1 becomes F_p^-1 sum exp(-x d) v v^T,  x = (1 - exp(-creep dt)) (1 - yield/|d|).
 * As the deviator has no trace, the volume stays. The flow rule is that of O'Brien, Bargteil &
 * Hodgins 2002, doi:10.1145/566654.566579, with the rate of Mueller & Gross 2004, for a product of
 * deformations (Irving, Teran & Fedkiw 2004, doi:10.1145/1028523.1028541).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/material/plastic_flow.h"

#include <math.h>

#include "precompute/material/principal.h"
#include "runtime/base/vec3.h"

static void stretches_of(double gradient[3][3], double grown[3], double axes[3][3]) {
  double green[3][3];
  thrum_green_strain(gradient, green);
  thrum_principal_stretches(green, grown, axes);
}

bool thrum_plastic_flow(const thrum_plastic *material, double dt, double elastic[3][3],
                        double plastic[3][3], double share, double flowed[3][3]) {
  double deviator[3], axes[3][3];
  stretches_of(elastic, deviator, axes);
  const double mean = (deviator[0] + deviator[1] + deviator[2]) / 3;
  for (int k = 0; k < 3; k++)
    deviator[k] -= mean;

  // NaN does not flow
  const double size = sqrt(thrum_dot3(deviator, deviator));
  if (!(size > material->yield))
    return false;
  const double rate = -expm1(-material->creep * dt) * (1 - material->yield / size);

  // what F_p^-1 is multiplied by, less 1
  double along[3], factor[3][3];
  for (int k = 0; k < 3; k++)
    along[k] = expm1(-share * rate * deviator[k]);
  thrum_principal_tensor(along, axes, factor);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      flowed[i][j] = plastic[i][j] + factor[i][j] + plastic[i][0] * factor[0][j] +
                     plastic[i][1] * factor[1][j] + plastic[i][2] * factor[2][j];
  return true;
}

double thrum_plastic_strain(double plastic[3][3]) {
  double grown[3], axes[3][3];
  stretches_of(plastic, grown, axes);

  // those of the inverse have logarithms of the other sign
  for (int k = 0; k < 3; k++)
    grown[k] = log1p(grown[k]);
  return sqrt(thrum_dot3(grown, grown));
}
