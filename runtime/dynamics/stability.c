/* What imexv watches while it runs, and what it does about it (design 4).
 *
 * The angle h sqrt(rho), rho the spectral radius of what is treated explicitly: T_EE(q) in the
 * component split, T(q) - diag_I(omega^2) in the quadratic one; stable below 2. It comes from power
 * iterations, one each few steps and one a step near the bound, warm-started. Above a limit the
 * highest explicit modes become implicit (the quadratic split becomes the component split), and
 * return after a long calm, which doubles with each change.
 *
 * The balance B = E - work + dissipation with the synchronised energy E, which stage 1 has for
 * nothing. Fast: B beside its first value. Stoermer-Verlet's own energy lies h^2/8 |R_E - f_E|^2
 * below E; without that part a linear mode shows no ripple, but a mode beyond the bound no growth
 * either, so E itself is looked at too. Beyond the limits the step of design 7 takes over, unless
 * it is urgent at a step where E is near its reference, until the energy has clearly fallen. Slow:
 * the mean of B over a window beside that of the first ones; what it is off by goes back through
 * the momentum (energy correction.c), and only when that becomes much does design 7 take over.
 * Where changing loads or damping move much energy all is compared anew: there the error of B is
 * theirs.
 *
 * Each change synchronises, changes, un-synchronises. What is decided here goes into a copy of the
 * header and into scratch, so that a step that fails leaves no trace.
 * Cost: |E| operations a step, a product T v each SAMPLE steps, two forces a correction.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>
#include <string.h>

#include "runtime/dynamics/state_private.h"
#include "runtime/polynomial/polynomial_private.h"

#define SAMPLE 16          /* steps between two power iterations; fewer when something is near */
#define WINDOW 128         /* steps of a mean of the balance */
#define FIRST 16           /* windows whose mean is the reference */
#define QUIET_STEPS 4096   /* of a calm */
#define SWITCHED_STEPS 512 /* between two looks at a return from design 7 */
#define ANGLE_HIGH 1.6     /* beyond it modes leave E, */
#define ANGLE_GOOD 1.4     /* until this holds */
#define STABILITY_NUMBER_QUIET 1.1 /* all modes return after a calm below it */
#define FAST_SHARE 0.03            /* of the energy: B beside its reference */
#define URGENT_SHARE 0.08          /* the same, without waiting; also for E itself */
#define DRIFT 1e-4                 /* of the energy: mean of B over a window beside the reference */
#define DRIFT_ALL 1.6e-3           /* the same, summed over all windows, */
#define FORGET 0.015625            /* of which a share is forgotten in each */
#define BY_LAST 1.0                /* of what the last mean was off by goes back, */
#define BY_ALL 0.25                /* and of what all of them were, summed */
#define LARGE 0.04     /* of the energy: the same, too much to correct; or all corrections */
#define PAY_LEAST 0.25 /* of the energy: kinetic energy at a correction */
#define NEAR 1e-3      /* of the energy: E beside its reference at a hand-over */
#define DRIVEN 1e-3    /* of the energy: moved by changes of load and damping */
#define BLOW 0.1       /* of the energy: work of a new load in one step, B is compared anew */
#define FOLLOW 2e-5    /* of the energy: error of B by damping that counts */
#define MOVED 0.05     /* share of what damping moved that B may err by */
#define MOVED_MOST 0.2 /* of the energy: the most of that, for what moves to and fro adds up */
#define SUDDEN 0.1     /* of the energy: the shadow to come, beyond it a step is looked at first */
#define MEMORY 256.0   /* steps that what was moved is remembered for */
#define FALLEN 0.25    /* of the energy at the hand-over: imexv returns */
#define RANGE 1e300    /* [J], larger energies are not followed, */
#define LEAST 1e-300   /* nor smaller ones: at that end rounding is all there is */
#define LOST 1e100     /* in place of ratios that are larger or no number */

/* Largest energy lately. */
static double scale_now(const thrum_state *state) {
  return fmax(state->stability_scale, state->stability_scale_before);
}

/* Nothing to compare the balance with: the next energy is. */
static void compare_anew(thrum_state *state) {
  state->stability_work = state->stability_moved = state->stability_recent = 0.0;
  state->stability_sum = state->stability_reference = state->stability_steady = 0.0;
  state->stability_scale = state->stability_scale_before = 0.0;
  state->stability_off = state->stability_spent = state->stability_energy_error = 0.0;
  state->stability_samples = state->watch_deadline = 0;
  state->stability_windows = -1;
  state->stability_window_end = state->steps + WINDOW;
}

