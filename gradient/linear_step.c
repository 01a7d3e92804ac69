/* A step to first order (thrum/step_equation.h; design 22).
 *
 * An implicit step is 0 = G(d, q, p, f, D, s), p' = 2 kappa d/h - p, with
 *
 *   dG/dd = J = kappa^2 + h^2/2 A + h/2 nu^2 D,   dG/dq = h^2/2 B,   dG/dp = -h kappa
 *
 * trapezoid  A = 1/2 T' + sigma + d sigma_d^T,  B = 1/2 (T + T') + d sigma_q^T
 *            |d|^2 sigma_d = 1/2 (R' - R) - 1/2 T' d - 2 sigma d
 *            |d|^2 sigma_q = R' - R - 1/2 (T + T') d
 * average    A = 1/3 Tm + 1/6 T',  B = (T + 4 Tm + T')/6
 * midpoint   A = 1/2 Tm,  B = Tm
 *
 * where T' and Tm are T at q' and at q + d/2. With w = J^-T (q_bar' + 2 kappa p_bar'/h) the
 * derivatives by all else are those of -w G. s is a factor of the stiffness: V is linear in it, and
 * with z = (h omega/2)^2 = nu^2 - kappa^2 of a mode whose frequency is matched
 *
 *   d kappa/ds = (kappa - kappa^2 - z)/2,   d nu^2/ds = 2 kappa d kappa/ds + z,
 *
 * which are 0 where kappa = nu = 1. Newmark has the unknown a' and J = 1 + beta h^2 T' + gamma h D;
 * verlet is explicit, and asks T once at each place, where two half kicks meet; the kicks say R.
 * Cost: T and R at one end (the other is that of the step before; the average vector field takes
 * another pair), 2/3 rank^3 for J, and a few products with matrices.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "gradient/linear_step.h"

#include <math.h>
#include <string.h>

#include "gradient/linear_system.h"
#include "thrum/polynomial.h"

#define ROUNDING_SHARE 1e-5 /* as of the step: 1e-16 of V over a residual of 1e-11 */
#define WORK_FACTOR 100.0   /* times the work of the forces up to which V belongs to the step */
#define TOGETHER 1e-9       /* apart by less of their squares: one frequency */

static double dot(const double *a, const double *b, int64_t n) {
  double sum = 0.0;
  for (int64_t i = 0; i < n; i++)
    sum += a[i] * b[i];
  return sum;
}

/* to += by T v, T symmetric */
static void add_product(const double *tangent, double by, const double *v, int64_t n,
                        double *restrict to) {
  for (int64_t j = 0; j < n; j++) {
    const double *row = tangent + j * n, times = by * v[j];
    for (int64_t i = 0; i < n; i++)
      to[i] += times * row[i];
  }
}

static bool has_middle(thrum_step_form form) {
  return form == THRUM_STEP_AVERAGE || form == THRUM_STEP_MIDPOINT;
}

/* --- at the ends ------------------------------------------------------------------------------ */

void thrum_linear_step_evaluate(thrum_linear_step *step, const double *q, thrum_step_place *place) {
  const thrum_step_form form = step->equation.form;
  if (form == THRUM_STEP_MIDPOINT || form == THRUM_STEP_VERLET)
    return;
  place->potential =
      thrum_internal_force_tangent(step->model, q, place->force, place->tangent, step->work);
}

void thrum_linear_step_turn(thrum_linear_step *step) {
  const thrum_step_place kept = step->start;
  step->start = step->end;
  step->end = kept;
}

/* --- the Jacobian ----------------------------------------------------------------------------- */

/* sigma of the trapezoidal discrete gradient, 0 where the difference of the energies is rounding,
 * as the step takes it to be. */
static double sigma_of(const thrum_linear_step *step, double square) {
  const double *r = step->start.force, *r_next = step->end.force, h = step->equation.dt;
  const double v = step->start.potential, v_next = step->end.potential;
  double work = 0.0, moved = 0.0;
  for (int64_t i = 0; i < step->rank; i++) {
    work += 0.5 * (r[i] + r_next[i]) * step->d[i];
    moved += (fabs(r[i]) + fabs(r_next[i])) * fabs(step->d[i]);
  }
  const double still = fabs(v) + fabs(v_next) - WORK_FACTOR * moved;
  return ROUNDING_SHARE * 0.5 * h * h * still > square ? 0.0 : (v_next - v - work) / square;
}

