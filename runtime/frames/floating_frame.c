/* Steps of a free body's frame and shape together (thrum/floating_frame.h, design 20). With x = X +
 * U q in the frame, w its angular velocity and v = qdot, the Lagrangian is
 *
 *   1/2 w I(q) w + w G(q) v + 1/2 |v|^2 - V(q),   P = I w + G v,   G(q) e_i = S(q, e_i),
 *
 * S(a, b) = sum m (U a) x (U b). The step from q, v, P to q', v', P' is, with d = q' - q, wm = (w +
 * w')/2, qm = (q + q')/2, h the time step, L = Lambda and N of the frequency matching (design 7),
 *
 *   d = h L (v + v')/2,   P' = C^T (P + h t),   C = Cayley's transform of h wm,
 *   v' + G(q')^T w' - v - G(q)^T w = h L (f - <R> - N D N d/h + F),
 *   F_i = 1/2 w dI/dq_i(qm) w' + 1/2 [w' S(e_i, v) + w S(e_i, v')].
 *
 * I is quadratic in q and S bilinear, so F is a discrete gradient of the kinetic energy without any
 * correction: F d = w' G(q') (v + v')/2 - w G(q) (v + v')/2 + w (I(q') - I(q)) w'/2 - (w' - w)
 * (G(q') v' + G(q) v)/2. With d <R> = V(q') - V(q) the energy changes by f d, the torque times the
 * angle h wm and the damping; the momentum in the world by h times the torque (20.8).
 *
 * Newton's method solves for d, with w' found for each d by a Newton of its own in three unknowns.
 * The inverse of
 *
 *   2/(h L) + h L (d<R>/dd + damping - centrifugal) + gyroscopic - G'^T I'^-1 G' 2/(h L)
 *
 * is kept over steps. It is not symmetric. What a solve leaves of the energy is taken from v',
 * which the kinetic energy is quadratic in: 1/2 P I^-1 P + 1/2 v (1 - G^T I^-1 G) v. Cost: an
 * evaluation takes two forces and 27 r^2 operations, a Jacobian two tangents and about 2 r^3.
 * Sources: Gonzalez 1996, doi:10.1007/BF02440162; Cohen & Hairer 2011,
 * doi:10.1007/s10543-011-0310-z; Shabana 2013, doi:10.1017/CBO9781107337213, 5.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/floating_frame.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/vec3.h"
#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_problem.h"
#include "core/step/step.h"
#include "runtime/condensed/average_field.h"
#include "runtime/condensed/following.h"
#include "runtime/condensed/increment_solve.h"
#include "runtime/frames/inertia_private.h"
#include "runtime/frames/rigid_frame_private.h"
#include "runtime/guard/fallback.h"
#include "runtime/guard/frequency_matching.h"

#define TOLERANCE 1e-8 /* of a residual over the step, where the def names none */
#define KEPT_STEPS 8   /* after which a Jacobian is made anew */
#define GIVEN_BACK 0.5 /* share of the energy of the shape that a solve may have left */
#define WORK_COUNT 40  /* doubles of scratch a coordinate */

/* A shape and its motion. Arrays are of the r coordinates. */
typedef struct pose {
  const double *q;
  double *velocity;  /* v */
  double *moments;   /* r x 9: D_i = sum m x U_i^T */
  double *gyration;  /* r x 3: G e_i */
  double *swirl;     /* r x 3: S(v, e_i) */
  double *momentum;  /* v + G^T w */
  double tensor[9];  /* I(q), */
  double inverse[9]; /* and its inverse */
  double internal[3];
  double spin[3]; /* w */
} pose;

/* A step being solved. */
typedef struct motion {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  const thrum_inertia *inertia;
  int64_t r;
  pose before, after;
  double *q_after;
  double angular[3];   /* P: the angular momentum in the mesh, */
  double half_pull[3]; /* and h/2 times the torque */
  double mean_spin[3]; /* wm */
} motion;

size_t thrum_floating_frame_work_count(const thrum_inertia *inertia) {
  return inertia ? WORK_COUNT * (size_t)inertia->rank : 0;
}