void thrum_stability_reset(thrum_state *state) {
  compare_anew(state);
  state->kept_step = -1;
  state->quiet_peak = 0.0;
  state->quiet_end = state->steps + QUIET_STEPS;
  state->balance_last = 0.0;
  thrum_energy_correction_close(state);
}

/* view->direction = v/|v|. v all zero: starts anew. */
static void direct(const thrum_state *state, thrum_state_view *view, int32_t n, double *v) {
  double norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += v[i] * v[i];
  if (!(norm > 0.0))
    for (int32_t i = 0; i < n; i++)
      v[i] = 1.0 / (double)(n - i);
  norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += v[i] * v[i];
  for (int32_t i = 0; i < state->rank; i++)
    view->direction[i] = i < n ? v[i] / sqrt(norm) : 0.0;
}

/* The rest of a power iteration on the first n coordinates, from T times the direction; returns
 * |A v| for |v| = 1, a lower bound of the spectral radius. */
static double iterate_from(const thrum_model *model, const thrum_state *state,
                           thrum_state_view *view, int32_t n, double *v) {
  if (state->scheme == THRUM_SCHEME_QUADRATIC)
    for (int32_t i = state->split; i < n; i++)
      view->product[i] -= model->omega2[i] * view->direction[i];
  double norm = 0.0;
  for (int32_t i = 0; i < n; i++)
    norm += view->product[i] * view->product[i];
  norm = sqrt(norm);
  for (int32_t i = 0; i < n; i++)
    v[i] = norm > 0.0 && isfinite(norm) ? view->product[i] / norm : 0.0;
  return norm;
}

static void multiply(const thrum_model *model, thrum_state_view *view, int32_t n) {
  thrum_tangent_product_part(view->kernel, model, n, view->q, view->direction, view->product,
                             view->work);
}

static double iterate(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                      int32_t n, double *v) {
  direct(state, view, n, v);
  multiply(model, view, n);
  return iterate_from(model, state, view, n, v);
}

static double angle_of(const thrum_state *state, double radius) {
  // far beyond any bound, and what is not a number, is one finite size
  return fmin(state->dt * sqrt(radius), LOST);
}

/* Runs the step from view->p_start from now on: p at the present time, seen by another scheme. */
static thrum_status change(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                           int32_t scheme, int32_t split) {
  const thrum_status status = thrum_stagger_synchronise(model, state, view, NULL);
  if (status != THRUM_OK)
    return status;
  state->scheme = scheme;
  state->split = split;
  state->jacobian_kept = 0;
  state->past_count = 0;
  memcpy(view->p_start, view->p_next, (size_t)state->rank * sizeof *view->p_start);
  thrum_stagger_delay(model, state, view, view->q, view->load_before, view->p_start);
  view->p = view->p_start;
  return thrum_all_finite(view->p, state->rank) ? THRUM_OK : THRUM_NOT_FINITE;
}

/* The highest explicit modes become implicit until the rest is stable with a margin. */
static thrum_status shrink(const thrum_model *model, thrum_state *state, thrum_state_view *view) {
  int32_t split = state->split;
  thrum_state lower = *state;
  lower.scheme = THRUM_SCHEME_COMPONENT;
  // the quadratic split first gives way to the component split of the same modes
  bool fewer = state->scheme == THRUM_SCHEME_COMPONENT;
  for (double angle = ANGLE_HIGH; angle >= ANGLE_GOOD && split > 0; fewer = true) {
    split -= fewer ? 1 : 0;
    memset(view->guide_next, 0, (size_t)state->rank * sizeof *view->guide_next);
    angle = 0.0;
    for (int k = 0; k < 8 && split > 0; k++)
      angle = angle_of(state, iterate(model, &lower, view, split, view->guide_next));
  }
  if (state->scheme == THRUM_SCHEME_QUADRATIC)
    state->scheme_switches++;
  else
    state->split_changes++;
  state->quiet_peak = 0.0;
  const int64_t changes = state->split_changes < 10 ? state->split_changes : 10;
  state->quiet_end = state->steps + ((int64_t)QUIET_STEPS << changes);
  return change(model, state, view, THRUM_SCHEME_COMPONENT, split);
}

