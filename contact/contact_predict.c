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
 * end is measured for. Cost: one force evaluation, unless the step before has left R at the start
 * (thrum_scheme_row.start).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_predict.h"

#include <string.h>

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/schemes.h"
#include "core/schemes/staggered_momentum.h"
#include "core/state/state_layout.h"
#include "runtime/condensed/manifold.h"
#include "thrum/floating_frame.h"

/* How mode i moves in a step, as its scheme makes it; `own` of the first modes have a rule of their
 * own. */
static thrum_mode_answer answer_of(const thrum_model *model, const thrum_state *state, int32_t own,
                                   int32_t i) {
  const thrum_scheme_row *row = thrum_row_of(state);
  if (row->answer)
    return row->answer(model, state, own, i);
  return (thrum_mode_answer){1.0, 0.5, 0.5, i < state->split ? 0.0 : 0.25};
}

/* Fills the displacement over the step without contact, and the answer to a unit mean load, with
 * the stiffness at rest. */
static void fill_unloaded(const thrum_contact_run *run, const thrum_known_start *start) {
  const thrum_state *state = run->state;
  const thrum_scheme_row *row = thrum_row_of(state);
  const int32_t own = row->own_modes ? row->own_modes(run->model, state) : 0;
  const thrum_contact_view *view = &run->view;
  const double h = run->dt;

  // one linear step of each mode, as its scheme makes it
  for (int32_t i = 0; i < state->rank; i++) {
    const thrum_mode_answer by = answer_of(run->model, state, own, i);
    const double damping = thrum_rest_damping(run->model, state, i);
    const double scale =
        1.0 / (1.0 + by.damping * h * damping + by.stiffness * h * h * run->model->omega2[i]);
    const double load = run->environment->load ? run->environment->load[i] : 0.0;
    const double pushed = by.load * h * h;
    view->weights[i] = pushed * scale;
    view->unloaded[i] = start->q[i] - view->q[i] +
                        scale * (by.momentum * h * start->p[i] + pushed * (load - start->force[i]));
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

/* R at the start of the step, where no scheme has kept it. */
static void evaluate(const thrum_contact_run *run, const thrum_model *model,
                     thrum_state_view *view) {
  const thrum_state *state = run->state;

  // synchronising has evaluated R of the explicit modes only, less kappa q in the quadratic split
  const bool plain = state->scheme == THRUM_SCHEME_QUADRATIC && state->split < state->rank;
  if (plain || thrum_staggered_modes(state) < state->rank)
    thrum_internal_force_by(view->kernel, model, view->q, view->force, view->work);
  add_rotation_force(run, view);
}

/* Fills how the body moves in the step without contact. */
static void fill_step(const thrum_contact_run *run, const thrum_model *model,
                      thrum_state_view *view) {
  const thrum_scheme_row *row = thrum_row_of(run->state);
  thrum_known_start start;
  if (row->start && !run->environment->inertia && row->start(run->state, view, &start)) {
    fill_unloaded(run, &start);
    return;
  }
  evaluate(run, model, view);
  start =
      (thrum_known_start){run->view.q, row->velocity_by_dt ? view->p : run->view.p, view->force};

  // on a manifold the mass is that of the slaves as well
  if (run->state->scheme != THRUM_SCHEME_MANIFOLD ||
      !thrum_manifold_predict(run->model, run->state, view, run->environment->load,
                              run->view.unloaded, run->view.weights))
    fill_unloaded(run, &start);
}

thrum_status thrum_contact_predict(thrum_contact_run *run, thrum_error *error) {
  thrum_state *state = run->state;
  const size_t vector = (size_t)state->rank * sizeof(double);
  thrum_state_view view = thrum_state_view_of(state);
  thrum_model seen;
  const thrum_model *model = thrum_seen_model(run->model, state, &seen);

  // momenta at the start of the step; a staggered state keeps them half a step away
  if (thrum_staggered_synchronise(model, state, &view, NULL) != THRUM_OK)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "the tangent damping cannot be solved for at this state");
  memcpy(run->view.q, view.q, vector);
  memcpy(run->view.p, view.p_next, vector);
  fill_step(run, model, &view);

  // a prediction beyond the numbers would spoil the state
  if (!thrum_all_finite(run->view.p, state->rank) ||
      !thrum_all_finite(run->view.unloaded, state->rank))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "the forces at this state are beyond the range of finite numbers");
  return THRUM_OK;
}
