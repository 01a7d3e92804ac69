/* What the step of a body with contact is made of: predict, find rows, hand over the load, look at
 * what the step really did (docs/contact.md). contact_pairs_step.c calls these for each body of a
 * group, and contact_alone.c has a body alone step as a group of one.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_step.h"

#include <math.h>
#include <string.h>

#include "contact/contact_check.h"
#include "contact/contact_elastic.h"
#include "contact/contact_energy.h"
#include "contact/contact_predict.h"
#include "contact/contact_pull.h"
#include "contact/contact_row.h"
#include "contact/contact_rows.h"
#include "contact/contact_solve.h"
#include "core/base/finite.h"
#include "core/schemes/staggered_momentum.h"
#include "core/state/state_layout.h"
#include "runtime/guard/guards.h"
#include "thrum/floating_frame.h"

#define FOLLOWED 4.0 /* h omega up to which steps follow a coordinate */

/* Fills the rotation of a run: how the body would rotate without contact, and its response. */
static void fill_rigid_frame(thrum_contact_run *run) {
  const thrum_rigid_frame *rigid_frame = run->environment->rigid_frame;
  const thrum_placement *placement = run->environment->placement;
  thrum_rigid_frame alone = *rigid_frame;
  thrum_rigid_frame_velocity(rigid_frame, placement, run->spin);
  thrum_rigid_frame_step(&alone, placement, run->environment->torque, run->dt, run->unloaded_turn);
  double half[9];
  thrum_multiply3(run->axes, rigid_frame->inverse, half);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      run->turn_weight[3 * i + j] =
          0.5 * run->dt * run->dt * thrum_dot3(half + 3 * i, run->axes + 3 * j);
  thrum_apply3(run->axes, rigid_frame->centre, run->centre);
  for (int axis = 0; axis < 3; axis++)
    run->centre[axis] += run->origin[axis];
}

void thrum_contact_place(thrum_contact_run *run) {
  const thrum_contact_environment *environment = run->environment;
  const thrum_translation *t = environment->translation;
  const thrum_placement now =
      thrum_placement_now(environment->placement, environment->rigid_frame, t ? t->position : NULL);
  memcpy(run->axes, now.axes, sizeof run->axes);
  memcpy(run->origin, now.origin, sizeof run->origin);

  // what moves without contact: a translation under its force, a rotation
  if (t)
    run->mass_weight = 0.5 * run->dt * run->dt / t->mass;
  for (int axis = 0; axis < 3 && t; axis++)
    run->unloaded[axis] = run->dt * t->velocity[axis] + run->mass_weight * environment->force[axis];
  if (environment->rigid_frame)
    fill_rigid_frame(run);
}

/* How long a body takes to lie down on its own elasticity [s]: 1 / omega_1. */
static double settling_of(const thrum_model *model) {
  double lowest = INFINITY;
  for (int32_t i = 0; i < model->rank; i++)
    if (model->omega2[i] > 0.0)
      lowest = fmin(lowest, model->omega2[i]);
  return 1.0 / sqrt(lowest);
}

thrum_status thrum_contact_open(const thrum_model *model, thrum_state *state,
                                thrum_contact *contact,
                                const thrum_contact_environment *environment,
                                thrum_contact_run *run, thrum_error *error) {
  THRUM_TRY(thrum_contact_check(model, state, contact, error));
  THRUM_TRY(thrum_contact_environment_check(model, contact, environment, error));

  memset(run, 0, sizeof *run);
  run->model = model;
  run->state = state;
  run->contact = contact;
  run->environment = environment;
  run->view = thrum_contact_view_of(contact);
  run->dt = state->def.dt;
  run->settling = settling_of(model);
  thrum_contact_place(run);
  return THRUM_OK;
}

thrum_status thrum_contact_apply(thrum_contact_run *run, thrum_error *error) {
  memcpy(run->foreseen, run->turned, sizeof run->foreseen);

  // the rotation that the torque really makes, by a trial step; with an inertia the state's step
  // says it
  if (run->environment->rigid_frame && !run->environment->inertia) {
    thrum_rigid_frame trial = *run->environment->rigid_frame;
    thrum_rigid_frame_step(&trial, run->environment->placement, run->torque, run->dt, run->turned);
  }

  // thrum_contact_end needs them, perhaps in another call
  memcpy(run->contact->moved, run->moved, sizeof run->moved);
  memcpy(run->contact->force, run->force, sizeof run->force);
  memcpy(run->contact->turned, run->turned, sizeof run->turned);
  memcpy(run->contact->torque, run->torque, sizeof run->torque);

  // forces that are solved for may grow without end, which is no mistake of the caller's
  const thrum_status status = thrum_state_set_force(run->model, run->state, run->view.load, error);
  return status == THRUM_BAD_VALUE ? thrum_contact_beyond(error) : status;
}