/* A into the Jacobian, M into `mean`, and the derivatives of sigma. */
static void put_trapezoid(thrum_linear_step *step) {
  const int64_t n = step->rank, count = n * n;
  const double *d = step->d, *r = step->start.force, *r_next = step->end.force;
  const double square = dot(d, d, n), inverse = square > 0.0 ? 1.0 / square : 0.0;
  const double sigma = square > 0.0 ? sigma_of(step, square) : 0.0;
  step->has_sigma = sigma != 0.0;

  // x = 1/2 T d and y = 1/2 T' d
  memset(step->x, 0, (size_t)n * sizeof(double));
  memset(step->y, 0, (size_t)n * sizeof(double));
  add_product(step->start.tangent, 0.5, d, n, step->x);
  add_product(step->end.tangent, 0.5, d, n, step->y);

  // without sigma in the step it has no derivatives
  const double by = sigma != 0.0 ? inverse : 0.0;
  for (int64_t i = 0; i < n; i++) {
    const double more = r_next[i] - r[i];
    step->mean[i] = 0.5 * (r[i] + r_next[i]) + sigma * d[i];
    step->sigma_d[i] = by * (0.5 * more - step->y[i] - 2.0 * sigma * d[i]);
    step->sigma_q[i] = by * (more - step->x[i] - step->y[i]);
  }

  for (int64_t a = 0; a < count; a++)
    step->jacobian[a] = 0.5 * step->end.tangent[a];
  for (int64_t i = 0; i < n; i++) {
    step->jacobian[i * n + i] += sigma;
    for (int64_t j = 0; j < n; j++)
      step->jacobian[i * n + j] += d[i] * step->sigma_d[j];
  }
}

static void put_middle(thrum_linear_step *step, const double *q) {
  const int64_t n = step->rank, count = n * n;
  for (int64_t i = 0; i < n; i++)
    step->x[i] = q[i] + 0.5 * step->d[i];
  thrum_internal_force_tangent(step->model, step->x, step->middle.force, step->middle.tangent,
                               step->work);

  const double *middle = step->middle.tangent;
  if (step->equation.form == THRUM_STEP_MIDPOINT) {
    memcpy(step->mean, step->middle.force, (size_t)n * sizeof(double));
    for (int64_t a = 0; a < count; a++)
      step->jacobian[a] = 0.5 * middle[a];
    return;
  }
  for (int64_t i = 0; i < n; i++)
    step->mean[i] = (step->start.force[i] + 4.0 * step->middle.force[i] + step->end.force[i]) / 6.0;
  for (int64_t a = 0; a < count; a++)
    step->jacobian[a] = middle[a] / 3.0 + step->end.tangent[a] / 6.0;
}

/* J from A. */
static void finish_jacobian(thrum_linear_step *step) {
  const thrum_step_equation *e = &step->equation;
  const int64_t n = step->rank;
  double scale = 0.5 * e->dt * e->dt;
  if (e->form == THRUM_STEP_NEWMARK)
    scale = e->newmark_beta * e->dt * e->dt;
  for (int64_t a = 0; a < n * n; a++)
    step->jacobian[a] *= scale;

  for (int64_t i = 0; i < n; i++) {
    const double kappa = step->kappa[i], nu = step->nu[i], damping = step->damping[i];
    step->jacobian[i * n + i] += e->form == THRUM_STEP_NEWMARK
                                     ? 1.0 + e->newmark_gamma * e->dt * damping
                                     : kappa * kappa + 0.5 * e->dt * nu * nu * damping;
  }
}

