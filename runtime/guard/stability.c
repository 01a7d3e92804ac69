/* The energy monitor of imexv (design 4; stability.h): it compares the energy balance of a run with
 * a reference, corrects slow drift, and switches to the energy integrator where the balance grows.
 *
 * The balance is B = E - work + dissipation with the synchronised energy E, which the kick has for
 * nothing. Three comparisons decide:
 *
 *   fast   B with its first value. Stoermer-Verlet conserves a modified Hamiltonian, which lies
 *          h^2/8 |R_E - f_E|^2 below E. Without that part a linear mode shows no ripple, but a mode
 *          beyond the stability limit shows no growth either, so E itself is compared too. Beyond
 *          the limits the energy integrator takes over: at once if the error is urgent, else at a
 *          step where E is near its reference; until the energy has clearly fallen.
 *   slow   the mean of B over a window with that of the first windows. Energy that modes exchange
 *          makes these means scatter, and comes back; a run drifts when the mean of many windows
 *          is off by more than that. From then on the error goes back through the momentum
 *          (energy_correction.c) by a proportional and integral law; where that becomes much, the
 *          energy integrator takes over.
 *   ahead  the energy before a step shows one step late what the step before has spoilt. So the
 *          energy at the end is evaluated before a step is kept that moves more than those before
 *          it, the first one included. An impulsive load injects energy with an error of order 1
 *          relative to it, so the reference is reset. The same is done where changing loads or
 *          damping move much energy.
 *
 * Each change synchronises p, changes the scheme and shifts p again. Decisions go into a copy of
 * the header and into scratch, so that a step that fails leaves no trace.
 * Cost: |E| operations a step, two forces a correction.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/stability.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/dissipation.h"
#include "core/schemes/mode_split.h"
#include "core/schemes/staggered_momentum.h"
#include "core/step/scheme_change.h"
#include "runtime/guard/energy_correction.h"

/* Shares are relative to the largest energy lately. */
#define WINDOW_STEPS 128     /* of a mean of the balance */
#define NUMBER_NEAR 0.9      /* stability number that is near its limit, if it also is */
#define NUMBER_MOVED 1.02    /* more than so many times that of the explicit modes at rest */
#define NUMBER_CLOSE 1.2     /* up to which a quarter of the usual steps lies between two samples */
#define NUMBER_CLOSER 1.45   /* and an eighth; beyond it one */
#define ENERGY_STEPS 32      /* position form: between two energies in quiet motion, */
#define ENERGY_STEPS_FIRST 8 /* and in the first window */
#define NUMBER_DRIFT 0.04    /* of the stability number until the next sample, at most */
#define REFERENCE_WINDOWS 16 /* whose mean is the reference */
#define SWITCHED_STEPS 512   /* between two looks at a return from the energy integrator */
#define ERROR_FAST 0.03      /* error of B that leads to a switch */
#define ERROR_URGENT 0.08    /* the same without waiting; four times it for E itself */
#define BLOCK_WINDOWS 64     /* whose mean says whether a run drifts: by more than their scatter, */
#define BLOCK_DRIFT 2e-3     /* or by this */
#define DRIFT_WINDOW 1e-4    /* drift of a window's mean that is corrected in a run that drifts */
#define DRIFT_SUM 1.6e-3     /* the same for the sum over windows, */
#define DRIFT_FORGET 0.015625   /* of which this share is forgotten in each */
#define INTEGRAL_GAIN 0.25      /* of the correction; its proportional gain is 1 */
#define CORRECTION_MOST 0.04    /* one correction, or the net of all: more leads to a switch */
#define CORRECTION_KINETIC 0.25 /* kinetic energy that a correction needs */
#define SWITCH_NEAR 1e-3        /* E this near to its reference: a waiting switch is made */
#define DRIVEN 1e-3             /* moved by loads and damping in a window: the reference is reset */
#define LOAD_JUMP 0.1           /* energy that a change of the load moves in one step */
#define MOTION_KNOWN 2.0        /* times the largest motion lately: a step beyond looks ahead, */
#define FIRST_STEPS 8           /* and so do the first ones */
#define FOLLOW 2e-5             /* error by damping from which on the reference follows */
#define DAMPING_ERROR 0.05      /* share of the dissipated energy that B may err by */
#define MEMORY 256.0            /* steps for which dissipation is remembered */
#define FALLEN 0.25             /* of the energy at the switch: imexv returns below it */
#define ENERGY_LEAST 1e-300     /* [J]; the balance of smaller energies is rounding */

