/* A step of a condensed model with the inertia of what follows (design 17). The body moves on the
 * manifold y = Y(x), quadratic in the masters x, with the kinetic energy of all coordinates:
 *
 *   E = 1/2 |v|^2 + 1/2 |J(x) v|^2 + V_c(x),   J = dY/dx, linear in x
 *
 * As Y is quadratic, Y(x') - Y(x) = J(xm) d with d = x' - x and xm = x + d/2. The trapezoidal rule
 * in all coordinates, d = h/2 (v + v') and J(xm) d = h/2 (u + u') with u = J(x) v, leaves
 *
 *   F(d) = (v' - v) + J(xm)^T (u' - u) + h <R> + damping - h f = 0,
 *
 * k equations in d; <R> is the mean of R_c over the step, exact for a quartic V_c with two Gauss
 * points. d F is h times the error of the energy balance, so that 1/2 |v|^2 + 1/2 |u|^2 + V_c
 * changes by f d less the dissipation, at any h. u' is not yet J(x') v', but for O(h^2): (v', u')
 * is projected onto the tangent space of the manifold at x', and its length gives back what energy
 * the projection took (of the order h^4) and what an inexact solve left (d F / h).
 *
 * Newton's method solves for d, with the inverse, kept over steps, of
 *   2/h + alpha + J^T (2/h + D_y) J + h/2 T + beta diag(omega^2) at xm,
 * D_y = alpha + beta omega^2 of the slaves. J is not formed but for that (following.c).
 * Cost: an evaluation takes two forces and two passes over the s k^2/2 numbers of `follow` for s
 * slaves, the rest of a step about six passes more. Without slaves it is the average vector field.
 * Sources: Jain et al. 2017, doi:10.1016/j.compstruc.2017.04.005 (quadratic manifold); Quispel &
 * McLaren 2008, doi:10.1088/1751-8113/41/4/045206 (average vector field).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/condensed/manifold.h"

#include <math.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_problem.h"
#include "runtime/condensed/average_field.h"
#include "runtime/condensed/following.h"
#include "runtime/condensed/increment_solve.h"

#define TOLERANCE 1e-6 /* of a residual over the step, where the def names none */
#define PROJECTED 1e-8 /* residual of the projection over the velocity */

/* A step being solved. The arrays are of the slaves, but for what says otherwise. */
typedef struct motion {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  thrum_following follow;
  int64_t masters, slaves;
  double *before; /* u at the start of the step */
  double *moved;  /* J(xm) d */
  double *gained; /* u' - u */
  double *image;  /* of `follow` */
  double *damped; /* alpha, or alpha + beta omega^2 with damping at rest */
  double *slopes; /* slaves x masters: J at the last point of a Jacobian */
} motion;

int64_t thrum_manifold_count(const thrum_model *model) {
  const int64_t slaves = thrum_slave_count(model);
  return thrum_following_count(model) + slaves * (model->rank + 4);
}

static motion motion_of(const thrum_model *model, const thrum_state *state,
                        thrum_state_view *view) {
  motion m = {.model = model,
              .state = state,
              .view = view,
              .follow = thrum_following_of(model, view->kernel, view->restricted),
              .masters = model->rank,
              .slaves = thrum_slave_count(model)};
  m.image = m.follow.image;
  m.before = view->restricted + thrum_following_count(model);
  m.moved = m.before + m.slaves;
  m.gained = m.moved + m.slaves;
  m.damped = m.gained + m.slaves;
  m.slopes = m.damped + m.slaves;

  // in tangent form what follows is not damped against the masters
  const double beta = thrum_tangent_damped(state) ? 0.0 : state->def.damping_beta;
  for (int64_t s = 0; s < m.slaves; s++)
    m.damped[s] = state->def.damping_alpha + beta * thrum_slave_omega2(model, s);
  return m;
}

double thrum_manifold_slave_energy(const thrum_model *model, const double *x, const double *v) {
  const double *row = model->follow;
  double sum = 0.0;
  for (int64_t s = 0; s < thrum_slave_count(model); s++) {
    double speed = 0.0;
    for (int64_t i = 0; i < model->rank; i++)
      for (int64_t j = i; j < model->rank; j++)
        speed += *row++ * (v[i] * x[j] + x[i] * v[j]);
    speed *= model->follow_scale;
    sum += 0.5 * (speed * speed);
  }
  return sum;
}

/* --- the solve -------------------------------------------------------------------------------- */

/* (alpha + beta stiffness) d into view->product, with the stiffness at rest or at the middle. */
static void damp(const motion *m, const double *d) {
  const thrum_state_def *def = &m->state->def;
  thrum_state_view *view = m->view;
  const bool tangent = thrum_tangent_damped(m->state);
  if (tangent)
    thrum_tangent_product_by(view->kernel, m->model, view->middle, d, view->product, view->work);
  for (int64_t i = 0; i < m->masters; i++) {
    const double stiff = tangent ? view->product[i] : m->model->omega2[i] * d[i];
    view->product[i] = thrum_mass_damping(m->model, m->state, i) * d[i] + def->damping_beta * stiff;
  }
}