/* --- a shape and its motion ------------------------------------------------------------------- */

/* Places the arrays of a pose in `work`; returns what is behind them. */
static double *place_pose(pose *at, int64_t r, double *work) {
  at->moments = work;
  at->gyration = at->moments + 9 * r;
  at->swirl = at->gyration + 3 * r;
  at->momentum = at->swirl + 3 * r;
  at->velocity = at->momentum + r;
  return at->velocity + r;
}

/* inverse = tensor^-1 of a symmetric matrix; false where it is not positive definite. */
static bool invert_tensor(const double tensor[9], double inverse[9]) {
  for (int row = 0; row < 3; row++)
    thrum_cross3(tensor + 3 * ((row + 1) % 3), tensor + 3 * ((row + 2) % 3), inverse + 3 * row);
  const double determinant = thrum_dot3(tensor, inverse);
  const double minor = tensor[0] * tensor[4] - tensor[1] * tensor[1];
  if (!(tensor[0] > 0.0 && minor > 0.0 && determinant > 0.0) || !isfinite(determinant))
    return false;
  for (int n = 0; n < 9; n++)
    inverse[n] /= determinant;
  return true;
}

/* The moments at the shape q, and the inertia that they say; false where it has no inverse. */
static bool shape_pose(const thrum_inertia *inertia, const thrum_kernel *by, const double *q,
                       pose *at) {
  const int64_t r = inertia->rank;
  at->q = q;
  by->product(r, 9 * r, inertia->pairs, q, at->moments);
  for (int64_t n = 0; n < 9 * r; n++)
    at->moments[n] += inertia->linear[n];
  for (int64_t i = 0; i < r; i++)
    thrum_inertia_cross(at->moments + 9 * i, at->gyration + 3 * i);
  thrum_inertia_of_moments(inertia, q, at->moments, at->tensor);
  return invert_tensor(at->tensor, at->inverse);
}

/* G v */
static void find_internal(pose *at, int64_t r) {
  memset(at->internal, 0, sizeof at->internal);
  for (int64_t i = 0; i < r; i++)
    for (int axis = 0; axis < 3; axis++)
      at->internal[axis] += at->velocity[i] * at->gyration[3 * i + axis];
}

/* v + G^T w of a pose with its w. */
static void find_momentum(pose *at, int64_t r) {
  for (int64_t i = 0; i < r; i++)
    at->momentum[i] = at->velocity[i] + thrum_dot3(at->gyration + 3 * i, at->spin);
}

/* The pose at the start of the step. */
static bool fill_before(motion *m) {
  pose *at = &m->before;
  memcpy(at->velocity, m->view->p, (size_t)m->r * sizeof *at->velocity);
  if (!shape_pose(m->inertia, m->view->kernel, m->view->q, at))
    return false;
  find_internal(at, m->r);
  double own[3];
  thrum_subtract3(m->angular, at->internal, own);
  thrum_apply3(at->inverse, own, at->spin);
  find_momentum(at, m->r);
  m->view->kernel->product(m->r, 3 * m->r, m->inertia->crosses, at->velocity, at->swirl);
  return true;
}

/* --- the equations of a step ------------------------------------------------------------------ */

/* The angular velocities of the step for the shape at its end, wm = I'^-1 y + (w - I'^-1 (P + G'
 * v'))/2 with y = (P + P')/2. False where they are not found. */
static bool find_spin(motion *m) {
  pose *after = &m->after;

  // the offset of wm from I'^-1 y, and the right-hand side of the equation for y
  double offset[3], right[3], y[3], sum[3];
  for (int axis = 0; axis < 3; axis++)
    sum[axis] = m->angular[axis] + after->internal[axis];
  thrum_apply3(after->inverse, sum, offset);
  for (int axis = 0; axis < 3; axis++) {
    offset[axis] = 0.5 * (m->before.spin[axis] - offset[axis]);
    right[axis] = m->angular[axis] + m->half_pull[axis];
  }

  if (!thrum_rigid_frame_solve(after->inverse, offset, 0.5 * m->state->def.dt, m->half_pull, right,
                               y, m->mean_spin))
    return false;
  for (int axis = 0; axis < 3; axis++)
    after->spin[axis] = 2.0 * m->mean_spin[axis] - m->before.spin[axis];
  return true;
}