/* --- reference -------------------------------------------------------------------------------- */

/* Largest energy lately [J]. */
static double scale_now(const thrum_stability_monitor *m) {
  return fmax(m->scale, m->scale_before);
}

/* Forgets the reference of the balance: the next energy is one. */
static void reset_reference(thrum_state *state) {
  thrum_stability_monitor *m = &state->monitor;
  m->work = m->moved = m->recent = 0.0;
  m->balance_sum = m->reference = m->modified_reference = 0.0;
  m->scale = m->scale_before = 0.0;
  m->drift_sum = m->block_sum = m->block_square = 0.0;
  m->corrected = m->energy_error = 0.0;
  m->drifting = 0;
  m->samples = m->switch_deadline = 0;
  m->windows = -1;
  m->window_end = state->report.steps + WINDOW_STEPS;
}

void thrum_stability_reset(thrum_state *state) {
  reset_reference(state);
  state->monitor.before_step = -1;
  state->monitor.motion = state->monitor.motion_before = 0.0;
  state->monitor.quiet_peak = 0.0;
  state->monitor.quiet_end = state->report.steps + THRUM_QUIET_STEPS;
  state->monitor.sample_step = -1;
  state->monitor.number_rate = 1.0;
  state->report.balance_last = 0.0;
  thrum_energy_correction_close(state);
}

/* Energy of q and the synchronised p [J]. */
static double energy_at(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                        const double *q, const double *p) {
  double sum = thrum_strain_energy_by(view->kernel, model, q, view->work);
  for (int32_t i = 0; i < state->rank; i++)
    sum += 0.5 * (p[i] * p[i]);
  return sum;
}

/* The size of an energy at q, with what it exchanges. */
static double size_at(const thrum_model *model, const thrum_state_view *view, const double *q,
                      double energy) {
  return fabs(energy) + thrum_exchanged_energy_by(view->kernel, model, q);
}

/* --- before a step ---------------------------------------------------------------------------- */

/* After a switch: back to imexv once the energy has fallen. */
static thrum_status look_for_return(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view) {
  if (state->report.steps < state->monitor.quiet_end)
    return THRUM_OK;
  state->monitor.quiet_end = state->report.steps + SWITCHED_STEPS;
  const double energy =
      size_at(model, view, view->q, energy_at(model, state, view, view->q, view->p));
  if (!(energy < FALLEN * state->monitor.switched_energy || energy < ENERGY_LEAST))
    return THRUM_OK;

  // the other scheme begins as if the state were new
  state->report.scheme_switches++;
  thrum_stability_reset(state);
  return thrum_scheme_change(model, state, view, thrum_solving_scheme(state),
                             thrum_mode_split(model, state));
}

/* Corrects slow drift through the momentum, where there is enough of it. */
static thrum_status correct_drift(const thrum_model *model, thrum_state *state,
                                  thrum_state_view *view) {
  thrum_stability_monitor *m = &state->monitor;
  const double energy_error = m->energy_error, least = CORRECTION_KINETIC * scale_now(m);
  THRUM_TRY(thrum_energy_correction_apply(model, state, view, least, &m->energy_error));
  if (m->energy_error == 0.0) {
    state->report.corrections++;
    state->report.corrected += energy_error;
  }
  return THRUM_OK;
}

/* Stability number beyond which it is near its limit: more than the explicit modes have at rest,
 * where they are not near it already. */
