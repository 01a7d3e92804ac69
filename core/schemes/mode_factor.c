/* The eigenvalue of a step of Newmark's rule (mode_factor.h):
 *
 *   u = z^2 / (1 + beta z^2),  lambda^2 - [2 - (gamma + 1/2) u] lambda + 1 - (gamma - 1/2) u = 0
 *
 * Source: Hughes, The Finite Element Method, 1987, section 9.1.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/mode_factor.h"

#include <math.h>

thrum_mode_factor thrum_newmark_factor(double z, double beta, double gamma) {
  const double u = z * z / (1.0 + beta * z * z), more = gamma + 0.5;
  const double real = 1.0 - 0.5 * more * u, square = u - 0.25 * more * more * u * u;
  if (square >= 0.0)
    return (thrum_mode_factor){real, sqrt(square)};

  // overdamped by the step, or beyond its limit
  return (thrum_mode_factor){fabs(real) + sqrt(-square), NAN};
}