/* The pose at the end of the step for the increment in view->unknown. */
static bool fill_after(motion *m) {
  thrum_state_view *view = m->view;
  pose *at = &m->after;
  const double twice = 2.0 / m->state->def.dt;

  // the increment says the shape and its velocity
  for (int64_t i = 0; i < m->r; i++) {
    m->q_after[i] = view->q[i] + view->unknown[i];
    at->velocity[i] = twice * (view->unstretch[i] * view->unknown[i]) - view->p[i];
  }

  // these say its inertia, and with the momentum its spin
  if (!shape_pose(m->inertia, view->kernel, m->q_after, at))
    return false;
  find_internal(at, m->r);
  if (!find_spin(m))
    return false;
  find_momentum(at, m->r);
  view->kernel->product(m->r, 3 * m->r, m->inertia->crosses, at->velocity, at->swirl);
  return true;
}

/* w (2 tr(D) 1 - D - D^T) w'/2 of a D_i = sum m x U_i^T, the centrifugal force. */
static double outward_force(const double moment[9], const double w[3], const double next[3]) {
  double one[3], other[3];
  thrum_apply3(moment, next, one);
  thrum_apply3(moment, w, other);
  return (moment[0] + moment[4] + moment[8]) * thrum_dot3(w, next) -
         0.5 * (thrum_dot3(w, one) + thrum_dot3(next, other));
}

/* F_i, the force of the rotation on coordinate i. */
static double rotation_force(const motion *m, int64_t i) {
  const double *w = m->before.spin, *next = m->after.spin;
  const double *first = m->before.moments + 9 * i, *last = m->after.moments + 9 * i;
  double moment[9];
  for (int n = 0; n < 9; n++)
    moment[n] = 0.5 * (first[n] + last[n]);

  // S(e_i, v) = -S(v, e_i)
  const double gyration =
      thrum_dot3(next, m->before.swirl + 3 * i) + thrum_dot3(w, m->after.swirl + 3 * i);
  return outward_force(moment, w, next) - 0.5 * gyration;
}

/* The residual of the increment in view->unknown; false where the shape has no inertia. */
static bool evaluate(void *of) {
  motion *m = of;
  thrum_state_view *view = m->view;
  const double h = m->state->def.dt;
  if (!fill_after(m))
    return false;

  // forces first, which all have the time step of their mode
  double *total = view->residual;
  for (int64_t i = 0; i < m->r; i++) {
    view->middle[i] = view->q[i] + 0.5 * view->unknown[i];
    const double damped = view->speed[i] * view->speed[i] *
                          thrum_rest_damping(m->model, m->state, i) * view->unknown[i];
    total[i] = damped - h * (view->load[i] + rotation_force(m, i));
  }
  thrum_average_field_add(m->model, m->state, view, view->unknown, total);
  for (int64_t i = 0; i < m->r; i++)
    total[i] = m->after.momentum[i] - m->before.momentum[i] + view->stretch[i] * total[i];
  return true;
}

/* --- the solve -------------------------------------------------------------------------------- */

/* The Jacobian of the residual into view->tangent, without how w' follows d but for G'^T I'^-1 G'.
 */