/* Begins a sample of the angle. */
static void stability_number(const thrum_state *state, thrum_state_view *view) {
  const size_t vector = (size_t)state->rank * sizeof(double);
  memcpy(view->guide_next, view->guide, vector);
  memcpy(view->guide_whole_next, view->guide_whole, vector);
  view->guided = true;
  direct(state, view, thrum_staggered(state), view->guide_next);
}

void thrum_stability_multiply(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view) {
  const int32_t n = thrum_staggered(state);
  if (n > 0)
    multiply(model, view, n);
}

thrum_status thrum_stability_sample(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view) {
  const int32_t whole = thrum_split_of(model, state), n = thrum_staggered(state);
  const bool quadratic = state->scheme == THRUM_SCHEME_QUADRATIC;
  const size_t vector = (size_t)state->rank * sizeof(double);
  if (n > 0) {
    state->stability_number_last =
        angle_of(state, iterate_from(model, state, view, n, view->guide_next));
    state->stability_number_peak = fmax(state->stability_number_peak, state->stability_number_last);
    if (!(state->stability_number_last <= ANGLE_HIGH))
      return shrink(model, state, view);
  }
  // a calm is seen by fewer samples
  if (quadratic || state->split == whole || state->steps % SAMPLE != 0)
    return THRUM_OK;
  const double angle = angle_of(state, iterate(model, state, view, whole, view->guide_whole_next));
  state->quiet_peak = fmax(state->quiet_peak, angle);
  if (state->steps < state->quiet_end)
    return THRUM_OK;
  const bool calm = state->quiet_peak < STABILITY_NUMBER_QUIET;
  state->quiet_peak = 0.0;
  state->quiet_end = state->steps + QUIET_STEPS;
  if (!calm)
    return THRUM_OK;
  state->split_changes++;
  memset(view->guide_next, 0, vector);
  return change(model, state, view, THRUM_SCHEME_COMPONENT, whole);
}

/* The synchronised energy of all modes. */
static double energy_at(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                        const double *q, const double *p) {
  double sum = thrum_strain_energy_by(view->kernel, model, q, view->work);
  for (int32_t i = 0; i < state->rank; i++)
    sum += 0.5 * (p[i] * p[i]);
  return sum;
}

/* After a hand-over: back to imexv once the energy has fallen. */
static thrum_status stability_switched(const thrum_model *model, thrum_state *state,
                                       thrum_state_view *view) {
  if (state->steps < state->quiet_end)
    return THRUM_OK;
  state->quiet_end = state->steps + SWITCHED_STEPS;
  const double energy = energy_at(model, state, view, view->q, view->p);
  if (!(energy < FALLEN * state->switched_energy || energy < LEAST))
    return THRUM_OK;
  state->scheme_switches++;
  thrum_stability_reset(state);
  return change(model, state, view, THRUM_SCHEME_COMPONENT, thrum_split_of(model, state));
}

/* Takes slow drift out through the momentum, where there is enough of it. */
static thrum_status pay(const thrum_model *model, thrum_state *state, thrum_state_view *view) {
  const double energy_error = state->stability_energy_error, least = PAY_LEAST * scale_now(state);
  const thrum_status status =
      thrum_energy_correction_apply(model, state, view, least, &state->stability_energy_error);
  if (status == THRUM_OK && state->stability_energy_error == 0.0) {
    state->corrections++;
    state->corrected += energy_error;
  }
  return status;
}

thrum_status thrum_stability_before(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, bool *samples) {
  *samples = false;
  if (!state->adaptive)
    return THRUM_OK;
  if (state->scheme == THRUM_SCHEME_ENERGY)
    return stability_switched(model, state, view);
  if (state->stability_energy_error != 0.0 &&
      (state->stability_window_end - state->steps) % 4 == 0) {
    const thrum_status status = pay(model, state, view);
    if (status != THRUM_OK)
      return status;
  }
  int32_t often = state->stability_number_last < 0.9    ? SAMPLE
                  : state->stability_number_last < 1.2  ? SAMPLE / 4
                  : state->stability_number_last < 1.45 ? SAMPLE / 8
                                                        : 1;
  // under a sudden load the angle passes the bound within a few steps; the balance shows it
  if (fabs(state->balance_last) > FAST_SHARE)
    often = 1;
  *samples = state->steps % often == 0;
  if (*samples)
    stability_number(state, view);
  return THRUM_OK;
}