/* F(d) of the increment in view->unknown, with J(xm) d and u' - u. */
static bool evaluate(void *of) {
  const motion *m = of;
  thrum_state_view *view = m->view;
  const double h = m->state->def.dt;
  const double *d = view->unknown;
  double *total = view->residual;

  // the middle of the step, and what has followed
  for (int64_t i = 0; i < m->masters; i++)
    view->middle[i] = view->q[i] + 0.5 * d[i];
  thrum_follow(&m->follow, view->middle, d, m->moved);
  for (int64_t s = 0; s < m->slaves; s++) {
    m->gained[s] = 2.0 * (m->moved[s] / h - m->before[s]);
    m->image[s] = m->gained[s] + m->damped[s] * m->moved[s];
  }

  // inertia and damping of the masters, then those of the slaves, then the mean force
  damp(m, d);
  for (int64_t i = 0; i < m->masters; i++)
    total[i] = 2.0 * (d[i] / h - view->p[i]) + view->product[i] - h * view->load[i];
  thrum_follow_back(&m->follow, view->middle, m->image, total);
  thrum_average_field_add(m->model, m->state, view, d, total);
  return true;
}

/* The inverse of the Jacobian at the present increment into jacobian_next; false: there is none. */
static bool make_inverse(void *of, thrum_solve_report *report) {
  const motion *m = of;
  thrum_state_view *view = m->view;
  const double h = m->state->def.dt;
  const int64_t k = m->masters;
  double *matrix = view->jacobian_next;
  thrum_tangent_stiffness_by(view->kernel, m->model, view->middle, view->tangent, view->work);
  const double beta = m->state->def.damping_beta;
  const double stiff = 0.5 * h + (thrum_tangent_damped(m->state) ? beta : 0.0);
  for (int64_t n = 0; n < k * k; n++)
    matrix[n] = stiff * view->tangent[n];
  for (int64_t i = 0; i < k; i++)
    matrix[i * k + i] += 2.0 / h + thrum_mass_damping(m->model, m->state, i) +
                         (thrum_tangent_damped(m->state) ? 0.0 : beta * m->model->omega2[i]);

  // the mass of the slaves, and their damping
  thrum_follow_slopes(&m->follow, view->middle, m->slopes);
  for (int64_t s = 0; s < m->slaves; s++) {
    const double *slope = m->slopes + s * k, own = 2.0 / h + m->damped[s];
    for (int64_t i = 0; i < k; i++) {
      const double share = own * slope[i];
      for (int64_t j = 0; j < k; j++)
        matrix[i * k + j] += share * slope[j];
    }
  }
  report->factorisations++;
  report->refreshed = thrum_dense_invert(view->kernel, matrix, (int32_t)k, view->work);
  return report->refreshed;
}

/* Newton's method; the increment stays in view->unknown. */
static thrum_status solve(motion *m, thrum_solve_report *report) {
  const thrum_increment increment = {m->model, m->state,     m->view, TOLERANCE,
                                     evaluate, make_inverse, m};
  thrum_average_field_guess(m->state, m->view);
  return thrum_increment_solve(&increment, m->state->jacobian_kept ? m->view->inverse[0] : NULL,
                               report);
}

/* --- the end of the step ---------------------------------------------------------------------- */

/* v' and u' onto the tangent space at q', into view->p_next; returns their kinetic energies there,
 * doubled. */
static double project(const motion *m) {
  thrum_state_view *view = m->view;
  double *v = view->p_next, *rest = view->velocity, *change = view->kick;
  if (m->slaves == 0)
    return thrum_dense_dot(v, v, m->masters);

  // (1 + J^T J) of the change of v' is J^T of u' - J v'
  thrum_follow(&m->follow, view->q_next, v, m->image);
  for (int64_t s = 0; s < m->slaves; s++)
    m->image[s] = m->before[s] + m->gained[s] - m->image[s];
  memset(rest, 0, (size_t)m->masters * sizeof *rest);
  thrum_follow_back(&m->follow, view->q_next, m->image, rest);
  const double end = PROJECTED * PROJECTED * thrum_dense_dot(v, v, m->masters);
  thrum_follow_solve(&m->follow, NULL, view->q_next, rest, end, view->direction, view->trial,
                     change);
  for (int64_t i = 0; i < m->masters; i++)
    v[i] += change[i];
  thrum_follow(&m->follow, view->q_next, v, m->image);
  return thrum_dense_dot(v, v, m->masters) + thrum_dense_dot(m->image, m->image, m->slaves);
}