thrum_status thrum_contact_advance(thrum_contact_run *run, thrum_error *error) {
  const thrum_contact_environment *environment = run->environment;
  if (!environment->inertia)
    return thrum_step(run->model, run->state, error);
  run->stepped = *environment->rigid_frame;
  const thrum_status status = thrum_floating_frame_step(
      run->model, run->state, environment->inertia, environment->placement, &run->stepped,
      run->torque, run->turned, environment->inertia_work, error);
  memcpy(run->contact->turned, run->turned, sizeof run->turned);
  return status;
}

void thrum_contact_seek(thrum_contact_run *run) {
  memcpy(run->view.sought, run->view.moved, (size_t)run->contact->rank * sizeof(double));
  memcpy(run->sought, run->moved, sizeof run->sought);
  memcpy(run->sought_turn, run->turned, sizeof run->sought_turn);
}

/* A search goes by the forces of the last step as well, where they hold the body back: what lies
 * still would go far without them. By forces f the way becomes x + W f, which is shorter in the
 * metric of W^-1 where f (2 x + W f) < 0. What moves fast is not sought so between bodies, and
 * what goes otherwise is searched again (contact_pairs_step.c). */
static void foresee(thrum_contact_run *run) {
  const thrum_contact *contact = run->contact;
  const double *f = run->view.pressing, *w = run->view.weights;
  double along = 0.0, turn[3];
  thrum_contact_seek(run);
  thrum_apply3(run->turn_weight, contact->whirled, turn);
  for (int32_t i = 0; i < contact->rank; i++)
    along += f[i] * (2.0 * run->view.moved[i] + w[i] * f[i]);
  for (int axis = 0; axis < 3; axis++)
    along += contact->pressed[axis] *
                 (2.0 * run->moved[axis] + run->mass_weight * contact->pressed[axis]) +
             contact->whirled[axis] * (2.0 * run->turned[axis] + turn[axis]);
  run->foresees = contact->pull_count > 0 || along < 0.0;
  if (!(along < 0.0))
    return;
  for (int32_t i = 0; i < contact->rank; i++)
    run->view.sought[i] += w[i] * f[i];
  for (int axis = 0; axis < 3; axis++) {
    run->sought[axis] += run->mass_weight * contact->pressed[axis];
    run->sought_turn[axis] += turn[axis];
  }
}

/* Keeps what contact and links did, for that. */
static void keep_pressing(const thrum_contact_run *run) {
  const thrum_contact_environment *environment = run->environment;
  thrum_contact *contact = run->contact;
  for (int32_t i = 0; i < contact->rank; i++)
    run->view.pressing[i] = run->view.load[i] - (environment->load ? environment->load[i] : 0.0);
  thrum_subtract3(contact->force, environment->force, contact->pressed);
  thrum_subtract3(contact->torque, environment->torque, contact->whirled);
}

thrum_status thrum_contact_prepare(thrum_contact_run *run, thrum_error *error) {
  THRUM_TRY(thrum_contact_predict(run, error));
  // pulls alone first, so that a point which they drag into an obstacle gets its row in time
  thrum_contact_pulls(run);
  run->contact->row_count = 0;
  thrum_contact_solve(run);
  foresee(run);
  thrum_contact_rows(run);
  return THRUM_OK;
}

thrum_contact_whole thrum_contact_keep_whole(const thrum_contact_environment *environment) {
  thrum_contact_whole kept = {.way = {0}};
  if (environment->translation)
    kept.way = *environment->translation;
  if (environment->rigid_frame)
    kept.frame = *environment->rigid_frame;
  return kept;
}

void thrum_contact_put_back_whole(const thrum_contact_environment *environment,
                                  const thrum_contact_whole *kept) {
  if (environment->translation)
    *environment->translation = kept->way;
  if (environment->rigid_frame)
    *environment->rigid_frame = kept->frame;
}

bool thrum_contact_whole_is_finite(const thrum_contact_environment *environment) {
  const thrum_translation *way = environment->translation;
  const thrum_rigid_frame *frame = environment->rigid_frame;
  const bool moves =
      !way || (thrum_all_finite(way->position, 3) && thrum_all_finite(way->velocity, 3));
  return moves &&
         (!frame || (thrum_all_finite(frame->attitude, 9) && thrum_all_finite(frame->momentum, 3)));
}

/* A coordinate of high frequency neither follows a step, which turns its velocity round, nor comes
 * to rest by the integrator, which conserves what it cannot follow: a body that lies on something
 * would tremble for seconds. A step of the midpoint rule turns it by the angle 2 atan z, z = h w/2,
 * and a factor of ((z - 1)/(z + 1))^2 on its momentum makes that critically damped: it is what no
 * touch can hold up, as it acts on the velocity, and not on the displacement, which is held. */
