/* The momenta of a step of the energy integrator, scaled by what its solve left of the energy: what
 * both discrete gradients end with. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>

#include "core/base/lane_sums.h"
#include "core/schemes/discrete_gradient_private.h"

#define FEW_TERMS 1e-8 /* share of the energy below which two terms of the root are exact */

/* of a smaller contraction that enters the remembered one */

bool thrum_momentum_take(const thrum_solver *s, double energy_error, double most,
                         const double *from, double *to) {
  const double square = thrum_sum_of(s->n, from, from, NULL);
  const double share = 2.0 * energy_error / square;
  const bool taken = fabs(share) < most || energy_error == 0.0;

  // the factor less 1, so that a long run is not rounded one way; mostly two terms of it are exact
  double more = 0.0;
  if (taken && energy_error != 0.0)
    more = fabs(share) < FEW_TERMS ? 0.5 * share - 0.125 * share * share
                                   : share / (1.0 + sqrt(1.0 + share));
  for (int32_t i = 0; i < s->n; i++)
    to[i] = from[i] + more * from[i];
  return taken;
}
