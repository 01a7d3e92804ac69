/* The model counts: something for a step at all, the square of the coordinates for vectors and
 * inverses, and the coefficients of the polynomial, which are N = C(r + 2, 3) + C(r + 3, 4); those
 * beyond the second-level cache come more slowly. Slaves take a multiply-add for each pair of
 * masters. The constants are fits to `thrum bench step` at ranks 2 to 60 on an Intel Xeon with
 * AVX-512, good to a third. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/step_cost.h"

#include <stdbool.h>

#define STEP_SECONDS 0.45e-6
#define SQUARE_SECONDS 4.5e-9
#define COEFFICIENT_SECONDS 0.9e-10
#define FAR_COEFFICIENT_SECONDS 3.9e-10
#define FOLLOW_SECONDS 2e-10
#define DRAG_SECONDS 0.18e-6
#define DRAG_FOLLOW_SECONDS 5.5e-10
#define NEAR_COEFFICIENTS 262144.0 /* 2 MB */

/* Passes over the coefficients a step, over those of `energy`. */
static double passes(thrum_integrator integrator) {
  if (integrator == THRUM_INTEGRATOR_VERLET)
    return 0.7;
  if (integrator == THRUM_INTEGRATOR_ENERGY)
    return 1;
  if (integrator == THRUM_INTEGRATOR_RK4)
    return 2.8;
  return 2.1;
}

/* The drag of what follows, which damping at rest has. */
static double drag(const thrum_state_def *def, double follow) {
  const bool damped = def->damping_beta > 0 && def->damping_form == THRUM_DAMPING_REST;
  return damped && follow > 0 ? DRAG_SECONDS + DRAG_FOLLOW_SECONDS * follow : 0;
}

double step_cost(const thrum_state_def *def, int64_t stepped, int64_t followers) {
  const double r = (double)stepped;
  const double coefficients = r * (r + 1) * (r + 2) / 6 + r * (r + 1) * (r + 2) * (r + 3) / 24;
  const double each =
      coefficients > NEAR_COEFFICIENTS ? FAR_COEFFICIENT_SECONDS : COEFFICIENT_SECONDS;
  const double follow = (double)followers * r * (r + 1) / 2;
  return STEP_SECONDS + passes(def->integrator) * (SQUARE_SECONDS * r * r + each * coefficients) +
         FOLLOW_SECONDS * follow + drag(def, follow);
}