static double near_number(const thrum_model *model, const thrum_state *state) {
  const double rest2 = state->split > 0 ? model->omega2[state->split - 1] : 0.0;
  const double rest = fmin(state->def.dt * sqrt(rest2), 1.0);
  return fmax(NUMBER_NEAR, NUMBER_MOVED * rest);
}

/* Steps between two samples of the stability number: fewer where it is near its limit, and more
 * where it hardly moves. */
static int32_t sample_steps(const thrum_model *model, const thrum_state *state) {
  const double number = state->report.stability_number_last;
  // after a load jump the number passes its limit within a few steps; the balance shows it
  if (fabs(state->report.balance_last) > ERROR_FAST)
    return 1;
  if (!(number < near_number(model, state)))
    return number < NUMBER_CLOSE    ? THRUM_SAMPLE_STEPS / 4
           : number < NUMBER_CLOSER ? THRUM_SAMPLE_STEPS / 8
                                    : 1;

  // far from it, the rate at which it moves says how long it stays there
  const bool slow = THRUM_SAMPLE_STEPS_MOST * state->monitor.number_rate <= NUMBER_DRIFT;
  return slow ? THRUM_SAMPLE_STEPS_MOST : THRUM_SAMPLE_STEPS;
}

thrum_status thrum_stability_before(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, bool *samples) {
  *samples = false;
  if (!thrum_is_monitored_imexv(state))
    return THRUM_OK;
  if (state->scheme == THRUM_SCHEME_ENERGY)
    return look_for_return(model, state, view);

  // a correction that found too little kinetic energy is tried again every few steps
  const thrum_stability_monitor *m = &state->monitor;
  if (m->energy_error != 0.0 && (m->window_end - state->report.steps) % 4 == 0)
    THRUM_TRY(correct_drift(model, state, view));

  *samples = state->report.steps % sample_steps(model, state) == 0;
  if (*samples)
    thrum_stability_direct(state, view);
  return THRUM_OK;
}

/* --- energy ----------------------------------------------------------------------------------- */

void thrum_stability_energy(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, double potential, thrum_solve_report *report) {
  if (!thrum_is_monitored_imexv(state))
    return;
  const double h = state->def.dt;
  const int32_t n = thrum_staggered_modes(state);
  const bool tangent = thrum_tangent_damped(state);
  double sum = potential, modified = 0.0, modified_to_come = 0.0;

  // staggered modes: p at the time of q, and the modified Hamiltonian with both loads; that of the
  // quadratic split is smaller and not known
  for (int32_t i = 0; i < n; i++) {
    const double force = view->force[i] - view->load_before[i];
    const double force_to_come = view->force[i] - view->load[i];
    if (!tangent)
      view->p_before_next[i] =
          (view->p[i] - 0.5 * h * force) / (1.0 + 0.5 * h * thrum_rest_damping(model, state, i));
    sum += 0.5 * (view->p_before_next[i] * view->p_before_next[i]);
    if (state->scheme == THRUM_SCHEME_THESIS) {
      modified += 0.125 * h * h * (force * force);
      modified_to_come += 0.125 * h * h * (force_to_come * force_to_come);
    }
  }

  // the others have theirs already
  for (int32_t i = n; i < state->rank; i++) {
    sum += 0.5 * (view->p[i] * view->p[i]);
    view->p_before_next[i] = view->p[i];
  }
  report->energy = sum;
  report->energy_scale = size_at(model, view, view->q, sum);
  report->modified_energy = modified;
  report->modified_energy_change = modified_to_come - modified;
  report->energy_known = true;
}

/* The changes that a step makes to the balance [J]. */
typedef struct step_account {
  double work;       /* of the load */
  double dissipated; /* by damping */
  double load_jump;  /* work of the change of the load */
  double motion;     /* of its increment: the kinetic energy and that of the stiffness at rest */
} step_account;