/* R at both ends of a step of verlet, of what changed its momenta. */
static void put_verlet_forces(thrum_linear_step *step, const thrum_made_step *made) {
  const double h = step->equation.dt;
  for (int64_t i = 0; i < step->rank; i++) {
    const double more = 0.5 * h * step->damping[i], before = made->force_before[i];
    const double load = before + (made->force[i] - before) / (1.0 + more);
    step->start.force[i] = 2.0 / h * ((1.0 - more) * made->p[i] - made->half[i]) + load;
    step->end.force[i] =
        2.0 / h * (made->half[i] - (1.0 + more) * made->p_next[i]) + made->force[i];
  }
}

bool thrum_linear_step_factor(thrum_linear_step *step, const thrum_made_step *made) {
  const int64_t n = step->rank;
  const thrum_step_form form = step->equation.form;
  if (form == THRUM_STEP_VERLET) {
    put_verlet_forces(step, made);
    return true;
  }

  for (int64_t i = 0; i < n; i++)
    step->d[i] = made->q_next[i] - made->q[i];
  if (form == THRUM_STEP_TRAPEZOID)
    put_trapezoid(step);
  else if (has_middle(form))
    put_middle(step, made->q);
  else
    memcpy(step->jacobian, step->end.tangent, (size_t)(n * n) * sizeof(double));
  finish_jacobian(step);
  return thrum_linear_factor(step->jacobian, n, step->rows);
}

/* --- parts of the energy ---------------------------------------------------------------------- */

/* The change of a function f of K with K: that of entry i, j is slope_ij times that of K (Daleckii
 * & Krein 1965), slope_ij = (f_i - f_j)/(omega_i^2 - omega_j^2), and f' on the diagonal. */
static void put_slopes(const thrum_linear_step *step, const double *values, const double *slopes,
                       double *to) {
  const int64_t n = step->rank;
  const double *omega2 = step->model->omega2;
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < n; j++) {
      const double apart = omega2[i] - omega2[j];
      const bool together = fabs(apart) <= TOGETHER * (omega2[i] + omega2[j]);
      to[i * n + j] = together ? 0.5 * (slopes[i] + slopes[j]) : (values[i] - values[j]) / apart;
    }
}

static double kappa_change(const thrum_linear_step *step, int64_t i);
static double nu_square_change(const thrum_linear_step *step, int64_t i);

void thrum_linear_step_prepare_parts(thrum_linear_step *step) {
  const int64_t n = step->rank;
  const double beta = step->equation.damping_beta, *omega2 = step->model->omega2;
  double *f = step->part_y, *slope = step->part_kappa;
  for (int64_t i = 0; i < n; i++) {
    f[i] = step->kappa[i];
    slope[i] = omega2[i] > 0.0 ? kappa_change(step, i) / omega2[i] : 0.0;
  }
  put_slopes(step, f, slope, step->slope_kappa);
  for (int64_t i = 0; i < n; i++) {
    slope[i] *= 2.0 * f[i];
    f[i] *= f[i];
  }
  put_slopes(step, f, slope, step->slope_kappa_square);
  for (int64_t i = 0; i < n; i++) {
    const double square = step->nu[i] * step->nu[i];
    const double change = omega2[i] > 0.0 ? nu_square_change(step, i) / omega2[i] : 0.0;
    f[i] = square * step->damping[i];
    slope[i] = square * beta + change * step->damping[i];
  }
  put_slopes(step, f, slope, step->slope_damped);
  for (int64_t i = 0; i < n; i++)
    slope[i] = beta;
  put_slopes(step, step->damping, slope, step->slope_damping);
}

/* to_i += by sum_j slope_ij L_ij v_j */
static void add_slope(const thrum_linear_step *step, const thrum_energy_part *part,
                      const double *slope, double by, const double *v, double *to) {
  const int64_t n = step->rank;
  for (int64_t i = 0; i < n; i++) {
    double sum = 0.0;
    for (int64_t j = 0; j < n; j++)
      sum += slope[i * n + j] * part->linear[i * n + j] * v[j];
    to[i] += by * sum;
  }
}

