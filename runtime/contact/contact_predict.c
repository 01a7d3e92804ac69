/* Prediction of the end of a step without contact (docs/contact.md): the integrators of design 5 to
 * 7, linear about the present state with the stiffness at rest,
 *
 *   dq_i = s_i [h p_i + h^2/2 (f_i - R_i(q))],   s_i = 1 / (1 + h/2 d_i + h^2/4 w_i^2),
 *
 * without the last term for explicit modes and with beta_N for 1/4 with Newmark, with beta_i and
 * its stored momentum with Fox-Goodwin, with lambda_i and nu_i with energy. A further mean load f
 * adds h^2/2 s_i f_i. On the manifold of a condensed model the mass is that of design 17, a matrix,
 * of which a load is answered by the diagonal of the inverse (thrum_manifold_predict). Exact for a
 * linear body at rest damping with all but Stoermer-Verlet's damping; what a step leaves of it, its
 * end is measured for. Cost: one force evaluation.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/staggered_momentum.h"
#include "core/state/state_layout.h"
#include "runtime/comparison/fox_goodwin.h"
#include "runtime/condensed/manifold.h"
#include "runtime/contact/contact_private.h"
#include "runtime/guard/frequency_matching.h"
#include "runtime/points/point_flow.h"
#include "thrum/floating_frame.h"

/* How a mode moves in a step: by s_i [momentum h p_i + load h^2 (f_i - R_i)], s_i = 1 / (1 +
 * damping h d_i + stiffness h^2 w_i^2). */
typedef struct answer {
  double momentum, load, damping, stiffness;
} answer;

/* The same of a mode whose frequency is matched. */
static answer answer_of_matched(const thrum_model *model, const thrum_state *state, int32_t i) {
  const thrum_matched_step by = thrum_matched_step_of(model, state, i);
  const double square = by.stretch * by.stretch;
  return (answer){by.stretch, 0.5 * square, 0.5 * square * (by.speed * by.speed), 0.25 * square};
}

/* That of mode i; the first `low` modes have Fox-Goodwin's beta, or a time step of their own. */
static answer answer_of(const thrum_model *model, const thrum_state *state, int32_t low,
                        int32_t i) {
  switch ((thrum_scheme)state->scheme) {
  case THRUM_SCHEME_NEWMARK:
    return (answer){1.0, 0.5, 0.5, state->def.newmark_beta};
  case THRUM_SCHEME_FOX_GOODWIN:
    return (answer){1.0, 0.5, 0.5, i < low ? 1.0 / 12.0 : 0.25};
  case THRUM_SCHEME_ENERGY:
    if (i < low)
      return answer_of_matched(model, state, i);
    return (answer){1.0, 0.5, 0.5, 0.25};

  // these take their forces at the end of the step
  case THRUM_SCHEME_BACKWARD_EULER:
  case THRUM_SCHEME_SEMI_IMPLICIT_EULER:
    return (answer){1.0, 1.0, 1.0, 1.0};
  case THRUM_SCHEME_RK4:
    return (answer){1.0, 0.5, 0.5, 1.0 / 12.0}; // as far as its h^4
  case THRUM_SCHEME_THESIS:
  case THRUM_SCHEME_QUADRATIC:
  case THRUM_SCHEME_POSITION:
  case THRUM_SCHEME_MANIFOLD:
    break;
  }
  return (answer){1.0, 0.5, 0.5, i < state->split ? 0.0 : 0.25};
}

/* Fills the displacement over the step without contact, and the answer to a unit mean load, with
 * the stiffness at rest. */
static void fill_unloaded(const thrum_contact_run *run, const double *momentum,
                          const double *force) {
  const thrum_state *state = run->state;
  const int32_t low = state->scheme == THRUM_SCHEME_ENERGY
                          ? thrum_matched_modes(run->model, state)
                          : thrum_fox_goodwin_modes(run->model, state);
  const thrum_contact_view *view = &run->view;
  const double h = run->dt;

  // one linear step of each mode, as its scheme makes it
  for (int32_t i = 0; i < state->rank; i++) {
    const answer by = answer_of(run->model, state, low, i);
    const double damping = thrum_rest_damping(run->model, state, i);
    const double scale =
        1.0 / (1.0 + by.damping * h * damping + by.stiffness * h * h * run->model->omega2[i]);
    const double load = run->environment->load ? run->environment->load[i] : 0.0;
    const double pushed = by.load * h * h;
    view->weights[i] = pushed * scale;
    view->unloaded[i] = scale * (by.momentum * h * momentum[i] + pushed * (load - force[i]));
  }
}

/* The forces of a rotation that is coupled to the shape, into the forces of the prediction. */
static void add_rotation_force(const thrum_contact_run *run, const thrum_state_view *view) {
  const thrum_contact_environment *environment = run->environment;
  if (!environment->inertia)
    return;
  thrum_floating_frame_force(environment->inertia, environment->placement, environment->rigid_frame,
                             view->q, view->p, view->direction, environment->inertia_work);
  for (int32_t i = 0; i < run->state->rank; i++)
    view->force[i] -= view->direction[i];
}

thrum_status thrum_contact_predict(thrum_contact_run *run, thrum_error *error) {
  thrum_state *state = run->state;
  const int32_t r = state->rank;
  thrum_state_view view = thrum_state_view_of(state);
  thrum_model flowed;
  const thrum_model *model = thrum_flowed_model(run->model, state, &flowed);

  // momenta at the start of the step; a staggered state keeps them half a step away
  const thrum_status synchronised = thrum_staggered_synchronise(model, state, &view, NULL);
  if (synchronised == THRUM_OK) {

    // synchronising has evaluated R of the explicit modes only, less kappa q in the quadratic split
    const bool plain = state->scheme == THRUM_SCHEME_QUADRATIC && state->split < r;
    if (plain || thrum_staggered_modes(state) < r)
      thrum_internal_force_by(view.kernel, model, view.q, view.force, view.work);

    for (int32_t i = 0; i < r; i++) {
      run->view.q[i] = view.q[i];
      run->view.p[i] = view.p_next[i];
    }
    add_rotation_force(run, &view);
    // on a manifold the mass is that of the slaves as well
    const bool own = state->scheme == THRUM_SCHEME_FOX_GOODWIN;
    if (state->scheme != THRUM_SCHEME_MANIFOLD ||
        !thrum_manifold_predict(run->model, state, &view, run->environment->load,
                                run->view.unloaded, run->view.weights))
      fill_unloaded(run, own ? view.p : run->view.p, view.force);
  }
  if (synchronised != THRUM_OK)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "the tangent damping cannot be solved for at this state");

  // a prediction beyond the numbers would spoil the state
  if (!thrum_all_finite(run->view.p, r) || !thrum_all_finite(run->view.unloaded, r))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the forces at this state are beyond the range of finite numbers");
  return THRUM_OK;
}