static step_account account_of(const thrum_model *model, const thrum_state *state,
                               const thrum_state_view *view, const thrum_solve_report *report) {
  const double rate = 1.0 / (state->def.dt * state->def.dt);
  step_account step = {0.0, 0.0, 0.0, 0.0};
  for (int32_t i = 0; i < state->rank; i++) {
    const double d = view->q_next[i] - view->q[i];
    step.work += view->load[i] * d;
    step.load_jump += (view->load[i] - view->load_before[i]) * d;
    step.motion += (rate + 0.25 * model->omega2[i]) * (d * d);
  }
  step.motion *= 0.5;
  step.dissipated =
      report->dissipation_known ? report->dissipation : thrum_step_dissipation(model, state, view);
  return step;
}

/* Whether a step may have spoilt the energy: it is one of the first, it moves more than those
 * lately, or the balance is bad already. */
static bool is_restless(const thrum_state *state, const step_account *step) {
  const thrum_stability_monitor *m = &state->monitor;
  return (m->windows <= 0 && m->samples < FIRST_STEPS) || m->switch_deadline > 0 ||
         !(fabs(state->report.balance_last) <= 0.5 * ERROR_FAST) ||
         !(step->motion <= MOTION_KNOWN * fmax(m->motion, m->motion_before));
}

/* One explicit step may carry the body anywhere: compares the energy at its end, with the load that
 * will then be the one before, with the work of the load, as the next step would. */
static void examine_end(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                        const step_account *step, thrum_solve_report *report) {
  thrum_state_view there = *view;
  thrum_solve_report found = {0};
  double potential;
  there.q = view->q_next;
  there.p = view->p_next;
  there.load_before = view->load;
  there.force = view->force_2;
  there.p_before_next = view->trial;
  if (thrum_tangent_damped(state)) {
    // the momentum takes a solve, whose matrix must not replace the Jacobian of the step
    there.p_next = view->trial;
    there.jacobian_next = view->tangent_2;
    report->spoilt = thrum_staggered_synchronise(model, state, &there, &potential) < 0;
  } else {
    potential = thrum_staggered_force(model, state, &there, there.q);
  }
  thrum_stability_energy(model, state, &there, potential, &found);

  // not <=, so that an energy that is no number counts as a jump
  const double expected = report->energy + step->work - step->dissipated;
  const double scale =
      size_at(model, view, view->q_next, fmax(fabs(report->energy), fabs(expected)));
  const double error = found.energy - expected;
  const double modified =
      error - found.modified_energy + report->modified_energy + report->modified_energy_change;
  const double allowed = DAMPING_ERROR * (state->monitor.recent + fabs(step->dissipated));
  const bool kept = scale < ENERGY_LEAST || (fabs(error) <= 4.0 * ERROR_URGENT * scale + allowed &&
                                             fabs(modified) <= ERROR_URGENT * scale + allowed);
  report->spoilt = report->spoilt || !kept;
  report->switch_energy = scale;
}

/* The first energy since the reference was reset is the reference. */
static void open_reference(thrum_stability_monitor *m, double balance, double modified_energy) {
  if (!(fabs(balance) + fabs(modified_energy) < THRUM_MONITOR_MOST))
    return;
  m->windows = 0;
  m->modified_reference = balance - modified_energy;
  m->reference = balance;
}

/* Energy at q and p [J], which are the start (side = -1) or the end (1) of a step in the position
 * form with R(q-bar) in view->force; *modified gets h^2/8 p_E T_EE p_E, from the change of R_E over
 * half a drift: Stoermer-Verlet in its position form conserves the energy less that. Overwrites
 * force_2. */
static double position_energy(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, double side, const double *q, const double *p,
                              double *modified) {
  double sum =
      thrum_internal_force_part(view->kernel, model, state->split, q, view->force_2, view->work);
  double along = 0.0;
  for (int32_t i = 0; i < state->split; i++)
    along += p[i] * (view->force_2[i] - view->force[i]);
  for (int32_t i = 0; i < state->rank; i++)
    sum += 0.5 * (p[i] * p[i]);
  *modified = 0.25 * side * state->def.dt * along;
  return sum;
}

/* Estimate of the energy in the middle of a step in the position form [J], for a linear mode its
 * modified Hamiltonian: from V(q-bar), which the kick has evaluated. */
