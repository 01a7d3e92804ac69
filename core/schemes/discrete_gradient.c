/* One energy-conserving step of all modes by a discrete gradient (design 7):
 *
 *   p' = p - h L F,  F = R-bar + N D v - f,  q' = q + h/2 L (p + p'),  v = N (q' - q)/h,
 *   d = q' - q,
 *
 * with a mean force R-bar for which R-bar d = V(q') - V(q). So 1/2 |p|^2 + V changes by the work of
 * the load less the dissipation h v D v at any h, as L d F = h/2 (p + p') F; the rest that the
 * solver's tolerance leaves is taken up by a scale of p'. L = diag(lambda) and N = diag(nu) are 1
 * but for slow modes, which they step at their own frequency (frequency_matching.c). Two mean
 * forces have that property:
 *
 *   trapezoidal discrete gradient  R-bar = 1/2 [R(q) + R(q')] + sigma d,
 *                  sigma = (V(q') - V(q) - 1/2 [R(q) + R(q')] d)/|d|^2
 *   average vector field           R-bar = integral over s in [0, 1] of R(q + s d)
 *                  = [R(q) + 4 R(q + d/2) + R(q')]/6
 *
 * R(q) is the R(q') of the step before and V(q') comes with R(q'), so the first takes one force an
 * iteration, as Newmark does. The second takes two, but it is a gradient in d: full Newton can
 * search along the step's potential and always finds a solution. So it serves steps that the first
 * does not solve, some steps after them, the fallback levels, and tangent damping, which takes T at
 * the midpoint.
 *
 * With the trapezoidal discrete gradient the known half of F when a step begins, R(q) - f, goes to
 * the kick, and the solve has the other half, as that of Newmark's step has it (share = 1/2; for
 * the average vector field share = 1, E = R-bar):
 *
 *   0 = mu (d - kick) + share h^2/2 [E + N D v/share - f],  mu = 1/lambda^2,
 *   kick = h L p - (1 - share) h^2/2 L^2 [R(q) - f],
 *   R-bar = (1 - share) R(q) + share E,  E = R(q') + 2 sigma d
 *
 * The first guess then extrapolates only the unknown part.
 * Cost: an iteration takes one force evaluation (the average vector field two) and about 2 r^2, a
 * new Jacobian a tangent and r^3. Sources: Gonzalez 1996, Time integration and discrete Hamiltonian
 * systems, doi:10.1007/BF02440162, with the trapezoidal force in place of the one of the midpoint;
 * Quispel & McLaren 2008, A new class of energy-preserving numerical integration methods,
 * doi:10.1088/1751-8113/41/4/045206.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/schemes/discrete_gradient.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/lane_sums.h"
#include "core/polynomial/points.h"
#include "core/polynomial/polynomial_private.h"
#include "core/schemes/discrete_gradient_private.h"
#include "core/schemes/schemes.h"
#include "core/solve/spurious_work.h"

#define ENERGY_TOLERANCE 1e-5    /* of the trapezoidal discrete gradient, unless the def has one */
#define JACOBIAN_STEPS 8         /* most steps between two Jacobians that are planned; */
#define JACOBIAN_STEPS_POINTS 32 /* of cubature points, whose tangent takes twenty forces */
#define JUMP_MOST 1e-4           /* work of a load jump on a carried correction, over |p|^2 */
#define STEP_FADE 0.99           /* of the largest increment lately, from step to step */
#define CONTRACTION_FADE 0.25

/* How many of the first modes are stepped at their own frequency. */
static int32_t matched_modes(const thrum_model *model, const thrum_state *state) {
  return thrum_schemes.mode_steps ? thrum_schemes.mode_steps->count(model, state) : 0;
}

/* Gives the problem the time steps of the modes whose frequency is matched. */
static void match_frequencies(thrum_solver *s) {
  thrum_state_view *view = s->view;
  const int32_t count = matched_modes(s->model, s->state);
  if (count > 0)
    thrum_schemes.mode_steps->all(s->model, s->state, count, view->stretch, view->unstretch,
                                  view->speed);
  for (int32_t i = 0; i < count; i++) {
    view->mass[i] = view->unstretch[i] * view->unstretch[i];
    view->drag[i] = view->speed[i];
  }
  for (int32_t i = count; i < s->n; i++)
    view->stretch[i] = view->unstretch[i] = 1.0;
  thrum_problem_take_own(s, count);
}

/* The problem in which the solve has this share of F, without its kick. */
static thrum_solver make_problem(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report, double share) {
  const double h = state->def.dt;
  thrum_solver s = thrum_problem_make(model, state, view, report, 0, 0.5 / share,
                                      0.5 * share * h * h, 1.0 / (share * h));
  match_frequencies(&s);
  return s;
}

