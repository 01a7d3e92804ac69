/* The energy balance of the integrators that neither conserve the energy nor are monitored by
 * stability.c: newmark, verlet, midpoint, fox-goodwin, those for comparison, and imexv without its
 * monitor (design 4).
 *
 *   explained = E at the beginning + work of the loads - dissipation
 *
 * Every few steps, and after a step that moves more than those lately, E of q and the synchronised
 * p is compared with it. E far above it is energy that nothing has put in: the state says so from
 * then on (`grew`), until E is explained again. fox-goodwin, which is lost within a few steps once
 * it is beyond its stability limit, repeats the step by the energy integrator instead, well before.
 *
 * Work and dissipation of changing loads and of damping are those of the steps to second order
 * only, so part of what they have moved is allowed for; where that becomes as much as the energy
 * itself, the balance begins anew.
 *
 * Cost: 4 r operations a step; a look takes one evaluation of V, and what synchronising p does.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/energy_balance.h"

#include <math.h>

#include "core/polynomial/polynomial_private.h"
#include "core/schemes/schemes.h"
#include "core/schemes/staggered_momentum.h"
#include "core/step/scheme_change.h"
#include "runtime/guard/energy_correction.h"

#define BALANCE_STEPS 16    /* between two looks at the energy in quiet motion */
#define BALANCE_FIRST 8     /* steps from the beginning on that are looked at in any case */
#define BALANCE_MOTION 1.5  /* times the largest motion lately: a step beyond is looked at */
#define BALANCE_FADE 0.99   /* of that largest motion, in each step */
#define BALANCE_GREW 1.0    /* unexplained energy, in energies, from which on it has grown */
#define BALANCE_SWITCH 0.15 /* and from which on a monitored fox-goodwin gives way */
#define BALANCE_MOVED 0.1   /* share of what loads and damping have moved that the sum may err by */
#define BALANCE_MOST 1e300  /* energies above it [J] could overflow in sums: they have grown */
#define BALANCE_LEAST 1e-300 /* energies below it [J] are rounding */

static bool is_monitored(const thrum_state *state) {
  return state->def.integrator == THRUM_INTEGRATOR_FOX_GOODWIN && state->def.adaptive;
}

void thrum_energy_balance_reset(thrum_state *state) {
  state->balance = (thrum_energy_balance){.begin = -1};
}

/* Energy of q and the p that belongs to it [J], from a state that stores p as `load_before` says;
 * INFINITY where it has none. */
static double energy_at(const thrum_model *model, const thrum_state *state,
                        const thrum_state_view *view, double *q, double *p, double *load_before) {
  thrum_state_view there = *view;
  double sum = 0.0;

  // the results of the step stay as they are
  there.q = q;
  there.p = p;
  there.load_before = load_before;
  there.p_next = view->trial;
  there.force = view->force_2;
  there.jacobian_next = view->tangent_2;
  if (thrum_staggered_synchronise(model, state, &there, &sum) < 0)
    return INFINITY;
  for (int32_t i = 0; i < state->rank; i++)
    sum += 0.5 * (there.p_next[i] * there.p_next[i]);
  return sum;
}

/* The balance begins with the energy before the step. */
static void begin(const thrum_model *model, thrum_state *state, const thrum_state_view *view) {
  const double energy = energy_at(model, state, view, view->q, view->p, view->load_before);
  if (!(fabs(energy) < BALANCE_MOST))
    return;
  state->balance = (thrum_energy_balance){
      .explained = energy, .scale = fabs(energy), .begin = state->report.steps};
}

/* Adds what the loads and the damping did in the step. Returns its motion: the kinetic energy of
 * its increment and that of the stiffness at rest, and with Newmark's acceleration also the work
 * that it does in the step to come, which sees a body that is stiffer than at rest. */