static double middle_energy(const thrum_model *model, const thrum_state *state,
                            const thrum_state_view *view, double potential) {
  double sum = potential;
  for (int32_t i = 0; i < state->split; i++)
    sum += 0.5 * (view->p[i] * view->p_next[i]);
  for (int32_t i = state->split; i < state->rank; i++) {
    const double d = view->q_next[i] - view->q[i], p = view->p[i], p_next = view->p_next[i];
    sum += 0.25 * (p * p + p_next * p_next) + 0.125 * model->omega2[i] * (d * d);
  }
  return sum;
}

/* Position form: evaluates the energy at the end of the step every few steps, and where the balance
 * in the middle of the step has moved. */
static void look_at_position(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                             const step_account *step, thrum_solve_report *report) {
  const double work = step->work - step->dissipated;
  thrum_stability_monitor *m = &state->monitor;
  const int32_t quiet = m->windows > 0 ? ENERGY_STEPS : ENERGY_STEPS_FIRST;
  const int32_t apart = sample_steps(model, state) > 1 ? quiet : 1;
  const double middle = middle_energy(model, state, view, report->potential) - m->work - 0.5 * work;
  const bool moved = !(fabs(middle - m->middle_balance) <= ERROR_FAST * scale_now(m));
  if (m->windows >= 0 && state->report.steps % apart != 0 && !moved && !is_restless(state, step))
    return;

  // the reference is the energy before the step, which the step may have spoilt
  double modified;
  if (m->windows < 0) {
    const double energy = position_energy(model, state, view, -1.0, view->q, view->p, &modified);
    open_reference(m, energy - m->work, modified);
  }
  report->energy =
      position_energy(model, state, view, 1.0, view->q_next, view->p_next, &modified) - work;
  report->energy_scale =
      size_at(model, view, view->q_next, fmax(fabs(report->energy), fabs(report->energy + work)));
  report->modified_energy = modified;
  report->energy_known = report->energy_ahead = true;
  report->switch_energy = m->work + m->reference;
  m->middle_balance = fabs(middle) < THRUM_MONITOR_MOST ? middle : 0.0;
}

void thrum_stability_look_ahead(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  if (!thrum_is_monitored_imexv(state) || state->scheme == THRUM_SCHEME_ENERGY)
    return;
  const step_account step = account_of(model, state, view, report);
  if (state->scheme == THRUM_SCHEME_POSITION && state->split > 0) {
    look_at_position(model, state, view, &step, report);
    return;
  }

  // with staggered modes the kick has evaluated the energy before the step
  if (thrum_staggered_modes(state) > 0) {
    const double forces = report->modified_energy + report->modified_energy_change;
    if (report->energy_known && (report->newton || !(forces <= LOAD_JUMP * report->energy_scale) ||
                                 is_restless(state, &step)))
      examine_end(model, state, view, &step, report);
    return;
  }

  // without them the energy comes from the end of the step
  thrum_stability_monitor *m = &state->monitor;
  if (m->windows < 0)
    open_reference(m, energy_at(model, state, view, view->q, view->p) - m->work, 0.0);
  memcpy(view->p_before_next, view->p, (size_t)state->rank * sizeof *view->p_before_next);
  report->energy =
      energy_at(model, state, view, view->q_next, view->p_next) - step.work + step.dissipated;
  report->energy_scale = size_at(model, view, view->q_next, report->energy);
  report->energy_known = report->energy_ahead = true;
  report->switch_energy = m->work + m->modified_reference;
}

/* --- decision --------------------------------------------------------------------------------- */

typedef enum urgency { QUIET, FAST, URGENT } urgency;

/* Enters the energy of this step; says whether the balance is beyond what its own errors
 * explain. */
