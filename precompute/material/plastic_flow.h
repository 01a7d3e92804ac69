/* Plastic flow at a point, design 19: the deformation F = F_e F_p has an elastic part, which the
 * law answers to, and a plastic one, of no change of volume, which stays. The parameters are those
 * of O'Brien, Bargteil & Hodgins 2002, doi:10.1145/566654.566579, and Mueller & Gross 2004.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MATERIAL_PLASTIC_FLOW_H
#define THRUM_PRECOMPUTE_MATERIAL_PLASTIC_FLOW_H

#include <stdbool.h>

typedef struct thrum_plastic {
  /* Norm of the deviator of the principal elastic strains s - 1 above which the material flows; >
   * 0, infinite: it never does. Larger: stronger. */
  double yield;

  /* Share of the strain beyond it that flows in a second, as the rate of an exponential; > 0 [1/s],
   * infinite: all of it flows at once. Larger: softer under loads that last. */
  double creep;

  /* Norm of the logarithms of the principal plastic stretches that is not exceeded; > 0, infinite:
   * no bound. Larger: flows further. */
  double largest;
} thrum_plastic;

/* Lets a point flow for the time dt [s]: flowed = F_p^-1 - 1 afterwards, from `plastic`, the same
 * before, and from the gradient of F_e, `share` (1 or less) of what the rule asks for. False, and
 * nothing written, where the strain is within the yield. */
bool thrum_plastic_flow(const thrum_plastic *material, double dt, double elastic[3][3],
                        double plastic[3][3], double share, double flowed[3][3]);

/* The norm of the logarithms of the principal stretches of F_p. */
double thrum_plastic_strain(double plastic[3][3]);

#endif