/* q' and v' of the increment, with the energy that the balance says. */
static void finish(const motion *m) {
  thrum_state_view *view = m->view;
  const double h = m->state->def.dt;
  double kinetic = 0.0;
  for (int64_t i = 0; i < m->masters; i++) {
    view->q_next[i] = view->q[i] + view->unknown[i];
    view->p_next[i] = 2.0 * view->unknown[i] / h - view->p[i];
    kinetic += view->p_next[i] * view->p_next[i];
  }
  for (int64_t s = 0; s < m->slaves; s++) {
    const double speed = m->before[s] + m->gained[s];
    kinetic += speed * speed;
  }

  // what the solve has left, doubled as the rest, goes as well
  kinetic -= 2.0 * thrum_dense_dot(view->unknown, view->residual, m->masters) / h;
  const double projected = project(m);
  if (!(kinetic > 0.0 && projected > 0.0))
    return;
  const double factor = sqrt(kinetic / projected);
  for (int64_t i = 0; i < m->masters; i++)
    view->p_next[i] *= factor;
}

/* The energy that the damping took, by the increments of all coordinates. */
static double dissipation_of(const motion *m) {
  const thrum_state_view *view = m->view;
  double sum = thrum_dense_dot(view->unknown, view->product, m->masters);
  for (int64_t s = 0; s < m->slaves; s++)
    sum += m->damped[s] * m->moved[s] * m->moved[s];
  return sum / m->state->def.dt;
}

thrum_status thrum_step_manifold(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report) {
  motion m = motion_of(model, state, view);
  thrum_follow(&m.follow, view->q, view->p, m.before);
  THRUM_TRY(solve(&m, report));
  report->dissipation = dissipation_of(&m);
  report->dissipation_known = true;
  report->solved = true;
  finish(&m);
  return thrum_all_finite(view->q_next, state->rank) && thrum_all_finite(view->p_next, state->rank)
             ? THRUM_OK
             : THRUM_NOT_FINITE;
}

/* --- prediction ------------------------------------------------------------------------------- */

bool thrum_manifold_predict(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, const double *load, double *moved,
                            double *answers) {
  const motion m = motion_of(model, state, view);
  const double h = state->def.dt;
  const int64_t k = m.masters;
  double *matrix = view->jacobian_next, *rest = view->residual;

  // h M v + h^2/2 (f - R - J^T 2 Y(v)), with J(v) v = 2 Y(v)
  thrum_follow(&m.follow, view->q, view->p, m.before);
  thrum_follow(&m.follow, view->p, view->p, m.image);
  for (int64_t s = 0; s < m.slaves; s++)
    m.image[s] = h * m.before[s] - 0.5 * h * h * m.image[s];
  for (int64_t i = 0; i < k; i++)
    rest[i] = h * view->p[i] + 0.5 * h * h * ((load ? load[i] : 0.0) - view->force[i]);
  thrum_follow_back(&m.follow, view->q, m.image, rest);

  // (1 + h/2 D) M + (h/2 beta + h^2/4) omega^2, with D = alpha of the masters
  memset(matrix, 0, (size_t)(k * k) * sizeof *matrix);
  thrum_follow_slopes(&m.follow, view->q, m.slopes);
  for (int64_t s = 0; s < m.slaves; s++)
    for (int64_t i = 0; i < k; i++) {
      const double share = (1.0 + 0.5 * h * m.damped[s]) * m.slopes[s * k + i];
      for (int64_t j = 0; j < k; j++)
        matrix[i * k + j] += share * m.slopes[s * k + j];
    }
  for (int64_t i = 0; i < k; i++)
    matrix[i * k + i] += 1.0 + 0.5 * h * thrum_mass_damping(model, state, i) +
                         (0.5 * h * state->def.damping_beta + 0.25 * h * h) * model->omega2[i];

  if (!thrum_dense_invert(view->kernel, matrix, (int32_t)k, view->work))
    return false;
  view->kernel->product(k, k, matrix, rest, moved);
  for (int64_t i = 0; i < k; i++)
    answers[i] = 0.5 * h * h * matrix[i * k + i];
  return true;
}

/* --- its row ---------------------------------------------------------------------------------- */

static void plan(const thrum_model *model, thrum_state *state) {
  state->restricted_count = thrum_manifold_count(model);
  state->tangent_count = model->rank * model->rank;
}

static thrum_mode_factor frequency(const thrum_model *model, const thrum_state *state, int32_t i,
                                   double z) {
  (void)model, (void)state, (void)i;
  return thrum_newmark_factor(z, 0.25, 0.5);
}

const thrum_scheme_row thrum_manifold_scheme = {
    .scheme = THRUM_SCHEME_MANIFOLD,
    .integrator = THRUM_INTEGRATOR_MANIFOLD,
    .form = -1,
    .plan = plan,
    .step = thrum_step_manifold,
    .frequency = frequency,
    .kinetic = thrum_manifold_slave_energy,
};
