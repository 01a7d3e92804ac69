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
#include "runtime/base/fp_contract.h"

#include <math.h>

#include "runtime/base/pi.h"
#include "runtime/dynamics/fox_goodwin.h"
#include "runtime/dynamics/frequency_matching.h"
#include "runtime/dynamics/state_private.h"

#define FASTEST 1e30 /* h omega beyond which a factor is that of an infinite one */

/* The eigenvalue of a step. */
typedef struct factor {
  double real, imaginary; /* imaginary NaN: there are two real ones, and `real` is the larger */
} factor;

static factor newmark_factor(double z, double beta, double gamma) {
  const double u = z * z / (1.0 + beta * z * z), more = gamma + 0.5;
  const double real = 1.0 - 0.5 * more * u, square = u - 0.25 * more * more * u * u;
  if (square >= 0.0)
    return (factor){real, sqrt(square)};

  // overdamped by the step, or beyond its limit
  return (factor){fabs(real) + sqrt(-square), NAN};
}

/* That of mode i; `low` modes have Fox-Goodwin's beta. */
static factor factor_of(const thrum_state *state, int32_t low, int32_t i, double z) {
  const double square = z * z;
  switch ((thrum_scheme)state->scheme) {
  case THRUM_SCHEME_NEWMARK:
    return newmark_factor(z, state->def.newmark_beta, state->def.newmark_gamma);
  case THRUM_SCHEME_FOX_GOODWIN:
    return newmark_factor(z, i < low ? 1.0 / 12.0 : 0.25, 0.5);

  // the Eulers and Runge-Kutta have closed forms of their own
  case THRUM_SCHEME_BACKWARD_EULER:
  case THRUM_SCHEME_SEMI_IMPLICIT_EULER:
    return (factor){1.0 / (1.0 + square), z / (1.0 + square)};
  case THRUM_SCHEME_RK4:
    return (factor){1.0 - 0.5 * square + square * square / 24.0, fabs(z - z * square / 6.0)};

  // the trapezoidal rule, for energy without frequency matching and the implicit modes of imexv
  case THRUM_SCHEME_ENERGY:
  case THRUM_SCHEME_MANIFOLD:
    return newmark_factor(z, 0.25, 0.5);
  case THRUM_SCHEME_THESIS:
  case THRUM_SCHEME_QUADRATIC:
  case THRUM_SCHEME_POSITION:
    break;
  }
  return newmark_factor(z, i < state->split ? 0.0 : 0.25, 0.5);
}

thrum_status thrum_state_stepped_modes(const thrum_model *model, const thrum_state *state,
                                       thrum_stepped_mode *modes, thrum_error *error) {
  THRUM_TRY(thrum_state_check(model, state, error));
  if (!modes)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "modes is NULL");

  const double h = state->def.dt;
  const int32_t low = thrum_fox_goodwin_modes(model, state);
  for (int32_t i = 0; i < state->rank; i++) {
    const double omega = sqrt(model->omega2[i]);
    const factor found = factor_of(state, low, i, fmin(h * omega, FASTEST));
    const bool vibrates = !isnan(found.imaginary);
    modes[i] = (thrum_stepped_mode){
        .hertz = omega / THRUM_TWO_PI,
        .stepped_hertz = vibrates ? atan2(found.imaginary, found.real) / (THRUM_TWO_PI * h) : NAN,
        .factor = vibrates ? sqrt(found.real * found.real + found.imaginary * found.imaginary)
                           : found.real,
    };
  }

  // energy steps these as they are
  const int32_t matched =
      state->scheme == THRUM_SCHEME_ENERGY ? thrum_matched_modes(model, state) : 0;
  for (int32_t i = 0; i < matched; i++)
    if (thrum_matched_step_of(model, state, i).stretch > 1.0)
      modes[i].stepped_hertz = modes[i].hertz;
  return THRUM_OK;
}
