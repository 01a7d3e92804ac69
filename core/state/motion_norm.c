/* The scaled norm of a motion (design 5), in the measure of the residuals of a solve:
 *
 *   sqrt(sum_I (1 + h^2/4 omega^2) q^2 + sum_E h^2/4 omega^2 q^2 + h^2 |p|^2)
 *
 * Cost: about 8 r operations. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/state/motion_norm.h"

#include <math.h>

double thrum_motion_norm(const thrum_model *model, const thrum_state *state, const double *q,
                         const double *p) {
  const double h = state->def.dt;
  double sum = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const double stiff = 0.25 * h * h * model->omega2[i];
    sum += (i < state->split ? stiff : 1.0 + stiff) * (q[i] * q[i]) + h * h * (p[i] * p[i]);
  }
  return sqrt(sum);
}