/* The force of a part into `force`; returns its energy. */
static double part_force(const thrum_linear_step *step, const thrum_energy_part *part,
                         const double *q, double *force) {
  const int64_t n = step->rank;
  double energy = 0.0;
  memset(force, 0, (size_t)n * sizeof *force);
  if (part->form)
    energy = thrum_internal_force(part->form, q, force, step->work);
  for (int64_t i = 0; i < n; i++) {
    const double linear = dot(part->linear + i * n, q, n);
    force[i] += linear;
    energy += 0.5 * linear * q[i];
  }
  return energy;
}

/* The change of G with a part into part_y, that of kappa d into part_kappa. */
static void put_part(const thrum_linear_step *step, const thrum_made_step *made,
                     const thrum_energy_part *part) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, *d = step->d;
  double *start = step->part_start, *end = step->part_end, *middle = step->part_middle;
  double *y = step->part_y;
  const thrum_step_form form = step->equation.form;
  double v = 0.0, v_next = 0.0;
  if (form != THRUM_STEP_MIDPOINT) {
    v = part_force(step, part, made->q, start);
    v_next = part_force(step, part, made->q_next, end);
  }

  // the mean force
  if (has_middle(form)) {
    for (int64_t i = 0; i < n; i++)
      y[i] = made->q[i] + 0.5 * d[i];
    part_force(step, part, y, middle);
  }
  double sigma = 0.0;
  if (form == THRUM_STEP_TRAPEZOID && step->has_sigma)
    sigma = (v_next - v - 0.5 * (dot(start, d, n) + dot(end, d, n))) / dot(d, d, n);
  for (int64_t i = 0; i < n; i++) {
    const double mean = form == THRUM_STEP_TRAPEZOID  ? 0.5 * (start[i] + end[i]) + sigma * d[i]
                        : form == THRUM_STEP_MIDPOINT ? middle[i]
                                                      : (start[i] + 4.0 * middle[i] + end[i]) / 6.0;
    y[i] = 0.5 * h * h * mean;
    step->part_kappa[i] = 0.0;
  }

  // kappa and nu follow the frequencies, and D
  add_slope(step, part, step->slope_kappa_square, 1.0, d, y);
  add_slope(step, part, step->slope_kappa, -h, made->p, y);
  add_slope(step, part, step->slope_damped, 0.5 * h, d, y);
  add_slope(step, part, step->slope_kappa, 1.0, d, step->part_kappa);
}

/* The same of the forces at both ends, into part_start and part_end. */
static void put_part_ends(const thrum_linear_step *step, const thrum_made_step *made,
                          const thrum_energy_part *part) {
  part_force(step, part, made->q, step->part_start);
  part_force(step, part, made->q_next, step->part_end);
  add_slope(step, part, step->slope_damping, 1.0, made->p, step->part_start);
  add_slope(step, part, step->slope_damping, 1.0, made->p_next, step->part_end);
  if (step->equation.form != THRUM_STEP_VERLET)
    return;

  // a load that jumps is divided by 1 + h/2 D
  const int64_t n = step->rank;
  const double half = 0.5 * step->equation.dt;
  double *jump = step->part_kappa, *y = step->part_y;
  for (int64_t i = 0; i < n; i++) {
    jump[i] = (made->force[i] - made->force_before[i]) / (1.0 + half * step->damping[i]);
    y[i] = 0.0;
  }
  add_slope(step, part, step->slope_damping, half, jump, y);
  for (int64_t i = 0; i < n; i++)
    step->part_start[i] += y[i] / (1.0 + half * step->damping[i]);
}

/* --- the implicit steps ----------------------------------------------------------------------- */

/* to += by B v, or of the transpose. */
static void add_by_start(const thrum_linear_step *step, double by, const double *v, bool transposed,
                         double *to) {
  const int64_t n = step->rank;
  const double *tangent = step->start.tangent, *tangent_next = step->end.tangent;
  if (step->equation.form == THRUM_STEP_MIDPOINT) {
    add_product(step->middle.tangent, by, v, n, to);
    return;
  }
  if (step->equation.form == THRUM_STEP_AVERAGE) {
    add_product(tangent, by / 6.0, v, n, to);
    add_product(step->middle.tangent, by * (2.0 / 3.0), v, n, to);
    add_product(tangent_next, by / 6.0, v, n, to);
    return;
  }
  add_product(tangent, 0.5 * by, v, n, to);
  add_product(tangent_next, 0.5 * by, v, n, to);
  const double *left = transposed ? step->sigma_q : step->d;
  const double along = by * dot(transposed ? step->d : step->sigma_q, v, n);
  for (int64_t i = 0; i < n; i++)
    to[i] += along * left[i];
}

