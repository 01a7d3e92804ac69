/* The slaves of a condensed model, y = Y(x), quadratic in the masters x (design 16, 17):
 *
 *   J(x) v = sum_ij follow_ij (x_i v_j + v_i x_j) over the pairs,  J(x)^T w = B x with B_ij =
 *   sum_s w_s follow_s,ij
 *
 * so that J is not formed: each is a pass over the slaves x pairs numbers of `follow`.
 *
 * The drag. Damped at rest, a slave takes the force -beta omega_s^2 y'_s, and what follows has
 * y' = J v. Carried to the masters that is -D v with D = beta J^T Omega^2 J, which changes with x.
 * It is a force of the step, constant in it, as the load on a slave is. So that it is stable at any
 * beta, it is the one that the velocity has in the middle of a step that nothing else acts in,
 *
 *   (1 + h/2 D) v-bar = p,   f = -D v-bar
 *
 * By the implicit midpoint rule that step is never longer than 1, and for the trapezoidal rule of a
 * linear mode with c = h D/(1 + h/2 D) < 2 and z = (h omega/2)^2 the map of a step has the
 * determinant 1 - c/(1 + z) and the trace (2 - 2 z - c)/(1 + z): stable for every z and D. f lags
 * by h/2. The slave itself lags by beta behind Y(x), which y' = J v leaves out (condensed_check.c).
 * In tangent form what follows is not damped against the masters: T of the condensed model has it.
 * Cost: four passes, and two more for each iteration but the first, of which there are one or two.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/condensed/following.h"

#include <string.h>

#include "core/linear_algebra/dense.h"
#include "core/polynomial/polynomial_private.h"

#define DRAG_ERROR 1e-4 /* of the drag, left by conjugate gradients */

int64_t thrum_slave_count(const thrum_model *model) {
  return model->follow ? model->shape->rank - model->rank : 0;
}

int64_t thrum_following_count(const thrum_model *model) {
  const int64_t slaves = thrum_slave_count(model);
  return slaves > 0 ? slaves + 2 * thrum_pair_count(model->rank) : 0;
}

int64_t thrum_step_work_count(const thrum_model *model) {
  const int64_t work = (int64_t)thrum_work_count(model);
  const int64_t drag = thrum_following_count(model) + thrum_slave_count(model);
  return work > drag ? work : drag;
}

thrum_following thrum_following_of(const thrum_model *model, const thrum_kernel *kernel,
                                   double *scratch) {
  thrum_following f = {.model = model,
                       .kernel = kernel,
                       .masters = model->rank,
                       .slaves = thrum_slave_count(model),
                       .pairs = thrum_pair_count(model->rank)};
  f.image = scratch;
  f.monomials = f.image + f.slaves;
  f.weights = f.monomials + f.pairs;
  return f;
}

double thrum_slave_omega2(const thrum_model *model, int64_t slave) {
  // a scaled model has the shape of the given one
  const double *shape = model->shape->omega2;
  const int64_t last = model->rank - 1;
  return shape[model->rank + slave] * (model->omega2[last] / shape[last]);
}

/* --- J and its transpose ---------------------------------------------------------------------- */

void thrum_follow(const thrum_following *f, const double *x, const double *v, double *to) {
  if (f->slaves == 0)
    return;
  const double scale = f->model->follow_scale;
  double *pair = f->monomials;
  for (int64_t i = 0; i < f->masters; i++) {
    const double at = scale * x[i], by = scale * v[i];
    for (int64_t j = i; j < f->masters; j++)
      *pair++ = at * v[j] + by * x[j];
  }
  f->kernel->product(f->pairs, f->slaves, f->model->follow_by_pair, f->monomials, to);
}

/* to (masters) += the gradient at x of follow_scale times the sum of row_ij x_i x_j over pairs i <=
 * j, each of which stands once in the row and gives to both of its slopes. */
static void add_slope(const thrum_following *f, const double *row, const double *x, double *to) {
  const double scale = f->model->follow_scale;
  for (int64_t i = 0; i < f->masters; i++) {
    const double at = scale * x[i];
    double sum = 0.0;
    for (int64_t j = i; j < f->masters; j++) {
      sum += row[j - i] * x[j];
      to[j] += row[j - i] * at;
    }
    to[i] += scale * sum;
    row += f->masters - i;
  }
}