static void assemble(const motion *m) {
  thrum_state_view *view = m->view;
  const int64_t r = m->r;
  const double h = m->state->def.dt, *w = m->before.spin, *next = m->after.spin;
  thrum_average_field_slope(m->model, m->state, view, view->unknown, view->tangent);

  // the slope of the mean force is overwritten entry by entry
  for (int64_t i = 0; i < r; i++) {
    double answer[3];
    thrum_apply3(m->after.inverse, m->after.gyration + 3 * i, answer);
    for (int64_t j = 0; j < r; j++) {
      const double *cross = m->inertia->crosses + 3 * (i * r + j);
      const double outwards = 0.5 * outward_force(m->inertia->pairs + 9 * (i * r + j), w, next);
      const double gyroscopic =
          thrum_dot3(next, cross) + view->stretch[i] * view->unstretch[j] * thrum_dot3(w, cross);
      const double dragged =
          2.0 / h * view->unstretch[j] * thrum_dot3(answer, m->after.gyration + 3 * j);

      // F and the momentum at the end depend on d by the shape and by its velocity
      double *entry = view->tangent + i * r + j;
      *entry = h * view->stretch[i] * (*entry - outwards) - gyroscopic - dragged;
    }
    view->tangent[i * r + i] +=
        2.0 / h * view->unstretch[i] + view->stretch[i] * (view->speed[i] * view->speed[i]) *
                                           thrum_rest_damping(m->model, m->state, i);
  }
}

/* The inverse of the Jacobian, transposed as products read it, into jacobian_next; false: there is
 * none. */
static bool make_inverse(void *of, thrum_solve_report *report) {
  const motion *m = of;
  thrum_state_view *view = m->view;
  int32_t *pivots = (int32_t *)(void *)view->pivots_next;
  const int32_t r = (int32_t)m->r;
  assemble(m);
  report->factorisations++;
  report->refreshed = thrum_dense_factor(view->tangent, r, pivots);
  for (int32_t i = 0; i < r && report->refreshed; i++) {
    double *row = view->jacobian_next + (size_t)i * (size_t)r;
    memset(row, 0, (size_t)r * sizeof *row);
    row[i] = 1.0;
    thrum_dense_solve(view->tangent, r, pivots, row);
  }
  return report->refreshed;
}

/* Newton's method from the guess in view->unknown; the increment stays there. */
static thrum_status solve(motion *m, thrum_solve_report *report) {
  const thrum_increment increment = {m->model, m->state,     m->view, TOLERANCE,
                                     evaluate, make_inverse, m};
  const int64_t age = m->state->report.steps - m->state->inverse_step[0];
  const bool kept = m->state->jacobian_kept && age < KEPT_STEPS;
  return thrum_increment_solve(&increment, kept ? m->view->inverse[0] : NULL, report);
}

/* --- a step ----------------------------------------------------------------------------------- */

/* The time step of each mode, as the energy integrator has it. */
static void match(const motion *m) {
  thrum_state_view *view = m->view;
  const int32_t matched = thrum_matched_modes(m->model, m->state);
  thrum_match_steps(m->model, m->state, matched, view->stretch, view->unstretch, view->speed);
  for (int64_t i = matched; i < m->r; i++)
    view->stretch[i] = view->unstretch[i] = view->speed[i] = 1.0;
}

/* q' and v', with the energy that the balance says: what the solve has left goes to v'. */
static void finish(motion *m) {
  thrum_state_view *view = m->view;
  pose *after = &m->after;
  double excess = 0.0, kinetic = 0.0, answer[3];

  // the part of the kinetic energy that grows with the square of v'
  for (int64_t i = 0; i < m->r; i++) {
    excess += view->residual[i] * (view->unstretch[i] * view->unknown[i]) / m->state->def.dt;
    kinetic += 0.5 * (after->velocity[i] * after->velocity[i]);
  }
  thrum_apply3(after->inverse, after->internal, answer);
  kinetic -= 0.5 * thrum_dot3(answer, after->internal);

  // at a standstill there is nothing to take it from, and next to nothing left
  const bool given = kinetic > 0.0 && fabs(excess) <= GIVEN_BACK * kinetic;
  const double factor = given ? sqrt(1.0 - excess / kinetic) : 1.0;
  for (int64_t i = 0; i < m->r; i++)
    view->p_next[i] = factor * after->velocity[i];
  for (int axis = 0; axis < 3; axis++)
    after->internal[axis] *= factor;
  memcpy(view->q_next, m->q_after, (size_t)m->r * sizeof *view->q_next);
}

