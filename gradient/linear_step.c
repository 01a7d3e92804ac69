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
#include "thrum/actuation.h"
#include "thrum/polynomial.h"

#define ROUNDING_SHARE 1e-5 /* as of the step: 1e-16 of V over a residual of 1e-11 */
#define WORK_FACTOR 100.0   /* times the work of the forces up to which V belongs to the step */
#define SCALE_MOST 0.5      /* of the step: energy missed over the kinetic energy that takes it */
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

/* Is p' scaled by the energy that Simpson's rule misses? */
static bool is_scaled(const thrum_linear_step *step) {
  return step->inexact && step->equation.form == THRUM_STEP_AVERAGE;
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

/* The energy that Simpson's rule misses, V - V' + M d, its derivatives by d and by q, and the
 * factor of p' that gives it back. */
static void put_missed(thrum_linear_step *step, const thrum_made_step *made) {
  const int64_t n = step->rank;
  const double *d = step->d, *r = step->start.force, *r_next = step->end.force;
  const double h = step->equation.dt;
  double *by_d = step->sigma_d, *by_q = step->sigma_q;
  for (int64_t i = 0; i < n; i++) {
    step->unscaled[i] = 2.0 / h * step->kappa[i] * d[i] - made->p[i];
    by_d[i] = step->mean[i] - r_next[i];
    by_q[i] = r[i] - r_next[i];
  }
  add_product(step->middle.tangent, 1.0 / 3.0, d, n, by_d);
  add_product(step->end.tangent, 1.0 / 6.0, d, n, by_d);
  add_product(step->start.tangent, 1.0 / 6.0, d, n, by_q);
  add_product(step->middle.tangent, 2.0 / 3.0, d, n, by_q);
  add_product(step->end.tangent, 1.0 / 6.0, d, n, by_q);

  // at a standstill there is nothing to scale
  step->missed = step->start.potential - step->end.potential + dot(step->mean, d, n);
  step->square = dot(step->unscaled, step->unscaled, n);
  const double share = 2.0 * step->missed / step->square;
  step->scale = fabs(share) < SCALE_MOST ? sqrt(1.0 + share) : 1.0;
  if (fabs(share) < SCALE_MOST)
    return;
  step->square = 1.0;
  step->missed = 0.0;
  memset(by_d, 0, (size_t)n * sizeof *by_d);
  memset(by_q, 0, (size_t)n * sizeof *by_q);
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
  if (is_scaled(step))
    put_missed(step, made);
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

void thrum_linear_step_prepare_parts(thrum_linear_step *step) {
  const int64_t n = step->rank;
  const double beta = step->equation.damping_beta, *omega2 = step->model->omega2;
  double *f = step->part_y, *slope = step->part_kappa;
  for (int64_t i = 0; i < n; i++) {
    f[i] = step->kappa[i];
    slope[i] = omega2[i] > 0.0 ? thrum_linear_step_kappa(step, i) / omega2[i] : 0.0;
  }
  put_slopes(step, f, slope, step->slope_kappa);
  for (int64_t i = 0; i < n; i++) {
    slope[i] *= 2.0 * f[i];
    f[i] *= f[i];
  }
  put_slopes(step, f, slope, step->slope_kappa_square);
  for (int64_t i = 0; i < n; i++) {
    const double square = step->nu[i] * step->nu[i];
    const double change = omega2[i] > 0.0 ? thrum_linear_step_nu(step, i) / omega2[i] : 0.0;
    f[i] = square * step->damping[i];
    slope[i] = square * beta + change * step->damping[i];
  }
  put_slopes(step, f, slope, step->slope_damped);
  for (int64_t i = 0; i < n; i++)
    slope[i] = beta;
  put_slopes(step, step->damping, slope, step->slope_damping);
}

/* What adds a share to the energy: a part, or with none an actuator, by its level, or a gas, by a
 * factor. */
typedef struct share {
  const thrum_energy_part *part;
  int64_t actuator;
  bool gas;
} share;

/* to_i += by sum_j slope_ij L_ij v_j; what acts changes no frequency at rest. */
static void add_slope(const thrum_linear_step *step, const share *of, const double *slope,
                      double by, const double *v, double *to) {
  const int64_t n = step->rank;
  for (int64_t i = 0; of->part && i < n; i++) {
    double sum = 0.0;
    for (int64_t j = 0; j < n; j++)
      sum += slope[i * n + j] * of->part->linear[i * n + j] * v[j];
    to[i] += by * sum;
  }
}

/* The force of an actuator into `force`: of its level -grad P; of the whole energy p m - (p + a) P
 * of a gas, with m = V0 (exp(P/V0) - 1), (p m/V0 - a) grad P. Returns the energy. */
static double actuator_force(const thrum_linear_step *step, const share *of, const double *q,
                             double *force) {
  const thrum_model *model = step->model;
  double work = NAN, energy = NAN, by = NAN;
  memset(force, 0, (size_t)step->rank * sizeof *force);
  const thrum_status status =
      thrum_model_actuation_force(model, of->actuator, q, force, &work, NULL);
  if (status >= 0 && !of->gas) {
    energy = -work;
    by = -1.0;
  } else if (status >= 0) {
    const double *rest = model->actuator_rest + 3 * of->actuator;
    const double grown = expm1(work / rest[0]), level = model->levels[of->actuator];
    energy = rest[1] * rest[0] * grown - (rest[1] + level) * work;
    by = rest[1] * grown - level;
  }
  for (int64_t i = 0; i < step->rank; i++)
    force[i] *= by;
  return energy;
}

/* The force of a share of 1 into `force`; returns its energy. */
static double share_force(const thrum_linear_step *step, const share *of, const double *q,
                          double *force) {
  const int64_t n = step->rank;
  const thrum_energy_part *part = of->part;
  if (!part)
    return actuator_force(step, of, q, force);
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

/* The change of G with a share into part_y, that of kappa d into part_kappa. */
static void put_share(thrum_linear_step *step, const thrum_made_step *made, const share *of) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, *d = step->d;
  double *start = step->part_start, *end = step->part_end, *middle = step->part_middle;
  double *y = step->part_y;
  const thrum_step_form form = step->equation.form;
  double v = 0.0, v_next = 0.0;
  if (form != THRUM_STEP_MIDPOINT) {
    v = share_force(step, of, made->q, start);
    v_next = share_force(step, of, made->q_next, end);
  }

  // the mean force
  if (has_middle(form)) {
    for (int64_t i = 0; i < n; i++)
      y[i] = made->q[i] + 0.5 * d[i];
    share_force(step, of, y, middle);
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
  step->part_missed = v - v_next + 2.0 / (h * h) * dot(y, d, n);

  // kappa and nu follow the frequencies, and D
  add_slope(step, of, step->slope_kappa_square, 1.0, d, y);
  add_slope(step, of, step->slope_kappa, -h, made->p, y);
  add_slope(step, of, step->slope_damped, 0.5 * h, d, y);
  add_slope(step, of, step->slope_kappa, 1.0, d, step->part_kappa);
}

/* The same of the forces at both ends, into part_start and part_end. */
static void put_share_ends(const thrum_linear_step *step, const thrum_made_step *made,
                           const share *of) {
  share_force(step, of, made->q, step->part_start);
  share_force(step, of, made->q_next, step->part_end);
  add_slope(step, of, step->slope_damping, 1.0, made->p, step->part_start);
  add_slope(step, of, step->slope_damping, 1.0, made->p_next, step->part_end);
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
  add_slope(step, of, step->slope_damping, half, jump, y);
  for (int64_t i = 0; i < n; i++)
    step->part_start[i] += y[i] / (1.0 + half * step->damping[i]);
}

/* All that has a share: parts, levels, and the factor of all gases, of each of which it is one. */
static int64_t share_count(const thrum_linear_step *step, const thrum_step_change *change) {
  return change->part_count + 2 * step->actuators;
}

/* Share g, and where its derivative or direction is; NULL: it is none. */
static double *share_at(const thrum_linear_step *step, thrum_step_change *change, int64_t g,
                        share *of) {
  const int64_t actuator = g - change->part_count;
  *of = (share){.actuator = actuator};
  if (actuator < 0) {
    of->part = change->parts + g;
    return change->part + g;
  }
  if (actuator < step->actuators)
    return change->level + actuator;
  of->actuator -= step->actuators;
  of->gas = true;
  return step->model->actuator_kind[of->actuator] == THRUM_ACTUATOR_GAS ? &change->gas : NULL;
}

/* The next share that is one, from *next on; NULL: there is none left. */
static double *next_share(const thrum_linear_step *step, thrum_step_change *change, int64_t *next,
                          share *of) {
  double *found = NULL;
  while (!found && *next < share_count(step, change))
    found = share_at(step, change, (*next)++, of);
  return found;
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

double thrum_linear_step_kappa(const thrum_linear_step *step, int64_t i) {
  const double kappa = step->kappa[i], nu = step->nu[i];
  const double z = nu * nu - kappa * kappa;
  return 0.5 * (kappa - kappa * kappa - z);
}

double thrum_linear_step_nu(const thrum_linear_step *step, int64_t i) {
  const double kappa = step->kappa[i], nu = step->nu[i];
  return 2.0 * kappa * thrum_linear_step_kappa(step, i) + (nu * nu - kappa * kappa);
}

/* From the derivative by p' to that by the p' before it is scaled; returns that by the energy
 * missed. */
static double pull_scale(const thrum_linear_step *step, double *p) {
  if (!is_scaled(step))
    return 0.0;
  const int64_t n = step->rank;
  const double along = dot(step->unscaled, p, n) / (step->scale * step->square);
  for (int64_t i = 0; i < n; i++)
    p[i] = step->scale * p[i] - 2.0 * step->missed / step->square * along * step->unscaled[i];
  return along;
}

/* The change of p' from that before it is scaled, and of the energy missed. */
static void push_scale(const thrum_linear_step *step, double missed, double *p) {
  const int64_t n = step->rank;
  const double along = 2.0 * step->missed / step->square * dot(step->unscaled, p, n);
  const double by = (missed - along) / (step->scale * step->square);
  for (int64_t i = 0; i < n; i++)
    p[i] = step->scale * p[i] + by * step->unscaled[i];
}

static void pull_implicit(thrum_linear_step *step, const thrum_made_step *made,
                          thrum_step_change *change) {
  const int64_t n = step->rank;
  const double h = step->equation.dt, *d = step->d, *w = step->w;
  double *q = change->q, *p = change->p;
  const double missed = pull_scale(step, p);
  for (int64_t i = 0; i < n; i++)
    step->w[i] = q[i] + 2.0 * step->kappa[i] / h * p[i];
  for (int64_t i = 0; missed != 0.0 && i < n; i++) {
    step->w[i] += missed * step->sigma_d[i];
    q[i] += missed * step->sigma_q[i];
  }
  change->stiffness += missed != 0.0 ? missed * step->missed : 0.0;
  thrum_linear_solve_transposed(step->jacobian, n, step->rows, step->w);
  share of;
  double *to;
  for (int64_t next = 0; (to = next_share(step, change, &next, &of)) != NULL;) {
    put_share(step, made, &of);
    *to += 2.0 / h * dot(p, step->part_kappa, n) - dot(w, step->part_y, n) +
           missed * step->part_missed;
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
        thrum_linear_step_kappa(step, i) * (2.0 / h * d[i] * p[i] - in_kappa * w[i]) -
        w[i] * (0.5 * h * h * step->mean[i] + thrum_linear_step_nu(step, i) * in_square);
    p[i] = h * kappa * w[i] - p[i];
  }
  add_by_start(step, -0.5 * h * h, w, true, q);
}

static void push_implicit(thrum_linear_step *step, const thrum_made_step *made,
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
                 s * (0.5 * h * h * step->mean[i] + thrum_linear_step_kappa(step, i) * in_kappa +
                      thrum_linear_step_nu(step, i) * in_square);
  }
  add_by_start(step, -0.5 * h * h, q, false, step->w);

  // that of kappa d by the parts, times 2/h, comes to p' in the end
  memset(step->x, 0, (size_t)n * sizeof(double));
  double missed = is_scaled(step) ? s * step->missed + dot(step->sigma_q, q, n) : 0.0;
  share of;
  const double *by;
  for (int64_t next = 0; (by = next_share(step, change, &next, &of)) != NULL;) {
    if (*by == 0.0)
      continue;
    put_share(step, made, &of);
    for (int64_t i = 0; i < n; i++) {
      step->w[i] -= *by * step->part_y[i];
      step->x[i] += *by * step->part_kappa[i];
    }
    missed += *by * step->part_missed;
  }
  thrum_linear_solve(step->jacobian, n, step->rows, step->w);

  for (int64_t i = 0; i < n; i++) {
    q[i] += step->w[i];
    p[i] = 2.0 / h *
               (step->kappa[i] * step->w[i] + s * thrum_linear_step_kappa(step, i) * d[i] +
                step->x[i]) -
           p[i];
  }
  if (is_scaled(step))
    push_scale(step, missed + dot(step->sigma_d, step->w, n), p);
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
  share of;
  double *to;
  for (int64_t next = 0; (to = next_share(step, change, &next, &of)) != NULL;) {
    put_share_ends(step, made, &of);
    *to -= dot(w, step->part_end, n) + dot(a, step->part_start, n);
  }
}

/* y = - sum of the changes of the force at one end by all shares. */
static void put_part_sum(const thrum_linear_step *step, const thrum_made_step *made,
                         thrum_step_change *change, bool at_end) {
  memset(step->y, 0, (size_t)step->rank * sizeof(double));
  share of;
  const double *by;
  for (int64_t next = 0; (by = next_share(step, change, &next, &of)) != NULL;) {
    if (*by == 0.0)
      continue;
    put_share_ends(step, made, &of);
    const double *end = at_end ? step->part_end : step->part_start;
    for (int64_t i = 0; i < step->rank; i++)
      step->y[i] -= *by * end[i];
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
  share of;
  double *to;
  for (int64_t next = 0; (to = next_share(step, change, &next, &of)) != NULL;) {
    put_share_ends(step, made, &of);
    *to -= 0.5 * h * (dot(last, step->part_end, n) + dot(kicked, step->part_start, n));
  }

  // other levels before: T of this step is applied here
  if (!step->levels_change)
    return;
  thrum_tangent_product(step->model, made->q, kicked, product, step->work);
  for (int64_t i = 0; i < n; i++) {
    q[i] -= 0.5 * h * product[i];
    step->kept[i] = 0.0;
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
  if (step->levels_change)
    thrum_tangent_product(step->model, made->q, q, product, step->work);
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

void thrum_linear_step_pull(thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change) {
  if (step->equation.form == THRUM_STEP_NEWMARK)
    pull_newmark(step, made, change);
  else if (step->equation.form == THRUM_STEP_VERLET)
    pull_verlet(step, made, change);
  else
    pull_implicit(step, made, change);
}

void thrum_linear_step_push(thrum_linear_step *step, const thrum_made_step *made,
                            thrum_step_change *change) {
  if (step->equation.form == THRUM_STEP_NEWMARK)
    push_newmark(step, made, change);
  else if (step->equation.form == THRUM_STEP_VERLET)
    push_verlet(step, made, change);
  else
    push_implicit(step, made, change);
}
