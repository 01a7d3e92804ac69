/* A time step that is coarse against the slowest mode that moves, see coarse_step.h.
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
 * as `energy` turns modes with wh <= 1 at their own frequency. Cost: a pass over loads and start.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/coarse_step.h"

#include <math.h>
#include <stdio.h>

#include "config/message.h"
#include "core/base/pi.h"

#define SHARE 0.01     /* of the largest amplitude: a mode that moves by less is not looked at */
#define DAMPED 0.3     /* of critical damping: what dies out within a period is not looked at */
#define SLOW 5.0       /* periods over which a ramp makes a mode follow it, and not vibrate */
#define STEPS 8.0      /* a period that show a mode, */
#define STEPS_HIGH 5.0 /* by methods of order four, */
#define STEPS_ENERGY THRUM_TWO_PI /* and by energy: with wh = 1 */
#define WOULD_DO 20.0             /* steps a period that are proposed, */
#define WOULD_DO_LOW 60.0         /* and where the period errs by the trapezoidal rule: 0.1 % */

/* How far a load moves an oscillator of unit mass, by what a unit force does; 0: not at all, or
 * slowly. */
static double answer_to(const thrum_load *course, double w, double time) {
  const double length = fmin(course->until, time) - course->from;
  if (!(length > 0))
    return 0;
  if (course->shape == THRUM_LOAD_RAMP && length * w > SLOW * THRUM_TWO_PI)
    return 0;

  // a short one is an impulse, and a sine shakes at its own pace
  const double statics = 1 / (w * w);
  if (course->shape == THRUM_LOAD_SINE) {
    const double ratio = THRUM_TWO_PI * course->frequency / w;
    return statics / fmax(fabs(1 - ratio * ratio), 0.05);
  }
  return fmin(statics, length / w);
}

/* Fills how far the modes move (rank); returns the largest. */
static double fill_amplitudes(const coarse_step_motion *of, double *moves) {
  const simulate_request *request = of->request;
  const int64_t r = of->model->rank;
  double most = 0;
  bool rests = false;
  for (int64_t n = 0; n < request->start_count; n++)
    rests = rests || request->starts[n].kind == START_STATIC;

  for (int64_t i = 0; i < r; i++) {
    const double w = of->pace * sqrt(of->model->omega2[i]);
    moves[i] = 0;
    if (!(w > 0))
      continue;

    // a body that begins at rest under its loads feels no shock by those that stay
    for (int64_t n = 0; n < request->load_count; n++) {
      const thrum_load *course = &request->loads[n].course;
      if (!(rests && course->shape == THRUM_LOAD_CONSTANT && course->from == 0))
        moves[i] += fabs(of->directions[n * r + i]) * answer_to(course, w, request->time);
    }

    // a start at rest under loads that then go vibrates as well, unless they stay
    if (of->q != NULL && !(rests && request->load_count > 0))
      moves[i] += fabs(of->q[i]);
    if (of->p != NULL)
      moves[i] += fabs(of->p[i]) / w;
    most = fmax(most, moves[i]);
  }
  return most;
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

void coarse_step_warn(const coarse_step_motion *motion, const char *who) {
  const thrum_state_def *def = &motion->request->def;
  double moves[THRUM_RANK_MAX];
  const double most = fill_amplitudes(motion, moves);

  // the slowest one: modes ascend
  int64_t slowest = 0;
  while (slowest < motion->model->rank && !(moves[slowest] > SHARE * most) && !motion->base)
    slowest++;
  if (slowest == motion->model->rank || (!(most > 0) && !motion->base))
    return;
  const double w = motion->pace * sqrt(motion->model->omega2[slowest]);
  const double steps = THRUM_TWO_PI / (w * def->dt);
  const double damping = def->damping_alpha / (2 * w) + def->damping_beta * w / 2;
  const double needed = steps_needed(def);
  if (!(w > 0) || !(steps >= 2) || steps >= needed || damping > DAMPED)
    return;

  // what would do, and how late the mode is by a method of order two
  const double half = w * def->dt / 2, late = half / atan(half) - 1;
  const bool high = needed == STEPS_HIGH;
  const double dt = round_down(THRUM_TWO_PI / w / (needed == STEPS ? WOULD_DO_LOW : WOULD_DO));
  char error[80] = "";
  if (!high)
    snprintf(error, sizeof error, ", so that it comes out about %.0f %% longer", 100 * late);
  config_warn("%sa period of the slowest mode that moves, of %.4g Hz, has only %.2g steps of %g "
              "s%s: lower --dt, to %g say",
              who, w / THRUM_TWO_PI, steps, def->dt, error, dt);
}
