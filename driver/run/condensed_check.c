/* The energy and the inertia of condensed models. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/condensed_check.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/about_state.h"

/* An energy this much larger than the last one looked at is looked at again, so that a run of any
 * length costs a few passes over the mesh. */
#define LOOK_AGAIN 1.2

/* Numbers that a coordinate's step of free vibration takes: y(h) = C y + S (v + g y) and v(h) = C v
 * - S (g v + omega^2 y), where g is half of the rate at which velocities are damped. */
enum { TURN_C, TURN_S, TURN_G, TURN };

/* Numbers of each coordinate in `beside`. */
enum { BESIDE = 4 + TURN };

thrum_status condensed_check_open(const thrum_model *model, condensed_check *check,
                                  thrum_error *error) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  *check = (condensed_check){.model = model, .defect = NAN};

  // the slaves start where they follow
  THRUM_TRY(thrum_reserve(&check->beside, BESIDE * (int64_t)THRUM_RANK_MAX, sizeof *check->beside,
                          "the check of a condensed model", error));
  check->followed = check->beside + 2 * THRUM_RANK_MAX;
  check->lag = check->followed + THRUM_RANK_MAX;
  check->turns = check->lag + THRUM_RANK_MAX;
  if (shape->tets == NULL || shape->basis == NULL)
    return THRUM_OK;

  // the mesh, without its matrices
  thrum_status status = thrum_model_borrow_mesh(shape, &check->mesh, error);
  THRUM_THEN(status, thrum_fem_create(&check->mesh, shape->fixed, &check->fem, error));
  THRUM_THEN(status, thrum_fem_take_state(&check->mesh, &check->fem, error));
  THRUM_THEN(status, thrum_reserve(&check->q, shape->rank, sizeof *check->q,
                                   "the check of a condensed model", error));
  THRUM_THEN(status, thrum_reserve(&check->u, 3 * shape->vertex_count, sizeof *check->u,
                                   "the check of a condensed model", error));
  if (status < 0)
    condensed_check_close(check);
  return status;
}

void condensed_check_close(condensed_check *check) {
  thrum_fem_free(&check->fem);
  thrum_model_return_mesh(&check->mesh);
  free(check->q);
  free(check->u);
  free(check->beside);
  *check = (condensed_check){.defect = NAN};
}

void condensed_check_damp(condensed_check *check, const thrum_state_def *def, double pace) {
  check->damping_alpha = def->damping_alpha / pace;
  check->damping_beta = def->damping_beta * pace;
  check->damped_at_rest = def->damping_beta > 0 && def->damping_form == THRUM_DAMPING_REST;
}

void condensed_check_look(condensed_check *check, const double *x, const double *v,
                          double potential) {
  // what the slaves would have of the kinetic energy
  const double share = thrum_condensed_inertia_share(check->model, x, v);
  double masters = 0;
  for (int64_t i = 0; i < check->model->rank; i++)
    masters += 0.5 * v[i] * v[i];
  const double whole = masters / (1 - share);
  check->kinetic = fmax(check->kinetic, whole);
  check->inertia = fmax(check->inertia, share * whole);

  // the energy of the mesh, where the body is bent more than at any time before
  if (check->u == NULL || !(fabs(potential) > LOOK_AGAIN * check->energy))
    return;
  const thrum_model *shape = thrum_condensed_shape_model(check->model);
  thrum_condensed_shape(check->model, x, NULL, check->q);
  thrum_displacement(shape, check->q, 0, shape->vertex_count, check->u, NULL);
  check->energy = fabs(potential);
  check->defect = fabs(thrum_fem_energy(&check->fem, check->u, NULL) - potential) / check->energy;
}

