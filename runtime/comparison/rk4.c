/* One step of the classical Runge-Kutta method of order 4, for comparison (design 6):
 *
 *   q' = p,  p' = f - R(q) - D p,  four stages, the load f at its mean in all of them
 *
 * It is explicit and neither symplectic nor reversible. A linear mode is stable for h omega <
 * 2 sqrt(2); below, its energy falls by (h omega)^6/72 in each step.
 * Cost: four force evaluations, and four products of the tangent for the tangent form of D.
 * Source: Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, 1993, section II.1,
 * doi:10.1007/978-3-540-78862-1.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/comparison/rk4.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/schemes/newmark.h"

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  static const double reach[4] = {0.5, 0.5, 1.0, 0.0};
  static const double share[4] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  const double h = state->def.dt;
  const size_t vector = (size_t)state->rank * sizeof(double);
  double *q = view->middle, *p = view->velocity, *rate = view->total;
  (void)report;

  // the stage in (q, p), the sums in (q_next, p_next)
  memcpy(q, view->q, vector);
  memcpy(p, view->p, vector);
  memcpy(view->q_next, view->q, vector);
  memcpy(view->p_next, view->p, vector);
  for (int stage = 0; stage < 4; stage++) {
    thrum_newmark_acceleration(model, state, view, q, p, rate);
    for (int32_t i = 0; i < state->rank; i++) {
      const double moved = p[i], pushed = rate[i] + view->load[i];
      view->q_next[i] += h * share[stage] * moved;
      view->p_next[i] += h * share[stage] * pushed;
      q[i] = view->q[i] + h * reach[stage] * moved;
      p[i] = view->p[i] + h * reach[stage] * pushed;
    }
  }
  return thrum_all_finite(view->q_next, state->rank) && thrum_all_finite(view->p_next, state->rank)
             ? THRUM_OK
             : THRUM_NOT_FINITE;
}

static thrum_mode_factor frequency(const thrum_model *model, const thrum_state *state, int32_t i,
                                   double z) {
  const double square = z * z;
  (void)model, (void)state, (void)i;
  return (thrum_mode_factor){1.0 - 0.5 * square + square * square / 24.0,
                             fabs(z - z * square / 6.0)};
}

/* As far as its h^4. */
static thrum_mode_answer answer(const thrum_model *model, const thrum_state *state, int32_t own,
                                int32_t i) {
  (void)model, (void)state, (void)own, (void)i;
  return (thrum_mode_answer){1.0, 0.5, 0.5, 1.0 / 12.0};
}

const thrum_scheme_row thrum_rk4_scheme = {
    .scheme = THRUM_SCHEME_RK4,
    .integrator = THRUM_INTEGRATOR_RK4,
    .form = -1,
    .keeps_nothing = true,
    .is_explicit = true,
    .step = step,
    .frequency = frequency,
    .answer = answer,
};