/* kappa and nu^2 of a mode by a factor of omega^2. */
static double kappa_change(const thrum_linear_step *step, int64_t i) {
  const double kappa = step->kappa[i], nu = step->nu[i];
  const double z = nu * nu - kappa * kappa;
  return 0.5 * (kappa - kappa * kappa - z);
}

static double nu_square_change(const thrum_linear_step *step, int64_t i) {
  const double kappa = step->kappa[i], nu = step->nu[i];
  return 2.0 * kappa * kappa_change(step, i) + (nu * nu - kappa * kappa);
}

static void pull_implicit(const thrum_linear_step *step, const thrum_made_step *made,
                          thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, *d = step->d, *w = step->w;
  double *q = change->q, *p = change->p;
  for (int64_t i = 0; i < n; i++)
    step->w[i] = q[i] + 2.0 * step->kappa[i] / h * p[i];
  thrum_linear_solve_transposed(step->jacobian, n, step->rows, step->w);
  for (int64_t g = 0; g < change->part_count; g++) {
    put_part(step, made, change->parts + g);
    change->part[g] += 2.0 / h * dot(p, step->part_kappa, n) - dot(w, step->part_y, n);
  }

  // what the equation depends on beside q
  for (int64_t i = 0; i < n; i++) {
    const double kappa = step->kappa[i], square = step->nu[i] * step->nu[i];
    const double in_kappa = 2.0 * kappa * d[i] - h * made->p[i];
    const double in_square = 0.5 * h * step->damping[i] * d[i];
    change->force[i] = 0.5 * h * h * w[i];
    change->force_before[i] = 0.0;
    change->damping[i] -= 0.5 * h * square * d[i] * w[i];
    change->stiffness +=
        kappa_change(step, i) * (2.0 / h * d[i] * p[i] - in_kappa * w[i]) -
        w[i] * (0.5 * h * h * step->mean[i] + nu_square_change(step, i) * in_square);
    p[i] = h * kappa * w[i] - p[i];
  }
  add_by_start(step, -0.5 * h * h, w, true, q);
}

static void push_implicit(const thrum_linear_step *step, const thrum_made_step *made,
                          thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, *d = step->d, s = change->stiffness;
  double *q = change->q, *p = change->p;
  for (int64_t i = 0; i < n; i++) {
    const double kappa = step->kappa[i], square = step->nu[i] * step->nu[i];
    const double in_kappa = 2.0 * kappa * d[i] - h * made->p[i];
    const double in_square = 0.5 * h * step->damping[i] * d[i];
    step->w[i] = h * kappa * p[i] + 0.5 * h * h * change->force[i] -
                 0.5 * h * square * d[i] * change->damping[i] -
                 s * (0.5 * h * h * step->mean[i] + kappa_change(step, i) * in_kappa +
                      nu_square_change(step, i) * in_square);
  }
  add_by_start(step, -0.5 * h * h, q, false, step->w);

  // that of kappa d by the parts, times 2/h, comes to p' in the end
  memset(step->x, 0, (size_t)n * sizeof(double));
  for (int64_t g = 0; g < change->part_count; g++) {
    put_part(step, made, change->parts + g);
    for (int64_t i = 0; i < n; i++) {
      step->w[i] -= change->part[g] * step->part_y[i];
      step->x[i] += change->part[g] * step->part_kappa[i];
    }
  }
  thrum_linear_solve(step->jacobian, n, step->rows, step->w);

  for (int64_t i = 0; i < n; i++) {
    const double by = 2.0 / h;
    q[i] += step->w[i];
    p[i] =
        by * (step->kappa[i] * step->w[i] + s * kappa_change(step, i) * d[i] + step->x[i]) - p[i];
  }
}