void condensed_check_start(condensed_check *check, const simulate_request *request, const double *q,
                           const double *p) {
  const thrum_model *model = check->model, *shape = thrum_condensed_shape_model(model);
  bool known = true;
  for (int64_t n = 0; n < request->start_count; n++)
    known = known && request->starts[n].kind == START_MODE;
  if (model == NULL || known)
    return;
  double *y = check->beside, *v = check->beside + THRUM_RANK_MAX;

  // the slaves of the start, less those that its masters show; these are not beside themselves
  thrum_condensed_shape(model, q, NULL, y);
  memset(y, 0, (size_t)model->rank * sizeof *y);
  for (int64_t h = model->rank; h < shape->rank; h++)
    y[h] = q[h] - y[h];
  if (p == NULL)
    return;
  thrum_condensed_velocity(model, q, p, v);
  memset(v, 0, (size_t)model->rank * sizeof *v);
  for (int64_t h = model->rank; h < shape->rank; h++)
    v[h] = p[h] - v[h];
}

/* C and S of y'' + 2 g y' + omega^2 y = 0 over a step of h. */
static void fill_turn(double omega2, double g, double h, double *turn) {
  const double bend2 = omega2 - g * g, bend = sqrt(fabs(bend2)), angle = bend * h;
  turn[TURN_G] = g;

  // near the critical damping both cases tend to this
  if (angle < 1e-6) {
    turn[TURN_C] = exp(-g * h);
    turn[TURN_S] = h * turn[TURN_C];
    return;
  }
  if (bend2 > 0) {
    turn[TURN_C] = exp(-g * h) * cos(angle);
    turn[TURN_S] = exp(-g * h) * sin(angle) / bend;
    return;
  }

  // a slave that only creeps, by its two rates, of which the slow one is a small difference
  const double slow = exp(-h * omega2 / (g + bend)), fast = exp(-h * (g + bend));
  turn[TURN_C] = 0.5 * (slow + fast);
  turn[TURN_S] = 0.5 * (slow - fast) / bend;
}

/* How each coordinate vibrates freely over a step of h. */
static void fill_turns(condensed_check *check, const double *omega2, int64_t rank, double h) {
  for (int64_t s = 0; s < rank; s++) {
    const double g = 0.5 * (check->damping_alpha + check->damping_beta * omega2[s]);
    fill_turn(omega2[s], g, h, check->turns + TURN * s);
  }
  check->h = h;
}

/* Free vibration over a step: of a displacement and its velocity. */
static void vibrate(const double *turn, double omega2, double *y, double *v) {
  const double c = turn[TURN_C], d = turn[TURN_S], g = turn[TURN_G], away = *y;
  *y = c * away + d * (*v + g * away);
  *v = c * *v - d * (g * *v + omega2 * away);
}

/* Returns the square of the static displacement of the masters under a force that the run lacks in
 * a step of h: that of the lag z = y - Y(x) of slaves without inertia, which obeys
 * beta z' + z = -beta Y'. The run has the force of z = -beta Y'. `shown` has all coordinates at the
 * end of the step. */
static double lag_left_out(condensed_check *check, double h, const double *shown) {
  const thrum_model *model = check->model, *shape = thrum_condensed_shape_model(model);
  const double beta = check->damping_beta, kept = exp(-h / beta);
  double load[THRUM_RANK_MAX] = {0}, force[THRUM_RANK_MAX], sum = 0;

  // exact for a constant Y': the mean over the step, and the lag at its end
  for (int64_t s = model->rank; s < shape->rank; s++) {
    const double moved = beta / h * (shown[s] - check->followed[s]);
    load[s] = shape->omega2[s] * (beta / h) * (1 - kept) * (check->lag[s] + moved);
    check->lag[s] = kept * check->lag[s] - (1 - kept) * moved;
  }

  thrum_condensed_load(model, shown, load, force);
  for (int64_t i = 0; i < model->rank; i++) {
    const double moves = force[i] / shape->omega2[i];
    sum += moves * moves;
  }
  return sum;
}

/* Steps the slaves and adds the squares of what the run does not show of them, and of all of them,
 * to missing and shown. Each vibrates about its answer to what acts on it, exactly so while that is
 * constant. Returns whether anything touches them. */