void thrum_stability_energy(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, double potential, thrum_solve_report *report) {
  if (!state->adaptive || thrum_tangent_damped(state))
    return;
  const double h = state->dt;
  const int32_t n = thrum_staggered(state);
  double sum = potential, shadow = 0.0, modified_energy_to_come = 0.0;
  for (int32_t i = 0; i < n; i++) {
    const double force = view->force[i] - view->load_before[i];
    const double force_to_come = view->force[i] - view->load[i];
    const double p =
        (view->p[i] - 0.5 * h * force) / (1.0 + 0.5 * h * thrum_rest_damping(model, state, i));
    sum += 0.5 * (p * p);
    view->p_kept_next[i] = p;
    // the quadratic split has its own, which is smaller and not known
    if (state->scheme == THRUM_SCHEME_COMPONENT) {
      shadow += 0.125 * h * h * (force * force);
      modified_energy_to_come += 0.125 * h * h * (force_to_come * force_to_come);
    }
  }
  for (int32_t i = n; i < state->rank; i++) {
    sum += 0.5 * (view->p[i] * view->p[i]);
    view->p_kept_next[i] = view->p[i];
  }
  report->energy = sum;
  report->modified_energy = shadow;
  report->modified_energy_change = modified_energy_to_come - shadow;
  report->energy_known = true;
}

/* Work of the load of this step, what damping takes, and what the change of the load moves. */
static double work_of(const thrum_model *model, const thrum_state *state,
                      const thrum_state_view *view, double *dissipated, double *load_jump) {
  double work = 0.0, sum = 0.0;
  *load_jump = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const double d = view->q_next[i] - view->q[i];
    work += view->load[i] * d;
    sum += d * d * thrum_rest_damping(model, state, i);
    *load_jump += (view->load[i] - view->load_before[i]) * d;
  }
  *dissipated = sum / state->dt;
  return work;
}

/* A sudden load may take the explicit modes anywhere within one step: is the energy at its end,
 * with the load that will then be the one before, far from what the load has done? */
static void look_ahead(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       double work, thrum_solve_report *report) {
  thrum_state_view there = *view;
  thrum_solve_report found = {0};
  there.q = view->q_next;
  there.p = view->p_next;
  there.load_before = view->load;
  there.force = view->force_2;
  there.p_kept_next = view->trial;
  thrum_stability_energy(model, state, &there, thrum_stagger_force(model, state, &there, there.q),
                         &found);
  const double scale = fmax(fabs(report->energy), fabs(report->energy + work));
  report->load_jumped = !(fabs(found.energy - report->energy - work) <= 4.0 * URGENT_SHARE * scale);
  report->energy_scale = scale;
}

void thrum_stability_ahead(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                           thrum_solve_report *report) {
  if (!state->adaptive || thrum_tangent_damped(state) || state->scheme != THRUM_SCHEME_COMPONENT)
    return;
  double dissipated, load_jump;
  const double work = work_of(model, state, view, &dissipated, &load_jump) - dissipated;
  if (thrum_staggered(state) > 0) {
    const double shadow = report->modified_energy + report->modified_energy_change;
    if (report->energy_known && (report->newton || !(shadow <= SUDDEN * report->energy)))
      look_ahead(model, state, view, work, report);
    return;
  }
  if (state->stability_windows < 0) {
    state->stability_windows = 0;
    state->stability_steady = state->stability_reference =
        energy_at(model, state, view, view->q, view->p) - state->stability_work;
  }
  memcpy(view->p_kept_next, view->p, (size_t)state->rank * sizeof *view->p_kept_next);
  report->energy = energy_at(model, state, view, view->q_next, view->p_next) - work;
  report->energy_known = report->energy_ahead = true;
  report->energy_scale = state->stability_work + state->stability_steady;
}

typedef enum alarm { QUIET, FAST, URGENT } alarm;