/* The frame at the end of the step, from the one at its start; `angle` grows by its rotation. */
static void turn(const motion *m, const thrum_placement *placement, const double axes[9],
                 const double torque[3], thrum_rigid_frame *rigid_frame, double angle[3]) {
  const double h = m->state->def.dt;
  double v[3], turned[3];

  // the momentum in the world is exact
  for (int axis = 0; axis < 3; axis++) {
    v[axis] = 0.5 * h * m->mean_spin[axis];
    rigid_frame->momentum[axis] += h * torque[axis];
  }
  thrum_apply3(axes, v, turned);
  for (int axis = 0; axis < 3; axis++)
    angle[axis] += 2.0 * turned[axis];
  thrum_rigid_frame_rotate(rigid_frame, placement, axes, v);

  // the next step starts from this shape
  memcpy(rigid_frame->inverse, m->after.inverse, sizeof rigid_frame->inverse);
  memcpy(rigid_frame->internal, m->after.internal, sizeof rigid_frame->internal);
}

/* The inputs of a step, and its results. */
typedef struct coupled_step {
  const thrum_inertia *inertia;
  const thrum_placement *placement;
  const double *torque;
  double *work;
  thrum_rigid_frame made;
  double angle[3];
} coupled_step;

/* One step of the state's dt from view->q and view->p and the frame `made`. */
static thrum_status step_once(void *of, const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, thrum_solve_report *report) {
  coupled_step *s = of;
  motion m = {
      .model = model, .state = state, .view = view, .inertia = s->inertia, .r = state->rank};
  m.q_after = place_pose(&m.after, m.r, place_pose(&m.before, m.r, s->work));

  // momentum and torque in the mesh
  double axes[9];
  thrum_rigid_frame_axes(&s->made, s->placement, axes);
  thrum_apply3_transposed(axes, s->made.momentum, m.angular);
  thrum_apply3_transposed(axes, s->torque, m.half_pull);
  for (int axis = 0; axis < 3; axis++)
    m.half_pull[axis] *= 0.5 * state->def.dt;

  match(&m);
  if (!fill_before(&m))
    return THRUM_NOT_FINITE;
  thrum_average_field_guess(state, view);
  THRUM_TRY(solve(&m, report));
  finish(&m);
  turn(&m, s->placement, axes, s->torque, &s->made, s->angle);
  report->solved = true;
  return thrum_all_finite(view->q_next, m.r) && thrum_all_finite(view->p_next, m.r)
             ? THRUM_OK
             : THRUM_NOT_FINITE;
}

/* The step at once, or in as many parts as it takes. */
static thrum_status attempt(coupled_step *s, const thrum_model *model, thrum_step_run *run) {
  const thrum_rigid_frame before = s->made;
  thrum_state *next = &run->next;
  thrum_status status = step_once(s, model, next, &run->view, &run->report);
  for (int32_t count = 2; next->def.fallback && status < 0 && count <= THRUM_SUBSTEPS_MAX;
       count *= 2) {
    s->made = before;
    memset(s->angle, 0, sizeof s->angle);
    status = thrum_fallback_substeps(model, next, &run->view, count, step_once, s, &run->report);
    run->report.fallback_level = THRUM_FALLBACK_SUBSTEPS;
  }

  // the parts are no history for the next step
  if (run->report.fallback_level == THRUM_FALLBACK_NONE)
    return status;
  run->report.refreshed = run->report.solved = false;
  next->past_count = 0;
  return status;
}

static thrum_status check(const thrum_model *model, const thrum_state *state,
                          const thrum_inertia *inertia, const thrum_rigid_frame *rigid_frame,
                          const double torque[3], const double *work, thrum_error *error) {
  if (!model || !state || !inertia || !rigid_frame || !torque || !work)
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "a step of a floating frame needs a model, a state, an inertia, a frame, "
        "a torque and work");
  if (model->rank != inertia->rank)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the inertia is for %lld coordinates and the model has %lld",
                           (long long)inertia->rank, (long long)model->rank);
  if (state->def.integrator != THRUM_INTEGRATOR_ENERGY || thrum_tangent_damped(state) ||
      thrum_slave_count(model) > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "shape and rotation are coupled by the integrator energy, with the "
                           "damping form rest, of models that are not condensed");
  if (!thrum_all_finite(torque, 3))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the torque on a floating frame is not finite");
  return THRUM_OK;
}