double thrum_contact_calm_factor(double dt, double omega2) {
  const double z = 0.5 * dt * sqrt(fmax(omega2, 0.0)), root = (z - 1.0) / (z + 1.0);
  return 2.0 * z > FOLLOWED ? root * root : 1.0;
}

double thrum_contact_calm(thrum_contact_run *run) {
  thrum_state *state = run->state;
  const thrum_state_view view = thrum_state_view_of(state);
  double lost = 0.0;

  // of a coupled body the shape has a part of the angular momentum, of a condensed one other masses
  if (run->environment->inertia || state->scheme == THRUM_SCHEME_MANIFOLD)
    return 0.0;
  for (int32_t i = thrum_staggered_modes(state); i < state->rank; i++) {
    const double by = thrum_contact_calm_factor(run->dt, run->model->omega2[i]), p = view.p[i];
    view.p[i] *= by;
    lost += 0.5 * (p * p - view.p[i] * view.p[i]);
    if (state->carried)
      view.p_corrected[i] *= by;
  }
  thrum_guards_take(state, lost);
  return lost;
}

/* Does the body touch an obstacle by a row that takes energy? */
static bool rests(const thrum_contact_run *run) {
  bool rests = false;
  for (int64_t n = 0; n < run->contact->row_count && !rests; n++)
    rests = thrum_contact_row_takes(run->view.rows + n);
  return rests;
}

/* Where obstacles take no energy, what the step lost in spite of it [J] goes back, or is owed until
 * they are touched again. */
static void give_back(thrum_contact_run *run, double lost) {
  thrum_contact *contact = run->contact;
  if (!thrum_contact_is_elastic(run))
    return;
  double driven = 0.0;
  contact->lost -= lost;
  contact->owed += lost;
  contact->owed -= thrum_contact_give(run, contact->owed, &driven);
  contact->driven += driven;
}

bool thrum_contact_finish(thrum_contact_run *run) {
  const thrum_contact_environment *environment = run->environment;
  const double lost = run->contact->lost;
  memcpy(run->moved, run->contact->moved, sizeof run->moved);
  memcpy(run->turned, run->contact->turned, sizeof run->turned);
  thrum_contact_settle(run);
  const bool calmed = rests(run);
  if (calmed)
    run->contact->impact += thrum_contact_calm(run);
  if (environment->translation)
    thrum_translation_step(environment->translation, run->contact->force, run->dt);
  if (environment->inertia)
    *environment->rigid_frame = run->stepped;
  else if (environment->rigid_frame)
    thrum_rigid_frame_step(environment->rigid_frame, environment->placement, run->contact->torque,
                           run->dt, NULL);
  give_back(run, run->contact->lost - lost);
  keep_pressing(run);
  run->contact->begun = 0;
  return calmed;
}

thrum_status thrum_contact_end(const thrum_model *model, thrum_state *state, thrum_contact *contact,
                               const thrum_contact_environment *environment, thrum_error *error) {
  thrum_contact_run run;
  THRUM_TRY(thrum_contact_open(model, state, contact, environment, &run, error));
  if (!contact->begun || contact->pull_count != environment->pull_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "no step has begun in this environment");

  // what cannot be booked is refused before anything is
  memcpy(run.moved, contact->moved, sizeof run.moved);
  memcpy(run.turned, contact->turned, sizeof run.turned);
  thrum_contact_measure(&run, thrum_state_view_of(state).q);
  if (!thrum_contact_counts(&run))
    return thrum_contact_beyond(error);
  thrum_contact_finish(&run);
  return THRUM_OK;
}

bool thrum_contact_allowed(thrum_contact_run *run) {
  const thrum_contact *contact = run->contact;
  const double work = thrum_contact_measure(run, thrum_state_view_of(run->state).q);
  double granted = 0.0;
  for (int64_t n = 0; n < contact->row_count && contact->fresh; n++)
    granted += run->view.rows[n].touch.stored;
  const double left = contact->stored + contact->lost + granted - work;
  return left >= -THRUM_ROUNDING * (contact->flow + thrum_contact_flow(run));
}

void thrum_contact_return(thrum_contact_run *run) {
  const double *q = thrum_state_view_of(run->state).q;

  // the part of the step that the prediction did not see
  for (int32_t i = 0; i < run->contact->rank; i++)
    run->view.unloaded[i] += q[i] - run->view.q[i] - run->view.moved[i];
  for (int axis = 0; axis < 3; axis++)
    run->unloaded_turn[axis] += run->turned[axis] - run->foreseen[axis];

  memcpy(run->state, run->view.snapshot, (size_t)run->contact->state_bytes);
}

void thrum_contact_again(thrum_contact_run *run) {
  thrum_contact_return(run);
  run->contact->redone++;
}