static urgency enter_energy(thrum_state *state, const thrum_solve_report *report) {
  thrum_stability_monitor *m = &state->monitor;
  const double energy = report->energy;
  const double balance = energy - m->work, modified = balance - report->modified_energy;
  if (m->windows < 0)
    open_reference(m, balance, report->modified_energy);

  // the error, and what damping may have contributed to it
  m->scale = fmax(m->scale, report->energy_scale);
  const double scale = scale_now(m);
  const double error = modified - m->modified_reference;
  const double allowed = DAMPING_ERROR * m->recent;
  state->report.balance_last =
      scale > 0.0 ? fmax(-THRUM_MONITOR_MOST, fmin(error / scale, THRUM_MONITOR_MOST)) : 0.0;
  if (scale > 0.0)
    state->report.balance_peak =
        fmax(state->report.balance_peak, fmin((fabs(error) - allowed) / scale, THRUM_MONITOR_MOST));
  m->balance_sum += state->scheme == THRUM_SCHEME_POSITION ? modified : balance;
  m->samples++;

  // under damping the reference follows: its own error is no growth; the position form enters an
  // energy every few steps
  const double steps = state->scheme == THRUM_SCHEME_POSITION
                           ? fmin((double)(state->report.steps - m->energy_step), MEMORY)
                           : 1.0;
  m->energy_step = state->report.steps;
  if (allowed > FOLLOW * scale) {
    m->modified_reference += error * (steps / MEMORY);
    m->reference += (balance - m->reference) * (steps / MEMORY);
  }
  m->recent -= m->recent * (steps / MEMORY);

  // a load that changes shifts the modified Hamiltonian by a known step
  m->modified_reference -= report->modified_energy_change;
  if (scale < ENERGY_LEAST)
    return QUIET;

  // E itself may ripple by the whole difference to the modified Hamiltonian
  if (!(fabs(error) <= ERROR_URGENT * scale + allowed &&
        fabs(balance - m->reference) <= 4.0 * ERROR_URGENT * scale + allowed))
    return URGENT;
  return fabs(error) <= ERROR_FAST * scale + allowed ? QUIET : FAST;
}

/* Position form: the mean of the first windows is the reference of the modified balance. It has no
 * drift that could be corrected: only a switch ends its growth. */
static void center_reference(thrum_stability_monitor *m, double mean) {
  if (m->windows >= REFERENCE_WINDOWS)
    return;
  m->drift_sum += mean;
  if (++m->windows == REFERENCE_WINDOWS) {
    m->modified_reference = m->drift_sum / (double)REFERENCE_WINDOWS;
    m->drift_sum = 0.0;
  }
}

/* Whether the means of the windows drift. Energy that modes exchange makes them scatter, and comes
 * back: the mean over many windows then stays at the reference, to a fraction of their scatter.
 * `drift` is that of a window, a share of the energy. */
static bool is_drifting(thrum_stability_monitor *m, double drift) {
  const double share = fmax(-1.0, fmin(drift, 1.0));
  m->block_sum += share;
  m->block_square += share * share;
  if (++m->windows < REFERENCE_WINDOWS + BLOCK_WINDOWS)
    return false;

  // the next block begins
  const double mean = m->block_sum / (double)BLOCK_WINDOWS;
  const double scatter = sqrt(fmax(m->block_square / (double)BLOCK_WINDOWS - mean * mean, 0.0));
  m->windows = REFERENCE_WINDOWS;
  m->block_sum = m->block_square = 0.0;
  return fabs(mean) > fmin(fmax(scatter, DRIFT_WINDOW), BLOCK_DRIFT);
}

/* Enters the mean balance of a window: the first ones make the reference, later ones the
 * correction. True when that is too much. */