thrum_solver thrum_energy_problem(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report) {
  return make_problem(model, state, view, report, 0.5);
}

/* The same with its kick. */
static thrum_solver problem_of(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report, double share) {
  const double h = state->def.dt, known = 0.5 * h * h * (1.0 - share);
  thrum_solver s = make_problem(model, state, view, report, share);
  for (int32_t i = 0; i < s.n; i++) {
    const double stretch = view->stretch[i], unbalanced = view->force_start[i] - view->load[i];
    view->kick[i] = h * stretch * view->p[i] - known * (stretch * stretch) * unbalanced;
  }

  // past solves of the other mean force do not continue this one
  report->discrete = share < 1.0;
  if (state->past_discrete != report->discrete)
    s.past_count = 0;
  return s;
}

/* R(q) into view->force_start and V(q) into the report. */
static void start(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                  bool known, thrum_solve_report *report) {
  if (known) {
    memcpy(view->force_start, view->force_now, (size_t)state->rank * sizeof *view->force_start);
    report->potential_start = state->potential;
    return;
  }
  report->potential_start =
      thrum_internal_force_by(view->kernel, model, view->q, view->force_start, view->work);
}

/* True where the load has changed by so much that its work on the carried correction counts. */
static bool load_jumps(const thrum_state *state, const thrum_state_view *view) {
  double work = 0.0, square = 0.0;
  for (int32_t i = 0; i < state->rank; i++) {
    const double carried = view->q_corrected[i] - view->q[i];
    work += (view->load[i] - view->load_before[i]) * carried;
    square += view->p[i] * view->p[i];
  }
  return !(fabs(work) <= JUMP_MOST * square);
}

bool thrum_energy_begin(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                        thrum_solve_report *report, thrum_solver *s, thrum_step_start *from) {
  report->potential_known = report->carries = false;
  report->contraction = -1.0;
  if (thrum_tangent_damped(state) || state->report.steps < state->average_field_end)
    return false;

  // from where the step before has left its correction, if it did
  const bool carried = state->carried && !load_jumps(state, view);
  const bool known = state->potential_step == state->report.steps && carried == state->carried;
  from->q = view->q;
  from->p = view->p;
  if (known && carried) {
    view->q = view->q_corrected;
    view->p = view->p_corrected;
  }
  start(model, state, view, known, report);
  from->potential = known && carried ? state->potential_end : report->potential_start;

  *s = problem_of(model, state, view, report, 0.5);
  if (state->def.tolerance == 0.0 && state->def.solver == THRUM_SOLVER_QUASI_NEWTON)
    s->tolerance = ENERGY_TOLERANCE;
  s->tolerance *= thrum_spurious_work_share(state);
  thrum_trapezoid_prepare(s);
  return true;
}

thrum_quasi_next thrum_energy_take(const thrum_solver *s, const thrum_step_start *from,
                                   thrum_quasi *quasi) {
  return thrum_trapezoid_take(s, from, quasi);
}

/* The step with the average vector field. */
static thrum_status step_average(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report) {
  const bool known = state->potential_step == state->report.steps && !state->carried;
  start(model, state, view, known, report);
  thrum_solver s = problem_of(model, state, view, report, 1.0);
  return thrum_average_step(&s);
}

thrum_status thrum_energy_finish(const thrum_solver *s, const thrum_step_start *from, bool solved) {
  const thrum_state *state = s->state;
  thrum_state_view *view = s->view;
  thrum_solve_report *report = s->report;

  // all others look at the end of the step before
  view->q = from->q;
  view->p = from->p;
  if (solved && isfinite(report->potential_corrected) &&
      thrum_all_finite(view->q_corrected_next, state->rank) &&
      thrum_all_finite(view->p_corrected_next, state->rank) &&
      thrum_all_finite(view->force_2, state->rank))
    return THRUM_OK;

  // the cheaper mean force has no potential, so full Newton could not search along it
  report->discrete_failed = true;
  report->potential_known = report->solved = report->carries = report->sampled = false;
  report->contraction = -1.0;
  return step_average(s->model, state, view, report);
}

thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report) {
  thrum_solver s;
  thrum_step_start from;
  if (!thrum_energy_begin(model, state, view, report, &s, &from))
    return step_average(model, state, view, report);
  return thrum_energy_finish(&s, &from, thrum_trapezoid_solve(&s, &from));
}

