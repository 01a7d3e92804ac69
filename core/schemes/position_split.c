/* One imexv step in the position form (design (7)): the kinetic energy of the explicit modes E is
 * split from all the rest, with half of it before and half after,
 *
 *   drift  q_E := q_E + h/2 p_E
 *   solve  0 = d - h p_I + h^2/2 [R(q-bar) + D v - f]_I,  q-bar = (q_E, q_I + d/2),  v = d/h
 *   kick   (1 + h/2 D_E) p'_E = (1 - h/2 D_E) p_E - h [R(q-bar) - f]_E
 *   then   q'_I = q_I + d,  p'_I = p_I - h [R(q-bar) + D v - f]_I
 *   drift  q'_E = q_E + h/2 p'_E
 *
 * The two in the middle are the implicit midpoint rule for 1/2 |p_I|^2 + V(q) at q_E held, so the
 * whole is a Strang splitting: symplectic and time-reversible without damping, of order 2. All p
 * are of the time of q. |I| = 0 is Stoermer-Verlet in its position form and |I| = r the implicit
 * midpoint rule. Stable for a frozen positive T iff h^2 lambda_max(T_EE) < 4.
 *
 * Rest damping is diagonal and acts in the solve and the kick. The tangent form acts in two further
 * parts, before and after, each half a step of the midpoint rule for p. = -D(q) p at q held:
 *
 *   (1 + h/4 D(q)) p := (1 - h/4 D(q)) p
 *
 * Cost: an iteration takes one force evaluation, which has R_E as well, and about |I|^2; a new
 * Jacobian a tangent and |I|^3; tangent damping two tangents and 2/3 r^3.
 * Source: Strang 1968, doi:10.1137/0705041; Hairer, Lubich & Wanner 2006, Geometric Numerical
 * Integration, II.5 and VI.3, doi:10.1007/3-540-30666-8.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/position_split.h"

#include <string.h>

#include "core/base/lane_sums.h"
#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_solve.h"
#include "core/solve/tangent_damping.h"

/* --- the step without the tangent form of damping -------------------------------------------- */

thrum_solver thrum_position_drift(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report) {
  const double h = state->def.dt;
  thrum_solver s = thrum_imexv_solver(model, state, view, report);

  // the tolerance is one of the whole step, of which the implicit modes may be a small part
  for (int32_t i = 0; i < s.first; i++) {
    const double d = h * view->p[i];
    view->middle[i] = view->q[i] + 0.5 * d;
    s.beside += d * d * (1.0 + s.weight * s.at * model->omega2[i]);
  }
  return s;
}

void thrum_position_kick(const thrum_solver *s) {
  thrum_state_view *view = s->view;
  const double h = s->state->def.dt;
  for (int32_t i = 0; i < s->first; i++) {
    const double damping = 0.5 * h * thrum_rest_damping(s->model, s->state, i);
    view->p_next[i] =
        ((1.0 - damping) * view->p[i] - h * (view->force[i] - view->load[i])) / (1.0 + damping);
    view->q_next[i] = view->middle[i] + 0.5 * h * view->p_next[i];
  }
}

static thrum_status step(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  const thrum_solver s = thrum_position_drift(model, state, view, report);
  view->restricted_from = NULL;

  // V as a quartic in q_I, with q_E held at its midpoint, and the solve
  if (s.n > 0) {
    if (s.first > 0)
      thrum_polynomial_restrict(view->kernel, model, s.first, view->middle, view->restricted,
                                view->work);
    THRUM_TRY(thrum_imexv_finish(&s, thrum_solve_increment(&s)));
  }

  // the force on the explicit modes at the point that was found
  if (s.first > 0) {
    report->potential = thrum_internal_force_part(view->kernel, model, s.first, view->middle,
                                                  view->force, view->work);
    thrum_position_kick(&s);
  }
  return THRUM_OK;
}

/* --- tangent damping -------------------------------------------------------------------------- */

/* Half a step of p. = -D(q) p: damped = 2 (1 + h/4 D)^-1 p - p, with D = alpha 1 + beta T(q).
 * Overwrites view->tangent. */
static bool damp(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                 const double *q, const double *p, double *damped) {
  const size_t rank = (size_t)state->rank;
  memcpy(view->trial, p, rank * sizeof *p);
  if (!thrum_tangent_damping_solve(model, state, view, q, 0.25 * state->def.dt, view->tangent,
                                   view->trial))
    return false;

  for (size_t i = 0; i < rank; i++)
    damped[i] = 2.0 * view->trial[i] - p[i];
  return true;
}

static double kinetic(const thrum_state *state, const double *p) {
  return 0.5 * thrum_sum_of(state->rank, p, p, NULL);
}

static thrum_status step_damped(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  if (!damp(model, state, view, view->q, view->p, view->p_damped))
    return THRUM_NOT_CONVERGED;

  // the step between has no damping of its own
  thrum_state undamped = *state;
  undamped.def.damping_alpha = undamped.def.damping_beta = 0.0;
  thrum_model bare = *model;
  bare.damping = NULL;
  thrum_state_view inner = *view;
  inner.p = view->p_damped;
  THRUM_TRY(step(&bare, &undamped, &inner, report));
  const double kept = kinetic(state, view->p_damped) - kinetic(state, view->p_next);
  if (!damp(model, state, view, view->q_next, view->p_next, view->p_next))
    return THRUM_NOT_CONVERGED;

  // what the two halves have taken
  report->dissipation = kinetic(state, view->p) - kept - kinetic(state, view->p_next);
  report->dissipation_known = true;
  return THRUM_OK;
}

thrum_status thrum_step_position(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report) {
  return thrum_tangent_damped(state) ? step_damped(model, state, view, report)
                                     : step(model, state, view, report);
}

const thrum_scheme_row thrum_position_scheme = {
    .scheme = THRUM_SCHEME_POSITION,
    .integrator = THRUM_INTEGRATOR_IMEXV,
    .form = THRUM_FORM_POSITION,
    .restricts = true,
    .step = thrum_step_position,
    .frequency = thrum_imexv_frequency,
    .problem = thrum_imexv_problem,
};