static bool enter_mean(thrum_stability_monitor *m, double mean, double scale) {
  if (m->windows < REFERENCE_WINDOWS) {
    // until then the first energy is the reference
    m->drift_sum += mean;
    if (++m->windows == REFERENCE_WINDOWS) {
      m->reference = m->drift_sum / (double)REFERENCE_WINDOWS;
      m->drift_sum = 0.0;
    }
    return false;
  }
  if (scale < ENERGY_LEAST)
    return false;

  // a run without drift is left alone; one that has drifted is corrected from then on
  const double drift = mean - m->reference;
  m->drifting = m->drifting || is_drifting(m, drift / scale);
  if (!m->drifting)
    return false;
  m->drift_sum += drift - DRIFT_FORGET * m->drift_sum;
  if (fabs(drift) <= DRIFT_WINDOW * scale && fabs(m->drift_sum) <= DRIFT_SUM * scale)
    return false;

  // proportional and integral correction
  m->energy_error = -(drift + INTEGRAL_GAIN * m->drift_sum);
  m->corrected += m->energy_error;
  return !(fabs(m->energy_error) <= CORRECTION_MOST * scale &&
           fabs(m->corrected) <= CORRECTION_MOST * scale);
}

/* Ends a window when it is time; true when the energy integrator is to take over. */
static bool end_window(thrum_state *state) {
  thrum_stability_monitor *m = &state->monitor;
  if (state->report.steps < m->window_end || m->samples == 0)
    return false;
  const double mean = m->balance_sum / (double)m->samples;
  const double scale = scale_now(m);
  bool large = false;
  m->energy_error = 0.0;

  // where much was moved B is known to its own error only, which is not to be corrected
  if (m->moved > DRIVEN * scale) {
    m->drift_sum = m->block_sum = m->block_square = m->corrected = m->moved = 0.0;
    m->windows = -1;
  } else if (state->scheme == THRUM_SCHEME_POSITION) {
    center_reference(m, mean);
  } else {
    large = enter_mean(m, mean, scale);
  }

  // the work is counted from here, so that its sum never outgrows the energy by far
  m->reference += m->work;
  m->modified_reference += m->work;
  if (m->windows > 0 && m->windows < REFERENCE_WINDOWS)
    m->drift_sum += (double)m->windows * m->work;
  m->work = 0.0;

  // the next window
  m->scale_before = m->scale;
  m->motion_before = m->motion;
  m->scale = m->balance_sum = m->motion = 0.0;
  m->samples = 0;
  m->window_end = state->report.steps + WINDOW_STEPS;
  return large;
}

/* True when a switch that is not urgent is to be made now: E is near its mean, so that there is
 * less error to correct, or it has waited long enough. */
static bool is_moment(const thrum_state *state, double energy) {
  const thrum_stability_monitor *m = &state->monitor;
  return state->report.steps >= m->switch_deadline ||
         fabs(energy - m->work - m->reference) <= SWITCH_NEAR * scale_now(m);
}

thrum_stability_decision thrum_stability_decide(thrum_state *state,
                                                const thrum_solve_report *report) {
  thrum_stability_monitor *m = &state->monitor;
  if (!report->energy_known ||
      !(fabs(report->energy) + fabs(m->work) + report->modified_energy < THRUM_MONITOR_MOST))
    return THRUM_DECISION_CONTINUE;
  const urgency found = enter_energy(state, report);
  const bool slow = end_window(state);

  // the energy before a step shows an error of the step before it, which is to be repeated
  if (found == URGENT)
    return report->energy_ahead ? THRUM_DECISION_SWITCH : THRUM_DECISION_REPEAT;
  if (report->spoilt)
    return THRUM_DECISION_SWITCH;

  // others wait for a convenient step
  if ((found == FAST || slow) && m->switch_deadline == 0)
    m->switch_deadline = state->report.steps + (slow ? WINDOW_STEPS : WINDOW_STEPS / 2);
  return m->switch_deadline > 0 && is_moment(state, report->energy) ? THRUM_DECISION_SWITCH
                                                                    : THRUM_DECISION_CONTINUE;
}

/* --- switch ----------------------------------------------------------------------------------- */

/* One step of the energy integrator from the state before the last step, which its kick left
 * synchronised in q_before and p_before. The view then has the present q and p from it. */
