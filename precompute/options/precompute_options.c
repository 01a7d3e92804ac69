/* Default options of a precompute. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/options/precompute_options.h"

#include <math.h>

thrum_precompute_options thrum_default_precompute_options(void) {
  return (thrum_precompute_options){.modes = 10,
                                    .cubature_error = 1e-3,
                                    .cubature_points = 2000,
                                    .cubature_range = 0.2,
                                    .cubature_yield = INFINITY,
                                    .threads = 1};
}