/* Keeps what the step has shown of the inverse, and plans when it is to be replaced. */
static void keep_inverse_plan(const thrum_model *model, thrum_state *next,
                              const thrum_solve_report *report) {
  const int32_t most = thrum_has_points(model) ? JACOBIAN_STEPS_POINTS : JACOBIAN_STEPS;

  // a contraction that grows counts at once
  const double measured = fmin(report->contraction, 1.0), known = next->contraction;
  if (measured >= 0.0)
    next->contraction =
        known > 0.0 && measured < known ? known + CONTRACTION_FADE * (measured - known) : measured;
  if (!report->refreshed) {
    // at rest none is made
    if (next->jacobian_due <= next->report.steps)
      next->jacobian_due = next->report.steps + most;
    return;
  }

  // needed before it was due, the next one is planned earlier
  const int32_t interval = next->jacobian_interval;
  if (report->late_refresh)
    next->jacobian_interval = interval > 1 ? interval / 2 : 1;
  else
    next->jacobian_interval = interval > 0 && interval < most ? interval + 1 : most;
  next->jacobian_step = next->report.steps;
  next->jacobian_due = next->report.steps + next->jacobian_interval;
}

void thrum_energy_keep(const thrum_model *model, thrum_state *next, const thrum_state_view *view,
                       const thrum_solve_report *report) {
  const size_t vector = (size_t)next->rank * sizeof(double);
  const bool known = report->potential_known;
  next->potential_step = known ? next->report.steps + 1 : -1;
  next->potential = !known            ? 0.0
                    : report->carries ? report->potential_corrected
                                      : report->potential;
  if (known)
    memcpy(view->force_now, view->force_2, vector);

  // where the next step starts
  next->potential_end = known ? report->potential : 0.0;
  next->carried = known && report->carries;
  if (!next->carried)
    return;
  memcpy(view->q_corrected, view->q_corrected_next, vector);
  memcpy(view->p_corrected, view->p_corrected_next, vector);
  next->step_recent = fmax(report->step, STEP_FADE * next->step_recent);
  next->report.single_steps += report->iterations == 0 ? 1 : 0;
  keep_inverse_plan(model, next, report);
  thrum_spurious_work_enter(next, report);
}

void thrum_energy_forget(thrum_state *state) {
  state->carried = 0;
  state->step_recent = 0.0;
  state->contraction = 0.0;
  state->jacobian_interval = 0;
  state->jacobian_step = 0;
  state->jacobian_due = 0;
  thrum_spurious_work_forget(state);
}

/* --- its row ---------------------------------------------------------------------------------- */

/* The trapezoidal rule; the modes whose frequency is matched keep their own. */
static thrum_mode_factor frequency(const thrum_model *model, const thrum_state *state, int32_t i,
                                   double z) {
  (void)model, (void)state, (void)i;
  return thrum_newmark_factor(z, 0.25, 0.5);
}

static bool problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                    thrum_solve_report *report, thrum_solver *s) {
  *s = thrum_energy_problem(model, state, view, report);
  return true;
}

static bool known_start(const thrum_state *state, const thrum_state_view *view,
                        thrum_known_start *start) {
  *start = state->carried
               ? (thrum_known_start){view->q_corrected, view->p_corrected, view->force_now}
               : (thrum_known_start){view->q, view->p, view->force_now};
  return state->potential_step == state->report.steps;
}

/* Damping acts on the velocity N d / h. */
static thrum_damped_part damped(const thrum_model *model, const thrum_state *state,
                                const thrum_state_view *view, int32_t i) {
  const double d = view->q_next[i] - view->q[i];
  const double matched = thrum_schemes.mode_steps->of(model, state, i).speed * d;
  return (thrum_damped_part){matched, matched};
}

static thrum_mode_answer answer(const thrum_model *model, const thrum_state *state, int32_t own,
                                int32_t i) {
  if (i >= own)
    return (thrum_mode_answer){1.0, 0.5, 0.5, 0.25};

  // its time step is stretched
  const thrum_matched_step by = thrum_schemes.mode_steps->of(model, state, i);
  const double square = by.stretch * by.stretch;
  return (thrum_mode_answer){by.stretch, 0.5 * square, 0.5 * square * (by.speed * by.speed),
                             0.25 * square};
}

const thrum_scheme_row thrum_energy_scheme = {
    .scheme = THRUM_SCHEME_ENERGY,
    .integrator = THRUM_INTEGRATOR_ENERGY,
    .form = -1,
    .step = thrum_step_energy,
    .frequency = frequency,
    .answer = answer,
    .problem = problem,
    .own_modes = matched_modes,
    .damped = damped,
    .start = known_start,
};
