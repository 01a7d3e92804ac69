/* A time step that is coarse against a mode that moves, see coarse_step.h.
 *
 * Of a linear oscillator of angular frequency w the trapezoidal rule makes the period longer by
 * (wh/2) / atan(wh/2) - 1: 1 % at 18 steps a period, 5 % at 8, 18 % at 4. A beam that 20 N pull at
 * suddenly was, after ten periods, away from a run of 200 steps a period by (rms, of the motion)
 *
 *   steps a period      20     12      8      6      4
 *   energy             2.5    2.5    2.6     90     82 %
 *   newmark, midpoint   20     52     84     90     82 %
 *   imexv               11     30     48     90     82 %
 *
 * as `energy` turns modes with wh <= 1 at their own frequency. So the others are looked at by how
 * late the mode that holds most is at the end of the run, too. A mode out of phase has up to about
 * its share of the motion wrong. Of a cantilever of steel that was struck at its tip, the second
 * mode of bending had 7 % of the motion and, by 3 ms, 1.3 steps a period: the run was 7.6 % from
 * one of 1/96 of the step, and 0.9 % where the mode had 8 steps. Cost: a pass over loads and start.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/coarse_step.h"

#include <math.h>
#include <stdio.h>

#include "config/message.h"
#include "core/base/pi.h"

#define SHARE 0.05     /* of the motion: a mode that vibrates by less is not looked at */
#define DAMPED 0.3     /* of critical damping: what dies out within a period is not looked at */
#define SLOW 5.0       /* periods over which a ramp makes a mode follow it, and not vibrate */
#define STEPS 8.0      /* a period that show a mode, */
#define STEPS_HIGH 5.0 /* by methods of order four, */
#define STEPS_ENERGY THRUM_TWO_PI /* and by energy: with wh = 1 */
#define MAIN 0.5          /* of the motion: a mode that is looked at to the end of the run, */
#define STEPS_LATE 20.0   /* with fewer steps a period than these, */
#define TURNED 0.6        /* and late by more radians at the end: its motion is some 30 % off */
#define WOULD_DO 20.0     /* steps a period that are proposed, */
#define WOULD_DO_LOW 60.0 /* and where the period errs by the trapezoidal rule: 0.1 % */

/* How far a load makes an oscillator of unit mass vibrate, by what a unit force does; 0: not at
 * all, or slowly. *follows: how far it moves it, vibration or not. */
static double answer_to(const thrum_load *course, double w, double time, double *follows) {
  const double length = fmin(course->until, time) - course->from, statics = 1 / (w * w);
  *follows = length > 0 ? statics : 0;
  if (!(length > 0) || (course->shape == THRUM_LOAD_RAMP && length * w > SLOW * THRUM_TWO_PI))
    return 0;

  // a sine shakes at its own pace, and a mode that is faster follows it
  if (course->shape == THRUM_LOAD_SINE) {
    const double ratio = THRUM_TWO_PI * course->frequency / w;
    *follows = statics / fmax(fabs(1 - ratio * ratio), 0.05);
    return fmin(ratio, 1) * *follows;
  }

  // a short one is an impulse; one that lasts takes it to twice where it would rest
  *follows = fmin(2 * statics, length / w);
  return *follows;
}

/* Fills how far the modes vibrate (rank); returns the norm of all motion. */
static double fill_amplitudes(const coarse_step_motion *of, double *moves) {
  const simulate_request *request = of->request;
  const int64_t r = of->model->rank;
  double sum = 0;
  bool rests = false;
  for (int64_t n = 0; n < request->start_count; n++)
    rests = rests || request->starts[n].kind == START_STATIC;

  for (int64_t i = 0; i < r; i++) {
    const double w = of->pace * sqrt(of->model->omega2[i]);
    double all = 0;
    moves[i] = 0;
    if (!(w > 0))
      continue;

    // a body that begins at rest under its loads feels no shock by those that stay
    for (int64_t n = 0; n < request->load_count; n++) {
      const thrum_load *course = &request->loads[n].course;
      double follows = 0;
      if (request->loads[n].gravity && of->model->rigid != NULL)
        continue; // it moves a free body as a whole; the rest is rounding
      const double force = fabs(of->directions[n * r + i]);
      const double vibrates = answer_to(course, w, request->time, &follows);
      if (!(rests && course->shape == THRUM_LOAD_CONSTANT && course->from == 0))
        moves[i] += force * vibrates;
      all += force * follows;
    }

    // a start at rest under loads that then go vibrates as well, unless they stay
    double begins = of->p != NULL ? fabs(of->p[i]) / w : 0;
    if (of->q != NULL && !(rests && request->load_count > 0))
      begins += fabs(of->q[i]);
    moves[i] += begins;
    sum += (all + begins) * (all + begins);
  }
  return sqrt(sum);
}