static thrum_status repeat_step(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report) {
  thrum_state_view before = *view;
  before.q = view->q_before;
  before.p = view->p_before;
  before.load = view->load_before;
  if (thrum_step_energy(model, state, &before, report) < 0 ||
      !thrum_all_finite(view->q_next, state->rank) || !thrum_all_finite(view->p_next, state->rank))
    return THRUM_NOT_CONVERGED;

  // the step to come starts there
  memcpy(view->q_start, view->q_next, (size_t)state->rank * sizeof *view->q_start);
  memcpy(view->p_start, view->p_next, (size_t)state->rank * sizeof *view->p_start);
  view->q = view->q_start;
  view->p = view->p_start;
  return THRUM_OK;
}

/* True where the energy before a step of all modes shows that the step before went wrong. */
static bool was_spoilt_before(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, const thrum_solve_report *report) {
  return report->energy_ahead &&
         !(fabs(energy_at(model, state, view, view->q, view->p) - report->switch_energy) <=
           ERROR_URGENT * size_at(model, view, view->q, report->switch_energy));
}

thrum_status thrum_stability_switch_to_energy(const thrum_model *model, thrum_state *state,
                                              thrum_state_view *view,
                                              thrum_stability_decision decision,
                                              thrum_solve_report *report) {
  thrum_stability_monitor *m = &state->monitor;
  if (was_spoilt_before(model, state, view, report))
    decision = THRUM_DECISION_REPEAT;

  // a step that was examined beforehand has another energy than the one to compare with later
  const bool examined = report->energy_ahead || report->spoilt;
  m->switched_energy =
      size_at(model, view, view->q, examined ? report->switch_energy : report->energy);
  memset(report, 0, sizeof *report);

  // each switch makes the next return later
  thrum_scheme_count_switch(state);
  const int64_t changes = state->report.scheme_switches < 10 ? state->report.scheme_switches : 10;
  m->quiet_end = state->report.steps + ((int64_t)SWITCHED_STEPS << changes);

  // the target energy is what reference and work demand, where they are exact
  if (m->windows >= 0 && DAMPING_ERROR * m->recent <= FOLLOW * scale_now(m))
    thrum_energy_correction_open(state, m->reference + m->work);

  // the step before again, by the energy integrator
  if (decision == THRUM_DECISION_REPEAT && m->before_step == state->report.steps - 1) {
    thrum_state energy_state = *state;
    energy_state.scheme = THRUM_SCHEME_ENERGY;
    energy_state.split = 0;
    energy_state.jacobian_kept = 0;
    energy_state.potential_step = -1;
    energy_state.past_count = 0;
    energy_state.def.dt = m->before_dt;
    const thrum_status status = repeat_step(model, &energy_state, view, report);
    memset(report, 0, sizeof *report);
    if (status >= 0) {
      energy_state.def.dt = state->def.dt;
      *state = energy_state;
      m->switched_energy =
          size_at(model, view, view->q, energy_at(model, state, view, view->q, view->p));
      return THRUM_OK;
    }
  }
  return thrum_scheme_change(model, state, view, THRUM_SCHEME_ENERGY, 0);
}

/* --- after a step ----------------------------------------------------------------------------- */

void thrum_stability_after(const thrum_model *model, thrum_state *state,
                           const thrum_state_view *view, const thrum_solve_report *report) {
  if (!thrum_is_monitored_imexv(state) || state->scheme == THRUM_SCHEME_ENERGY)
    return;
  thrum_stability_monitor *m = &state->monitor;
  const step_account step = account_of(model, state, view, report);

  // a constant load is one more potential, and so no reason for the balance to move
  m->work += step.work - step.dissipated;
  m->moved += fabs(step.dissipated) + (step.load_jump != 0.0 ? fabs(step.work) : 0.0);
  m->recent += fabs(step.dissipated);
  m->motion = fmax(m->motion, step.motion);

  // an impulsive load injects energy with an error of order 1: the reference is reset
  if (step.load_jump != 0.0 && fabs(step.work) > LOAD_JUMP * scale_now(m))
    reset_reference(state);
  if (!(fabs(m->work) + m->moved < THRUM_MONITOR_MOST))
    thrum_stability_reset(state);
}
