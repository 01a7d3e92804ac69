/* Default options of a precompute. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/options/precompute_options.h"

thrum_precompute_options thrum_default_precompute_options(void) {
  return (thrum_precompute_options){.modes = 10, .threads = 1};
}
