/* How the modes of a model vibrate as a state steps them (thrum/state.h): their angle and amplitude
 * a step, of the linear undamped mode q'' = -omega^2 q. With z = h omega:
 *
 *   Newmark, gamma and beta   u = z^2 / (1 + beta z^2),  lambda^2 - [2 - (gamma + 1/2) u] lambda +
 *                             1 - (gamma - 1/2) u = 0;  Verlet beta = 0, midpoint and energy 1/4
 *                             but for the modes of energy whose frequency is matched
 *   backward Euler            lambda = (1 + i z) / (1 + z^2)
 *   Runge-Kutta               lambda = 1 - z^2/2 + z^4/24 + i (z - z^3/6)
 *
 * Cost: about 20 operations a mode. Source: Hughes, The Finite Element Method, 1987, section 9.1.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <math.h>

#include "core/base/pi.h"
#include "core/schemes/schemes.h"
#include "core/step/state_private.h"

#define FASTEST 1e30 /* h omega beyond which a factor is that of an infinite one */

thrum_status thrum_state_stepped_modes(const thrum_model *model, const thrum_state *state,
                                       thrum_stepped_mode *modes, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!modes)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "modes is NULL");

  const double h = state->def.dt;
  for (int32_t i = 0; i < state->rank; i++) {
    const double omega = sqrt(model->omega2[i]);
    const thrum_mode_factor found =
        thrum_row_of(state)->frequency(model, state, i, fmin(h * omega, FASTEST));
    const bool vibrates = !isnan(found.imaginary);
    modes[i] = (thrum_stepped_mode){
        .hertz = omega / THRUM_TWO_PI,
        .stepped_hertz = vibrates ? atan2(found.imaginary, found.real) / (THRUM_TWO_PI * h) : NAN,
        .factor = vibrates ? sqrt(found.real * found.real + found.imaginary * found.imaginary)
                           : found.real,
    };
  }

  // energy steps these as they are
  const thrum_mode_steps *steps =
      state->scheme == THRUM_SCHEME_ENERGY ? thrum_schemes.mode_steps : NULL;
  const int32_t matched = steps ? steps->count(model, state) : 0;
  for (int32_t i = 0; i < matched; i++)
    if (steps->of(model, state, i).stretch > 1.0)
      modes[i].stepped_hertz = modes[i].hertz;
  return THRUM_OK;
}