/* Takes the energy of this step in; is the balance beyond what its own errors explain? */
static alarm take_in(thrum_state *state, const thrum_solve_report *report) {
  const double energy = report->energy, shadow = report->modified_energy;
  const double balance = energy - state->stability_work, steady = balance - shadow;
  if (state->stability_windows < 0) {
    state->stability_windows = 0;
    state->stability_steady = steady;
    state->stability_reference = balance;
  }
  state->stability_scale = fmax(state->stability_scale, fabs(energy));
  const double scale = scale_now(state);
  const double error = steady - state->stability_steady;
  const double allowed = fmin(MOVED * state->stability_recent, MOVED_MOST * scale);
  state->balance_last = scale > 0.0 ? fmax(-LOST, fmin(error / scale, LOST)) : 0.0;
  if (scale > 0.0)
    state->balance_peak = fmax(state->balance_peak, fmin((fabs(error) - allowed) / scale, LOST));
  state->stability_sum += balance;
  state->stability_samples++;
  // where damping acts the reference follows: its own error is no growth
  if (allowed > FOLLOW * scale) {
    state->stability_steady += error / MEMORY;
    state->stability_reference += (balance - state->stability_reference) / MEMORY;
  }
  state->stability_recent -= state->stability_recent / MEMORY;
  // a load that changes changes what Stoermer-Verlet keeps, by a known step
  state->stability_steady -= report->modified_energy_change;
  if (scale < LEAST)
    return QUIET;
  // E itself may ripple by the whole of its shadow
  if (!(fabs(error) <= URGENT_SHARE * scale + allowed &&
        fabs(balance - state->stability_reference) <= 4.0 * URGENT_SHARE * scale + allowed))
    return URGENT;
  return fabs(error) <= FAST_SHARE * scale + allowed ? QUIET : FAST;
}

/* What the mean of a window tells: the first ones make the reference, later ones what is to be
 * given back; true when that is too much. */
static bool compare(thrum_state *state, double mean, double scale) {
  if (state->stability_windows < FIRST) {
    // until then the first energy is the reference
    state->stability_off += mean;
    if (++state->stability_windows == FIRST) {
      state->stability_reference = state->stability_off / (double)FIRST;
      state->stability_off = 0.0;
    }
    return false;
  }
  if (scale < LEAST)
    return false;
  const double off = mean - state->stability_reference;
  state->stability_off += off - FORGET * state->stability_off;
  if (fabs(off) <= DRIFT * scale && fabs(state->stability_off) <= DRIFT_ALL * scale)
    return false;
  state->stability_energy_error = -(BY_LAST * off + BY_ALL * state->stability_off);
  state->stability_spent += state->stability_energy_error;
  return !(fabs(state->stability_energy_error) <= LARGE * scale &&
           fabs(state->stability_spent) <= LARGE * scale);
}

/* Ends a window; true when design 7 is to take over. */
static bool drifted(thrum_state *state) {
  if (state->steps < state->stability_window_end || state->stability_samples == 0)
    return false;
  const double mean = state->stability_sum / (double)state->stability_samples;
  const double scale = scale_now(state);
  bool large = false;
  state->stability_energy_error = 0.0;
  if (state->stability_moved > DRIVEN * scale) {
    // what moved much is known to its own error only: that is to be no growth in the end
    state->stability_off = state->stability_spent = state->stability_moved = 0.0;
    state->stability_windows = -1;
  } else {
    large = compare(state, mean, scale);
  }
  // counted from here, so that the sum of the work never outgrows the energy by far
  state->stability_reference += state->stability_work;
  state->stability_steady += state->stability_work;
  if (state->stability_windows > 0 && state->stability_windows < FIRST)
    state->stability_off += (double)state->stability_windows * state->stability_work;
  state->stability_work = 0.0;
  state->stability_scale_before = state->stability_scale;
  state->stability_scale = state->stability_sum = 0.0;
  state->stability_samples = 0;
  state->stability_window_end = state->steps + WINDOW;
  return large;
}

/* What is not urgent waits for a step at which E is near its mean: there is less to pay. */
static bool passes(const thrum_state *state, double energy) {
  return state->steps >= state->watch_deadline ||
         fabs(energy - state->stability_work - state->stability_reference) <=
             NEAR * scale_now(state);
}