/* --- newmark ---------------------------------------------------------------------------------- */

static void pull_newmark(const thrum_linear_step *step, const thrum_made_step *made,
                         thrum_step_change *change) {
  const thrum_step_equation *e = &step->equation;
  const int64_t n = step->rank;
  const double h = e->dt, *w = step->w, *damping = step->damping;
  double *q = change->q, *p = change->p, *a = step->x;
  for (int64_t i = 0; i < n; i++)
    step->w[i] = h * (e->newmark_beta * h * q[i] + e->newmark_gamma * p[i]);
  thrum_linear_solve_transposed(step->jacobian, n, step->rows, step->w);

  // q', p' and the acceleration a without a'
  add_product(step->end.tangent, -1.0, w, n, q);
  for (int64_t i = 0; i < n; i++) {
    p[i] -= damping[i] * w[i];
    a[i] = h * (h * (0.5 - e->newmark_beta) * q[i] + (1.0 - e->newmark_gamma) * p[i]);
    change->force[i] = w[i] + a[i];
    change->force_before[i] = 0.0;
    change->damping[i] -= w[i] * made->p_next[i] + a[i] * made->p[i];
    change->stiffness -= w[i] * step->end.force[i] + a[i] * step->start.force[i];
    p[i] += h * q[i] - damping[i] * a[i];
  }
  add_product(step->start.tangent, -1.0, a, n, q);
  for (int64_t g = 0; g < change->part_count; g++) {
    put_part_ends(step, made, change->parts + g);
    change->part[g] -= dot(w, step->part_end, n) + dot(a, step->part_start, n);
  }
}

/* y = - sum of the changes of the force at one end by the parts. */
static void put_part_sum(const thrum_linear_step *step, const thrum_made_step *made,
                         const thrum_step_change *change, bool at_end) {
  memset(step->y, 0, (size_t)step->rank * sizeof(double));
  for (int64_t g = 0; g < change->part_count; g++) {
    put_part_ends(step, made, change->parts + g);
    const double *end = at_end ? step->part_end : step->part_start;
    for (int64_t i = 0; i < step->rank; i++)
      step->y[i] -= change->part[g] * end[i];
  }
}

static void push_newmark(const thrum_linear_step *step, const thrum_made_step *made,
                         thrum_step_change *change) {
  const thrum_step_equation *e = &step->equation;
  const int64_t n = step->rank;
  const double h = e->dt, s = change->stiffness, *damping = step->damping;
  double *q = change->q, *p = change->p, *a = step->x, *w = step->w;

  // a, then q' and p' without a'
  put_part_sum(step, made, change, false);
  for (int64_t i = 0; i < n; i++)
    a[i] = step->y[i] + change->force[i] - damping[i] * p[i] - change->damping[i] * made->p[i] -
           s * step->start.force[i];
  add_product(step->start.tangent, -1.0, q, n, a);
  put_part_sum(step, made, change, true);
  for (int64_t i = 0; i < n; i++) {
    q[i] += h * p[i] + h * h * (0.5 - e->newmark_beta) * a[i];
    p[i] += h * (1.0 - e->newmark_gamma) * a[i];
    w[i] = step->y[i] + change->force[i] - damping[i] * p[i] -
           change->damping[i] * made->p_next[i] - s * step->end.force[i];
  }
  add_product(step->end.tangent, -1.0, q, n, w);
  thrum_linear_solve(step->jacobian, n, step->rows, w);
  for (int64_t i = 0; i < n; i++) {
    q[i] += e->newmark_beta * h * h * w[i];
    p[i] += e->newmark_gamma * h * w[i];
  }
}

/* --- verlet ----------------------------------------------------------------------------------- */

