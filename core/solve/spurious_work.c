/* The guard on corrections that are not verified (design 7): a leak between modes does not show in
 * the total energy, which the discrete gradient keeps whatever the solve leaves.
 *
 * An increment that is off by e acts on the motion as a kick of 4 e/h (of 4 e/(lambda h) on modes
 * whose frequency is matched), and so does the work
 *
 *   W_b = 4/h sum of e_i p_i/lambda_i   on the modes i of a band b: those explicit at rest, or the
 * others.
 *
 * The discrete gradient takes the sum over both bands back along the increment d, in proportion to
 * their shares of |d|^2. So the work moves the energy
 *
 *   W = W_high - (W_low + W_high) |d_high|^2/|d|^2
 *
 * from one band to the other. Each new Jacobian shows for nothing what the inverse before it would
 * have done, e = (J^-1 - H) g. That stands for the steps since H was made, in which it did less:
 * the estimate is on the safe side. The bands also exchange energy by themselves, so it says how
 * much is moved rather than where it ends. Where W goes on in one direction and is more than a
 * small share of the energy of a band, the tolerance is halved, down to where corrections are
 * verified; where it is much less, it is doubled again. Cost: two products with a matrix and about
 * 10 r operations where a Jacobian is made.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/solve/spurious_work.h"

#include <math.h>
#include <string.h>

#define WORK_STEPS 1024 /* of a window */
#define WORK_MOST 3e-4  /* of the energy of a band: more work in a window tightens the tolerance */
#define WORK_NOISE 2.0  /* standard deviations of a sum that may be chance */
#define WORK_FAR 4.0    /* this much too much work is worth two halvings, too little one back */

void thrum_spurious_work_sample(const thrum_solver *s) {
  const thrum_state_view *view = s->view;
  const thrum_state *state = s->state;
  const double h = state->def.dt, twice = 2.0 / h;
  double work[2] = {0.0, 0.0}, energy[2] = {0.0, 0.0}, moved[2] = {0.0, 0.0};

  // p and q where the next step starts
  for (int32_t i = 0; i < s->n; i++) {
    const int band = i >= state->high_first;
    const double d = view->unknown[i] - view->direction[i];
    const double per = view->unstretch[i], p = twice * d * per - view->p[i], q = view->q[i] + d;
    work[band] += (view->direction[i] - view->correction[i]) * per * p;
    energy[band] += 0.5 * (p * p + s->model->omega2[i] * (q * q));
    moved[band] += d * d;
  }

  const double all = moved[0] + moved[1], share = all > 0.0 ? moved[1] / all : 0.0;
  const double steps = (double)(state->report.steps - state->jacobian_step);
  s->report->spurious_work = steps * (4.0 / h) * (work[1] - (work[0] + work[1]) * share);
  s->report->band_energy[0] = energy[0];
  s->report->band_energy[1] = energy[1];
  s->report->sampled = true;
}

/* The work of a window over what is allowed, 0 where it may be chance. */
static double excess_of(const thrum_spurious_work *w) {
  const double work = fabs(w->work), least = fmin(w->energy[0], w->energy[1]);
  if (w->samples == 0 || !(work > WORK_NOISE * sqrt(w->square)))
    return 0.0;
  return work * (double)w->samples / (WORK_MOST * least);
}

/* Ends a window: the tolerance changes by what it has shown. */
static void end_window(thrum_state *next) {
  const thrum_spurious_work was = next->spurious;
  const double excess = excess_of(&was);
  thrum_spurious_work_forget(next);
  thrum_spurious_work *w = &next->spurious;
  w->halvings = was.halvings;
  w->quiet = was.quiet;
  w->wait = was.wait;

  // too much: tighter, and longer until it is tried again
  if (excess > 1.0) {
    next->report.tightened++;
    w->halvings += excess > WORK_FAR ? 2 : 1;
    w->wait = was.wait > 0 ? 2 * was.wait : 1;
    if (w->halvings > THRUM_HALVINGS_MOST)
      w->halvings = THRUM_HALVINGS_MOST;
    if (w->wait > THRUM_WAIT_MOST)
      w->wait = THRUM_WAIT_MOST;
    w->quiet = w->wait;
  } else if (excess < 1.0 / WORK_FAR && w->halvings > 0 && --w->quiet <= 0) {
    w->halvings--;
    w->quiet = w->wait;
  }
}

void thrum_spurious_work_enter(thrum_state *next, const thrum_solve_report *report) {
  thrum_spurious_work *w = &next->spurious;
  const double work = report->spurious_work, *energy = report->band_energy;
  const bool finite = isfinite(next->report.spurious + work * work + w->square) &&
                      isfinite(w->energy[0] + energy[0] + w->energy[1] + energy[1]);
  if (report->sampled && finite) {
    next->report.spurious += work;
    w->work += work;
    w->square += work * work;
    w->energy[0] += energy[0];
    w->energy[1] += energy[1];
    w->samples++;
  }
  if (next->report.steps >= w->window_end)
    end_window(next);
}

void thrum_spurious_work_forget(thrum_state *state) {
  memset(&state->spurious, 0, sizeof state->spurious);
  state->spurious.window_end = state->report.steps + WORK_STEPS;
}

double thrum_spurious_work_share(const thrum_state *state) {
  return ldexp(1.0, -(int)state->spurious.halvings);
}