/* Steps in a period from which the integrator shows a mode. */
static double steps_needed(const thrum_state_def *def) {
  switch (def->integrator) {
  case THRUM_INTEGRATOR_ENERGY:
    return def->frequency_matched ? STEPS_ENERGY : STEPS;
  case THRUM_INTEGRATOR_FOX_GOODWIN:
  case THRUM_INTEGRATOR_RK4:
    return STEPS_HIGH;
  default:
    return STEPS;
  }
}

/* A number of two digits that is not above the value. */
static double round_down(double value) {
  const double unit = pow(10, floor(log10(value)) - 1);
  return unit * floor(value / unit * (1 + 1e-12));
}

/* By how much the trapezoidal rule makes a period longer. */
static double lateness(double w, double dt) {
  const double half = w * dt / 2;
  return half / atan(half) - 1;
}

/* Is a mode late at the end of the run, or when damping has taken it, by an integrator that steps
 * modes with the periods of the trapezoidal rule? */
static bool is_late(const simulate_request *request, double w) {
  const thrum_state_def *def = &request->def;
  const double damping = def->damping_alpha / (2 * w) + def->damping_beta * w / 2;
  const double lasts = fmin(request->time, 1 / (damping * w));
  return w > 0 && steps_needed(def) == STEPS && THRUM_TWO_PI / (w * def->dt) < STEPS_LATE &&
         lateness(w, def->dt) * w * lasts > TURNED;
}

/* Is the step coarse against such a mode? What dies out within a period is not looked at. */
static bool is_coarse(const thrum_state_def *def, double w) {
  const double damping = def->damping_alpha / (2 * w) + def->damping_beta * w / 2;
  return w > 0 && THRUM_TWO_PI / (w * def->dt) < steps_needed(def) && damping <= DAMPED;
}

void coarse_step_warn(const coarse_step_motion *motion, const char *who) {
  const thrum_state_def *def = &motion->request->def;
  double moves[THRUM_RANK_MAX];
  const double all = fill_amplitudes(motion, moves);

  // the one that vibrates most of those that the step does not show; a base moves the first of all
  int64_t worst = -1, fastest = -1;
  for (int64_t i = 0; i < motion->model->rank; i++) {
    const double pace = motion->pace * sqrt(motion->model->omega2[i]);
    const bool counts = moves[i] > SHARE * all || (motion->base && i == 0);
    const bool late = moves[i] > MAIN * all && is_late(motion->request, pace);
    if (!late && (!counts || !is_coarse(def, pace)))
      continue;
    fastest = i;
    if (worst < 0 || moves[i] > moves[worst])
      worst = i;
  }
  if (worst < 0)
    return;

  // of a first mode with so few steps the run says that its motion cannot be seen
  const double w = motion->pace * sqrt(motion->model->omega2[worst]);
  const double steps = THRUM_TWO_PI / (w * def->dt), needed = steps_needed(def);
  if (worst == 0 && !(steps >= 2))
    return;

  // what would do for it and for the fastest, and how late the mode is by a method of order two
  const double late = lateness(w, def->dt);
  const bool high = needed == STEPS_HIGH;
  const double least = motion->pace * sqrt(motion->model->omega2[fastest]) * needed;
  const double would = w * (needed == STEPS ? WOULD_DO_LOW : WOULD_DO);
  const double dt = round_down(THRUM_TWO_PI / fmax(would, least));
  char error[80] = "", share[60] = "";
  if (!high)
    snprintf(error, sizeof error, ", so that it comes out about %.2g %% longer", 100 * late);
  if (moves[worst] > 0)
    snprintf(share, sizeof share, " and about %.0f %% of the motion", 100 * moves[worst] / all);
  config_warn("%sa period of mode %d, of %.4g Hz%s, has only %.2g steps of %g s%s: lower --dt, to "
              "%g say",
              who, (int)worst + 1, w / THRUM_TWO_PI, share, steps, def->dt, error, dt);
}

void coarse_step_warn_slowest(const thrum_model *model, double pace, double dt) {
  const double turns = dt * pace * sqrt(model->omega2[0]) / THRUM_TWO_PI;
  if (turns > 0.5)
    config_warn("a step of %g s is %.3g periods of the slowest mode, of %.4g Hz: its motion cannot "
                "be seen; lower --dt",
                dt, turns, turns / dt);
}