static void pull_verlet(const thrum_linear_step *step, const thrum_made_step *made,
                        thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt;
  double *q = change->q, *p = change->p, *last = step->w, *kicked = step->x, *product = step->y;

  // the half kick at the end, and that of the step after, at the same place
  for (int64_t i = 0; i < n; i++) {
    last[i] = p[i] / (1.0 + 0.5 * h * step->damping[i]);
    kicked[i] = last[i] + step->kept[i];
  }
  thrum_tangent_product(step->model, made->q_next, kicked, product, step->work);

  // the drift, and the half kick at the start
  for (int64_t i = 0; i < n; i++) {
    const double more = 0.5 * h * step->damping[i], c = 1.0 + more;
    const double jump = made->force[i] - made->force_before[i];
    q[i] -= 0.5 * h * product[i];
    kicked[i] = last[i] + h * q[i];
    change->force[i] = 0.5 * h * (last[i] + kicked[i] / c);
    change->force_before[i] = 0.5 * h * kicked[i] * more / c;
    change->damping[i] -=
        0.5 * h * (last[i] * made->p_next[i] + kicked[i] * (made->p[i] + 0.5 * h * jump / (c * c)));
    change->stiffness -=
        0.5 * h * (last[i] * step->end.force[i] + kicked[i] * step->start.force[i]);
    p[i] = (1.0 - more) * kicked[i];
  }
  memcpy(step->kept, kicked, (size_t)n * sizeof *kicked);
  for (int64_t g = 0; g < change->part_count; g++) {
    put_part_ends(step, made, change->parts + g);
    change->part[g] -= 0.5 * h * (dot(last, step->part_end, n) + dot(kicked, step->part_start, n));
  }
}

void thrum_linear_step_end_pull(const thrum_linear_step *step, const double *q,
                                thrum_step_change *change) {
  if (step->equation.form != THRUM_STEP_VERLET)
    return;
  thrum_tangent_product(step->model, q, step->kept, step->y, step->work);
  for (int64_t i = 0; i < step->rank; i++)
    change->q[i] -= 0.5 * step->equation.dt * step->y[i];
}

void thrum_linear_step_begin_push(const thrum_linear_step *step, const double *q,
                                  const thrum_step_change *change) {
  if (step->equation.form == THRUM_STEP_VERLET)
    thrum_tangent_product(step->model, q, change->q, step->kept, step->work);
}

static void push_verlet(const thrum_linear_step *step, const thrum_made_step *made,
                        thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, s = change->stiffness;
  double *q = change->q, *p = change->p, *kicked = step->x, *product = step->kept;
  put_part_sum(step, made, change, false);
  for (int64_t i = 0; i < n; i++) {
    const double more = 0.5 * h * step->damping[i], c = 1.0 + more;
    const double jump = made->force[i] - made->force_before[i];
    const double load = (change->force[i] + more * change->force_before[i]) / c;
    kicked[i] =
        (1.0 - more) * p[i] + 0.5 * h *
                                  (step->y[i] + load - product[i] - s * step->start.force[i] -
                                   change->damping[i] * (made->p[i] + 0.5 * h * jump / (c * c)));
    q[i] += h * kicked[i];
  }
  thrum_tangent_product(step->model, made->q_next, q, product, step->work);
  put_part_sum(step, made, change, true);
  for (int64_t i = 0; i < n; i++)
    p[i] = (kicked[i] + 0.5 * h *
                            (step->y[i] + change->force[i] - product[i] - s * step->end.force[i] -
                             change->damping[i] * made->p_next[i])) /
           (1.0 + 0.5 * h * step->damping[i]);
}

/* --- any -------------------------------------------------------------------------------------- */

void thrum_linear_step_pull(const thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change) {
  if (step->equation.form == THRUM_STEP_NEWMARK)
    pull_newmark(step, made, change);
  else if (step->equation.form == THRUM_STEP_VERLET)
    pull_verlet(step, made, change);
  else
    pull_implicit(step, made, change);
}

void thrum_linear_step_push(const thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change) {
  if (step->equation.form == THRUM_STEP_NEWMARK)
    push_newmark(step, made, change);
  else if (step->equation.form == THRUM_STEP_VERLET)
    push_verlet(step, made, change);
  else
    push_implicit(step, made, change);
}