static double add_step(const thrum_model *model, thrum_state *state, const thrum_state_view *view,
                       const thrum_solve_report *report) {
  const double rate = 1.0 / (state->def.dt * state->def.dt);
  thrum_energy_balance *b = &state->balance;
  double work = 0.0, motion = 0.0, kick = 0.0;
  bool jumps = false;
  for (int32_t i = 0; i < state->rank; i++) {
    const double d = view->q_next[i] - view->q[i];
    work += view->load[i] * d;
    jumps |= view->load[i] != view->load_before[i];
    motion += (rate + 0.25 * model->omega2[i]) * (d * d);
  }
  for (int32_t i = 0; thrum_carries_acceleration(state) && i < state->rank; i++)
    kick += view->acceleration_next[i] * view->acceleration_next[i];
  motion += kick / rate;

  // a constant load is one more potential, whose work comes back
  const double moved = (jumps ? fabs(work) : 0.0) + fabs(report->dissipation);
  const double explained = b->explained + work - report->dissipation;
  if (!(fabs(explained) < BALANCE_MOST && b->moved + moved < BALANCE_MOST)) {
    b->grew = 1;
    return 0.0;
  }
  b->explained = explained;
  b->moved += moved;
  b->scale = fmax(b->scale, explained);
  return motion < BALANCE_MOST ? motion : BALANCE_MOST;
}

/* Whether the energy is worth a look after a step of that motion. */
static bool is_due(thrum_state *state, double motion) {
  thrum_energy_balance *b = &state->balance;
  const int64_t steps = state->report.steps;
  const bool larger = !(motion <= BALANCE_MOTION * b->motion);
  b->motion = fmax(motion, BALANCE_FADE * b->motion);
  return larger || steps < b->begin + BALANCE_FIRST || (steps + 1) % BALANCE_STEPS == 0;
}

bool thrum_energy_balance_enter(const thrum_model *model, thrum_state *state,
                                const thrum_state_view *view, const thrum_solve_report *report) {
  thrum_energy_balance *b = &state->balance;
  if (b->begin < 0)
    begin(model, state, view);
  if (b->begin < 0)
    return false;
  const thrum_energy_balance before = *b;
  if (!is_due(state, add_step(model, state, view, report)))
    return false;

  // the error, and how much of it is none
  const double energy = energy_at(model, state, view, view->q_next, view->p_next, view->load);
  const double error = energy - b->explained, allowed = BALANCE_MOVED * b->moved;
  b->scale = fmax(b->scale, thrum_exchanged_energy_by(view->kernel, model, view->q_next));
  const bool small = fabs(energy) < BALANCE_LEAST;
  b->grew = !small && !(error <= BALANCE_GREW * b->scale + allowed);
  if (is_monitored(state) && state->scheme == THRUM_SCHEME_FOX_GOODWIN && !small &&
      !(fabs(error) <= BALANCE_SWITCH * b->scale + allowed)) {
    *b = before;
    return true;
  }

  // sums that may err by as much as the energy say nothing more
  if (!b->grew && allowed > b->scale)
    thrum_energy_balance_reset(state);
  return false;
}

thrum_status thrum_energy_balance_switch(const thrum_model *model, thrum_state *state,
                                         thrum_state_view *view) {
  thrum_energy_balance *b = &state->balance;
  thrum_scheme_count_switch(state);

  // the steps before may have spoilt the energy already, between two looks
  const double energy = energy_at(model, state, view, view->q, view->p, view->load_before);
  const double error = energy - b->explained, allowed = BALANCE_MOVED * b->moved;
  const bool spoilt = !(fabs(error) <= BALANCE_SWITCH * b->scale + allowed);
  b->grew = !(error <= BALANCE_GREW * b->scale + allowed);

  // the energy integrator returns to the explained energy where that is exact, or is the better one
  if ((b->moved == 0.0 || spoilt) && b->explained > 0.0)
    thrum_energy_correction_open(state, b->explained);
  return thrum_scheme_change(model, state, view, THRUM_SCHEME_ENERGY, 0);
}