static bool step_slaves(condensed_check *check, const double *load, const double *contact,
                        double *missing, double *shown) {
  const thrum_model *shape = thrum_condensed_shape_model(check->model);
  bool touched = false;
  for (int64_t s = check->model->rank; s < shape->rank; s++) {
    double *y = check->beside + s, *v = y + THRUM_RANK_MAX;
    const double omega2 = shape->omega2[s], before = *y;
    const double answer = load ? load[s] / omega2 : 0;
    const double pressed = contact ? contact[s] / omega2 : 0, middle = answer + pressed;
    double moved = before - middle;
    vibrate(check->turns + TURN * s, omega2, &moved, v);
    *y = middle + moved;

    // the run shows the answer to the load alone
    const double lacking = pressed + moved;
    *missing += lacking * lacking;
    *shown += *y * *y;

    // and its masters keep what contact does for the slaves
    check->struck += omega2 * pressed * (*y - before);
    touched = touched || pressed != 0;
  }
  return touched;
}

/* The share of its velocities by which a body of this kinetic energy is too fast, or too slow, as
 * it has kept `given` that was not its own; all of them at most. */
static double velocity_kept(double given, double kinetic) {
  if (given == 0)
    return 0;
  return fmin(1, fabs(1 - sqrt(fmax(0, 1 - given / kinetic))));
}

/* The masters keep what impacts give to the slaves, after a step of h that ended at x. They are
 * too fast from the end of a contact on, and where that takes them vibrates as they do when they
 * are free. While they touch, a part of what the slaves have is of the static answer and comes
 * back. */
static void look_at_impacts(condensed_check *check, bool touched, double h, const double *x) {
  const thrum_model *model = check->model;
  const double *omega2 = thrum_condensed_shape_model(model)->omega2;
  double v[THRUM_RANK_MAX], kinetic = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    v[i] = (x[i] - check->followed[i]) / h;
    kinetic += 0.5 * v[i] * v[i];
  }

  // contact has ended in this step
  double kept = 0;
  if (check->touched && !touched) {
    kept = velocity_kept(check->struck - check->struck_apart, kinetic);
    check->struck_apart = check->struck;
  }
  check->touched = touched;

  // they are where they were, and go on with another velocity
  double *y = check->beside, *beside_v = y + THRUM_RANK_MAX;
  for (int64_t i = 0; i < model->rank; i++) {
    vibrate(check->turns + TURN * i, omega2[i], &y[i], &beside_v[i]);
    beside_v[i] += kept * v[i];
    check->aside += y[i] * y[i];
  }
}

void condensed_check_vibrate(condensed_check *check, const double *load, const double *contact,
                             double h, const double *x) {
  const thrum_model *model = check->model;
  if (model == NULL)
    return;

  // sines and exponentials cost more than the rest, and the step rarely changes
  const int64_t rank = thrum_condensed_shape_model(model)->rank;
  if (check->h != h)
    fill_turns(check, thrum_condensed_shape_model(model)->omega2, rank, h);
  double missing = 0, shown = 0, all[THRUM_RANK_MAX];
  for (int64_t i = 0; i < model->rank; i++)
    shown += x[i] * x[i];
  const bool touched = step_slaves(check, load, contact, &missing, &shown);

  // where the slaves follow is a pass over all pairs of masters, and their lag alone asks for it
  const int64_t known = check->damped_at_rest ? rank : model->rank;
  if (check->damped_at_rest)
    thrum_condensed_shape(model, x, NULL, all);
  else
    memcpy(all, x, (size_t)known * sizeof *all);

  // the first step has none before it to compare with
  if (check->follows && check->damped_at_rest)
    missing += lag_left_out(check, h, all);
  if (check->follows)
    look_at_impacts(check, touched, h, x);
  memcpy(check->followed, all, (size_t)known * sizeof *all);
  check->follows = true;
  check->missing += missing;
  check->shown += shown;
}

void condensed_check_report(const condensed_check *check, const thrum_model *model,
                            simulate_figures *figures) {
  figures->masters = model->rank;
  figures->follows_loads = model->follow == NULL;
  figures->inertia_share = check->kinetic > 0 ? check->inertia / check->kinetic : 0;
  figures->energy_defect = check->energy > 0 ? check->defect : NAN;
  figures->vibration_share = check->shown > 0 ? sqrt(check->missing / check->shown) : 0;
  figures->impact_share = check->aside > 0 ? sqrt(check->aside / (check->aside + check->shown)) : 0;
}
