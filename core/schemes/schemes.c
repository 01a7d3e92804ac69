/* Which scheme a state begins with (schemes.h). SPDX-License-Identifier: Apache-2.0 */
#include "core/schemes/schemes.h"

int thrum_first_scheme(const thrum_state_def *def) {
  // both are imexv's thesis form, with all modes explicit or implicit
  const bool thesis =
      def->integrator == THRUM_INTEGRATOR_VERLET || def->integrator == THRUM_INTEGRATOR_MIDPOINT;
  if (thesis)
    return thrum_schemes.rows[THRUM_SCHEME_THESIS] ? THRUM_SCHEME_THESIS : -1;

  for (int n = 0; n < THRUM_SCHEMES; n++) {
    const thrum_scheme_row *row = thrum_schemes.rows[n];
    if (row && row->integrator == def->integrator &&
        (row->form < 0 || row->form == (int)def->split_form))
      return n;
  }
  return -1;
}