thrum_status thrum_floating_frame_step(const thrum_model *model, thrum_state *state,
                                       const thrum_inertia *inertia,
                                       const thrum_placement *placement,
                                       thrum_rigid_frame *rigid_frame, const double torque[3],
                                       double angle[3], double *work, thrum_error *error) {
  THRUM_TRY(check(model, state, inertia, rigid_frame, torque, work, error));
  thrum_step_run run;
  THRUM_TRY(thrum_step_begin(model, state, NULL, &run, error));
  coupled_step s = {.inertia = inertia,
                    .placement = placement,
                    .torque = torque,
                    .work = work,
                    .made = *rigid_frame};
  thrum_status status = attempt(&s, model, &run);
  if (status >= 0 &&
      !(thrum_all_finite(s.made.momentum, 3) && thrum_all_finite(s.made.attitude, 9)))
    status = THRUM_NOT_FINITE;
  status = thrum_step_end_coupled(model, &run, status, error);
  if (status < 0)
    return status;
  *rigid_frame = s.made;
  if (angle)
    memcpy(angle, s.angle, sizeof s.angle);
  return status;
}

/* --- frames at rest in their shape ------------------------------------------------------------ */

thrum_status thrum_floating_frame_settle(const thrum_inertia *inertia, const double *q,
                                         const double *p, thrum_rigid_frame *rigid_frame,
                                         double *work, thrum_error *error) {
  if (!inertia || !q || !rigid_frame || !work)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "to settle a frame takes an inertia, a shape, a frame and work");
  pose at;
  place_pose(&at, inertia->rank, work);
  if (!shape_pose(inertia, thrum_kernel_get(THRUM_KERNEL_BEST), q, &at) ||
      (p && !thrum_all_finite(p, inertia->rank)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the inertia of this shape has no inverse, or its velocity is not "
                           "finite");
  memset(at.velocity, 0, (size_t)inertia->rank * sizeof *at.velocity);
  if (p)
    memcpy(at.velocity, p, (size_t)inertia->rank * sizeof *at.velocity);
  find_internal(&at, inertia->rank);
  memcpy(rigid_frame->inverse, at.inverse, sizeof at.inverse);
  memcpy(rigid_frame->internal, at.internal, sizeof at.internal);
  return THRUM_OK;
}

void thrum_floating_frame_force(const thrum_inertia *inertia, const thrum_placement *placement,
                                const thrum_rigid_frame *rigid_frame, const double *q,
                                const double *p, double *force, double *work) {
  double axes[9], velocity[3], w[3];
  thrum_rigid_frame_axes(rigid_frame, placement, axes);
  thrum_rigid_frame_velocity(rigid_frame, placement, velocity);
  thrum_apply3_transposed(axes, velocity, w);

  // 1/2 w dI/dq_i w - 2 w S(v, e_i)
  pose at;
  place_pose(&at, inertia->rank, work);
  const thrum_kernel *by = thrum_kernel_get(THRUM_KERNEL_BEST);
  shape_pose(inertia, by, q, &at);
  by->product(inertia->rank, 3 * inertia->rank, inertia->crosses, p, at.swirl);
  for (int64_t i = 0; i < inertia->rank; i++)
    force[i] = outward_force(at.moments + 9 * i, w, w) - 2.0 * thrum_dot3(w, at.swirl + 3 * i);
}

void thrum_floating_frame_spin(const thrum_placement *placement, const double spin[3],
                               thrum_rigid_frame *rigid_frame) {
  double axes[9], tensor[9], in_mesh[3], momentum[3];
  thrum_rigid_frame_axes(rigid_frame, placement, axes);
  thrum_apply3_transposed(axes, spin, in_mesh);
  invert_tensor(rigid_frame->inverse, tensor);
  thrum_apply3(tensor, in_mesh, momentum);
  for (int axis = 0; axis < 3; axis++)
    momentum[axis] += rigid_frame->internal[axis];
  thrum_apply3(axes, momentum, rigid_frame->momentum);
}