thrum_stability_decision thrum_stability_judge(thrum_state *state,
                                               const thrum_solve_report *report) {
  // an energy near the end of the range of numbers, or beyond it, has no balance
  if (!report->energy_known ||
      !(fabs(report->energy) + fabs(state->stability_work) + report->modified_energy < RANGE))
    return THRUM_DECISION_CONTINUE;
  const alarm found = take_in(state, report);
  const bool slow = drifted(state);
  // what is seen before it is done needs no redoing
  if (found == URGENT)
    return report->energy_ahead ? THRUM_DECISION_SWITCH : THRUM_DECISION_REDO;
  if (report->load_jumped)
    return THRUM_DECISION_SWITCH;
  if ((found == FAST || slow) && state->watch_deadline == 0)
    state->watch_deadline = state->steps + (slow ? WINDOW : WINDOW / 2);
  return state->watch_deadline > 0 && passes(state, report->energy) ? THRUM_DECISION_SWITCH
                                                                    : THRUM_DECISION_CONTINUE;
}

/* Steps again from the state before this one, which stage 1 left synchronised in q_kept and p_kept:
 * where the energy jumps, the step before it is the one that went wrong. */
static thrum_status redo(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report) {
  thrum_state_view before = *view;
  before.q = view->q_kept;
  before.p = view->p_kept;
  before.load = view->load_before;
  const thrum_status status = thrum_step_energy(model, state, &before, report);
  if (status != THRUM_OK || !thrum_all_finite(view->q_next, state->rank) ||
      !thrum_all_finite(view->p_next, state->rank))
    return THRUM_NOT_CONVERGED;
  memcpy(view->q_start, view->q_next, (size_t)state->rank * sizeof *view->q_start);
  memcpy(view->p_start, view->p_next, (size_t)state->rank * sizeof *view->p_start);
  view->q = view->q_start;
  view->p = view->p_start;
  return THRUM_OK;
}

thrum_status thrum_stability_switch(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, thrum_stability_decision decision,
                                    thrum_solve_report *report) {
  // without explicit modes since this step only, the step before may be what went wrong
  if (report->energy_ahead &&
      !(fabs(energy_at(model, state, view, view->q, view->p) - report->energy_scale) <=
        URGENT_SHARE * fabs(report->energy_scale)))
    decision = THRUM_DECISION_REDO;
  // a step that was looked at beforehand has another energy than the one to compare with
  const bool ahead = report->energy_ahead || report->load_jumped;
  state->switched_energy = fabs(ahead ? report->energy_scale : report->energy);
  memset(report, 0, sizeof *report);
  state->scheme_switches++;
  const int64_t changes = state->scheme_switches < 10 ? state->scheme_switches : 10;
  state->quiet_end = state->steps + ((int64_t)SWITCHED_STEPS << changes);
  // the energy to keep is what the reference and the work since say, where they are exact
  if (state->stability_windows >= 0 && MOVED * state->stability_recent <= FOLLOW * scale_now(state))
    thrum_energy_correction_open(state, state->stability_reference + state->stability_work);
  if (decision == THRUM_DECISION_REDO && state->kept_step == state->steps - 1) {
    thrum_state energy_state = *state;
    energy_state.scheme = THRUM_SCHEME_ENERGY;
    energy_state.split = 0;
    energy_state.jacobian_kept = 0;
    energy_state.potential_step = -1;
    energy_state.past_count = 0;
    if (redo(model, &energy_state, view, report) == THRUM_OK) {
      *state = energy_state;
      state->switched_energy = energy_at(model, state, view, view->q, view->p);
      memset(report, 0, sizeof *report);
      return THRUM_OK;
    }
    memset(report, 0, sizeof *report);
  }
  return change(model, state, view, THRUM_SCHEME_ENERGY, 0);
}

void thrum_stability_after(const thrum_model *model, thrum_state *state,
                           const thrum_state_view *view) {
  if (!state->adaptive || state->scheme == THRUM_SCHEME_ENERGY)
    return;
  double dissipated, load_jump;
  const double work = work_of(model, state, view, &dissipated, &load_jump);
  state->stability_work += work - dissipated;
  // a constant load is one more potential, and so no reason for the balance to move
  state->stability_moved += dissipated + (load_jump != 0.0 ? fabs(work) : 0.0);
  state->stability_recent += dissipated;
  // a blow that gives more than there was gives it with the error of one large step
  if (load_jump != 0.0 && fabs(work) > BLOW * scale_now(state))
    compare_anew(state);
  if (!(fabs(state->stability_work) + state->stability_moved < RANGE))
    thrum_stability_reset(state);
}