void thrum_follow_back(const thrum_following *f, const double *x, const double *what, double *to) {
  if (f->slaves == 0)
    return;
  f->kernel->product(f->slaves, f->pairs, f->model->follow, what, f->weights);
  add_slope(f, f->weights, x, to);
}

void thrum_follow_slopes(const thrum_following *f, const double *x, double *slopes) {
  memset(slopes, 0, (size_t)(f->slaves * f->masters) * sizeof *slopes);
  for (int64_t s = 0; s < f->slaves; s++)
    add_slope(f, f->model->follow + s * f->pairs, x, slopes + s * f->masters);
}

/* --- the linear system ------------------------------------------------------------------------ */

/* to (masters) += J(x)^T W J(x) v. */
static void add_weighted(const thrum_following *f, const double *weight, const double *x,
                         const double *v, double *to) {
  thrum_follow(f, x, v, f->image);
  for (int64_t s = 0; weight && s < f->slaves; s++)
    f->image[s] *= weight[s];
  thrum_follow_back(f, x, f->image, to);
}

void thrum_follow_solve(const thrum_following *f, const double *weight, const double *x,
                        double *rest, double end, double *direction, double *product, double *to) {
  const int64_t k = f->masters;
  memset(to, 0, (size_t)k * sizeof *to);
  memcpy(direction, rest, (size_t)k * sizeof *direction);
  double square = thrum_dense_dot(rest, rest, k);

  // as many iterations as there are masters solve it up to rounding
  for (int64_t n = 0; n < k && square > end; n++) {
    memcpy(product, direction, (size_t)k * sizeof *product);
    add_weighted(f, weight, x, direction, product);
    const double along = square / thrum_dense_dot(direction, product, k);
    for (int64_t i = 0; i < k; i++) {
      to[i] += along * direction[i];
      rest[i] -= along * product[i];
    }
    const double before = square;
    square = thrum_dense_dot(rest, rest, k);
    for (int64_t i = 0; i < k; i++)
      direction[i] = rest[i] + (square / before) * direction[i];
  }
}

/* --- the drag --------------------------------------------------------------------------------- */

bool thrum_follow_is_damped(const thrum_model *model, const thrum_state *state) {
  return thrum_slave_count(model) > 0 && state->def.damping_beta > 0.0 &&
         !thrum_tangent_damped(state) && state->scheme != THRUM_SCHEME_MANIFOLD;
}

void thrum_follow_drag(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       double *force) {
  const thrum_following f = thrum_following_of(model, view->kernel, view->work);
  const double half = 0.5 * state->def.dt;
  double *weight = f.weights + f.pairs, *rest = view->residual;
  for (int64_t s = 0; s < f.slaves; s++)
    weight[s] = half * state->def.damping_beta * thrum_slave_omega2(model, s);

  // what the drag changes of p until the middle, (1 + h/2 D) change = -h/2 D p
  memset(rest, 0, (size_t)f.masters * sizeof *rest);
  add_weighted(&f, weight, view->q, view->p, rest);
  const double end = DRAG_ERROR * DRAG_ERROR * thrum_dense_dot(rest, rest, f.masters);
  thrum_follow_solve(&f, weight, view->q, rest, end, view->direction, view->trial, force);
  for (int64_t i = 0; i < f.masters; i++)
    force[i] *= -1.0 / half;
}

/* --- hooks ------------------------------------------------------------------------------------ */

void thrum_follow_plan(const thrum_model *model, thrum_state *state) {
  const int64_t needed = thrum_step_work_count(model);
  state->work_count = needed > state->work_count ? needed : state->work_count;
  state->ahead_count = thrum_slave_count(model) > 0 ? model->rank : 0;
}

void thrum_follow_load(const thrum_model *model, thrum_step_run *run) {
  thrum_state_view *view = &run->view;
  if (!thrum_follow_is_damped(model, &run->next))
    return;
  thrum_follow_drag(model, &run->next, view, view->load_damped);
  for (int64_t i = 0; i < model->rank; i++)
    view->load_damped[i] += view->load[i];
  view->load = view->load_damped;
}
