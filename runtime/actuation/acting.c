/* What actuators add to V(q), docs/actuation.md: for each a function f of its measure
 * m, a volume or a length beyond that at rest, or the work of a strain of 1:
 *
 *   pressure, strain   f = -a m,   m = g q + 1/2 q H q + C(q), C cubic and of chambers alone
 *   tendon             f = a m,    m = sum |x_{i+1} - x_i| - L(0)
 *   gas                f = -(p + a) V0 ln(1 + m/V0) + p m
 *
 * so that the force is f' grad m, and the tangent f' m'' + f'' (grad m)(grad m)^T. C is stored by
 * its gradient, sum over i <= j of q_i q_j times a row: products with those rows are products of
 * matrices, which every kernel has.
 * Cost: a strain r^2, a chamber r^3/2 + r^2, a tendon of n guides 6 n r; of a tangent a chamber
 * r^3, a tendon 2 n r^2.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/actuation/acting.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"

/* Numbers that describe how straight parts turn, at a time: two parts at least. */
enum { TURNS_MAX = 4 * THRUM_RANK_MAX };

/* --- what is kept ----------------------------------------------------------------------------- */

int64_t thrum_acting_count(const thrum_model *model) {
  return THRUM_ACTING_ROWS * model->actuator_count + 3 * model->guide_count * model->rank;
}

static int64_t guide_begin(const thrum_model *model, int64_t k) {
  return k > 0 && model->guide_ends ? model->guide_ends[k - 1] : 0;
}

static int64_t guides_of(const thrum_model *model, int64_t k) {
  return model->guide_ends ? model->guide_ends[k] - guide_begin(model, k) : 0;
}

/* The rows of the guides of tendon k, transposed: rank x 3 guides. */
static int64_t turned_at(const thrum_model *model, int64_t k) {
  return THRUM_ACTING_ROWS * model->actuator_count + 3 * guide_begin(model, k) * model->rank;
}

void thrum_acting_fill(const thrum_model *model, double *levels) {
  const int64_t r = model->rank;
  memset(levels, 0, (size_t)(THRUM_ACTING_ROWS * model->actuator_count) * sizeof *levels);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    const int64_t rows = 3 * guides_of(model, k), first = 3 * guide_begin(model, k) * r;
    double *to = levels + turned_at(model, k);
    for (int64_t g = 0; g < rows; g++)
      for (int64_t i = 0; i < r; i++)
        to[i * rows + g] = model->guide_rows[first + g * r + i];
  }
}

int64_t thrum_acting_chamber(const thrum_model *model, int64_t k) {
  int64_t before = 0;
  for (int64_t n = 0; n < k; n++)
    before += model->actuator_kind[n] == THRUM_ACTUATOR_PRESSURE ||
              model->actuator_kind[n] == THRUM_ACTUATOR_GAS;
  return before;
}

/* --- polynomials ------------------------------------------------------------------------------ */

/* An actuator where it is evaluated. */
typedef struct acting {
  const thrum_kernel *by;
  const thrum_model *model;
  int64_t k, rank;
  int32_t kind;
  const double *q;
} acting;

static acting acting_of(const thrum_kernel *by, const thrum_model *model, int64_t k,
                        const double *q) {
  return (acting){by, model, k, model->rank, model->actuator_kind[k], q};
}

static bool has_volume(const acting *a) {
  return a->kind == THRUM_ACTUATOR_PRESSURE || a->kind == THRUM_ACTUATOR_GAS;
}

static const double *quadratic_of(const acting *a) {
  return a->model->actuator_quadratic + a->k * a->rank * a->rank;
}

static const double *cubic_of(const acting *a) {
  return a->model->actuator_cubic + thrum_acting_chamber(a->model, a->k) * a->model->actuator_cube;
}

/* Adds `by` times `from`. */
static void add_times(int64_t count, double by, const double *restrict from, double *restrict to) {
  for (int64_t i = 0; i < count; i++)
    to[i] += by * from[i];
}

static double dot(int64_t count, const double *x, const double *y) {
  double sum = 0.0;
  for (int64_t i = 0; i < count; i++)
    sum += x[i] * y[i];
  return sum;
}

/* The gradient of C at q. */
static void cubic_gradient(const acting *a, double *gradient) {
  const double *rows = cubic_of(a);
  const int64_t r = a->rank;
  double part[THRUM_RANK_MAX];
  memset(gradient, 0, (size_t)r * sizeof *gradient);
  for (int64_t i = 0; i < r; rows += (r - i) * r, i++) {
    a->by->product(r - i, r, rows, a->q + i, part);
    add_times(r, a->q[i], part, gradient);
  }
}

/* m of a polynomial and its gradient. */
static double polynomial_measure(const acting *a, double *gradient) {
  const int64_t r = a->rank;
  const double *linear = a->model->actuator_linear + a->k * r, *q = a->q;
  double cubic[THRUM_RANK_MAX];
  a->by->product(r, r, quadratic_of(a), q, gradient);
  double sum = dot(r, linear, q) + 0.5 * dot(r, gradient, q);
  add_times(r, 1.0, linear, gradient);
  if (has_volume(a)) {
    cubic_gradient(a, cubic);
    sum += dot(r, cubic, q) / 3.0;
    add_times(r, 1.0, cubic, gradient);
  }
  return sum;
}

/* hessian += by m'' */
static void add_polynomial_hessian(const acting *a, double by, double *hessian) {
  const int64_t r = a->rank;
  add_times(r * r, by, quadratic_of(a), hessian);
  if (!has_volume(a))
    return;
  const double *row = cubic_of(a);
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = i; j < r; j++, row += r) {
      add_times(r, by * a->q[j], row, hessian + i * r);
      add_times(r, by * a->q[i], row, hessian + j * r);
    }
}

/* product += by m'' v */
static void add_polynomial_product(const acting *a, double by, const double *v, double *product) {
  const int64_t r = a->rank;
  double part[THRUM_RANK_MAX];
  a->by->product(r, r, quadratic_of(a), v, part);
  add_times(r, by, part, product);
  if (!has_volume(a))
    return;
  const double *rows = cubic_of(a);
  for (int64_t i = 0; i < r; rows += (r - i) * r, i++) {
    a->by->product(r - i, r, rows, a->q + i, part);
    add_times(r, by * v[i], part, product);
    a->by->product(r - i, r, rows, v + i, part);
    add_times(r, by * a->q[i], part, product);
  }
}

/* --- tendons ---------------------------------------------------------------------------------- */

/* A tendon: its guides, and the directions and lengths of its straight parts. */
typedef struct tendon {
  int64_t guides;
  const double *rows; /* 3 guides x rank */
  double direction[THRUM_GUIDES_MAX][3], length[THRUM_GUIDES_MAX];
} tendon;

/* How the guides move with a change of the coordinates. */
static void move_guides(const acting *a, int64_t guides, const double *by, double *moved) {
  a->by->product(a->rank, 3 * guides, a->model->levels + turned_at(a->model, a->k), by, moved);
}

/* Returns the length beyond that at rest. */
static double stretch_tendon(const acting *a, tendon *t) {
  const thrum_model *model = a->model;
  const int64_t first = guide_begin(model, a->k);
  double at[3 * THRUM_GUIDES_MAX], sum = 0.0;
  t->guides = guides_of(model, a->k);
  t->rows = model->guide_rows + 3 * first * a->rank;
  move_guides(a, t->guides, a->q, at);
  add_times(3 * t->guides, 1.0, model->guide_places + 3 * first, at);
  for (int64_t n = 0; n + 1 < t->guides; n++) {
    for (int axis = 0; axis < 3; axis++)
      t->direction[n][axis] = at[3 * (n + 1) + axis] - at[3 * n + axis];
    const double length = sqrt(dot(3, t->direction[n], t->direction[n]));
    for (int axis = 0; axis < 3; axis++)
      t->direction[n][axis] /= length;
    t->length[n] = length;
    sum += length;
  }
  return sum - model->actuator_rest[3 * a->k];
}

/* grad m */
static void tendon_gradient(const acting *a, const tendon *t, double *gradient) {
  double pull[3 * THRUM_GUIDES_MAX] = {0.0};
  for (int64_t n = 0; n + 1 < t->guides; n++)
    for (int axis = 0; axis < 3; axis++) {
      pull[3 * n + axis] -= t->direction[n][axis];
      pull[3 * (n + 1) + axis] += t->direction[n][axis];
    }
  a->by->product(3 * t->guides, a->rank, t->rows, pull, gradient);
}

/* Two directions across that of a straight part. */
static void across(const double along[3], double side[2][3]) {
  const int least = fabs(along[0]) <= fabs(along[1]) && fabs(along[0]) <= fabs(along[2]) ? 0
                    : fabs(along[1]) <= fabs(along[2])                                   ? 1
                                                                                         : 2;
  double unit[3] = {0.0, 0.0, 0.0};
  unit[least] = 1.0;
  thrum_cross3(along, unit, side[0]);
  const double length = sqrt(dot(3, side[0], side[0]));
  for (int axis = 0; axis < 3; axis++)
    side[0][axis] /= length;
  thrum_cross3(along, side[0], side[1]);
}

/* How the coordinates move a straight part across, along both sides: rank numbers each. */
static void turned_by(const acting *a, const tendon *t, int64_t n, double *turned) {
  const int64_t r = a->rank;
  const double *from = t->rows + 3 * n * r, *to = from + 3 * r;
  double side[2][3];
  across(t->direction[n], side);
  for (int s = 0; s < 2; s++)
    for (int64_t i = 0; i < r; i++)
      turned[s * r + i] = side[s][0] * (to[i] - from[i]) + side[s][1] * (to[r + i] - from[r + i]) +
                          side[s][2] * (to[2 * r + i] - from[2 * r + i]);
}

/* hessian += by m'': what moves a straight part across turns its pull. Parts go into one pass over
 * the matrix, as many as there is room for. */
static void add_tendon_hessian(const acting *a, const tendon *t, double by, double *hessian) {
  const int64_t r = a->rank, most = TURNS_MAX / (2 * r);
  double turned[TURNS_MAX], scaled[TURNS_MAX];
  for (int64_t first = 0; first + 1 < t->guides; first += most) {
    const int64_t left = t->guides - 1 - first, count = left < most ? left : most;
    for (int64_t n = 0; n < count; n++) {
      turned_by(a, t, first + n, turned + 2 * n * r);
      for (int64_t i = 0; i < 2 * r; i++)
        scaled[2 * n * r + i] = by / t->length[first + n] * turned[2 * n * r + i];
    }
    const thrum_two pairs = {scaled, turned, scaled + r, turned + r, count, 2 * r};
    a->by->rank_two(r, false, &pairs, hessian);
  }
}

/* product += by m'' v */
static void add_tendon_product(const acting *a, const tendon *t, double by, const double *v,
                               double *product) {
  double moved[3 * THRUM_GUIDES_MAX], pull[3 * THRUM_GUIDES_MAX] = {0.0}, part[THRUM_RANK_MAX];
  move_guides(a, t->guides, v, moved);
  for (int64_t n = 0; n + 1 < t->guides; n++) {
    double change[3];
    for (int axis = 0; axis < 3; axis++)
      change[axis] = moved[3 * (n + 1) + axis] - moved[3 * n + axis];
    const double along = dot(3, t->direction[n], change);
    for (int axis = 0; axis < 3; axis++) {
      const double turn = (change[axis] - along * t->direction[n][axis]) / t->length[n];
      pull[3 * n + axis] -= turn;
      pull[3 * (n + 1) + axis] += turn;
    }
  }
  a->by->product(3 * t->guides, a->rank, t->rows, pull, part);
  add_times(a->rank, by, part, product);
}

/* --- their energies --------------------------------------------------------------------------- */

/* f, f' and f'' of a measure m. */
typedef struct energy_of_measure {
  double value, slope, curve;
} energy_of_measure;

static energy_of_measure energy_at(const acting *a, double level, double m) {
  if (a->kind == THRUM_ACTUATOR_TENDON)
    return (energy_of_measure){level * m, level, 0.0};
  if (a->kind != THRUM_ACTUATOR_GAS)
    return (energy_of_measure){-level * m, -level, 0.0};

  // a gas of no volume has no energy, which no step passes
  const double volume = a->model->actuator_rest[3 * a->k];
  const double outside = a->model->actuator_rest[3 * a->k + 1], inside = outside + level;
  const double now = volume + m;
  if (!(now > 0.0))
    return (energy_of_measure){NAN, NAN, NAN};
  return (energy_of_measure){outside * m - inside * volume * log1p(m / volume),
                             outside - inside * volume / now, inside * volume / (now * now)};
}

/* Whether it adds nothing. */
static bool is_idle(const acting *a) {
  return a->kind != THRUM_ACTUATOR_GAS && a->model->levels[a->k] == 0.0;
}

double thrum_acting_energy(const thrum_kernel *by, const thrum_model *model, const double *q,
                           double *gradient, double *hessian) {
  const int64_t r = model->rank;
  double sum = 0.0, slope[THRUM_RANK_MAX];
  tendon t;
  for (int64_t k = 0; k < model->actuator_count; k++) {
    const acting a = acting_of(by, model, k, q);
    if (is_idle(&a))
      continue;

    // its measure, and what that is worth
    const bool pulls = a.kind == THRUM_ACTUATOR_TENDON;
    const double m = pulls ? stretch_tendon(&a, &t) : polynomial_measure(&a, slope);
    const energy_of_measure f = energy_at(&a, model->levels[k], m);
    sum += f.value;
    if (pulls && gradient)
      tendon_gradient(&a, &t, slope);
    if (gradient)
      add_times(r, f.slope, slope, gradient);
    if (!hessian)
      continue;
    if (pulls)
      add_tendon_hessian(&a, &t, f.slope, hessian);
    else
      add_polynomial_hessian(&a, f.slope, hessian);
    for (int64_t i = 0; f.curve != 0.0 && i < r; i++)
      add_times(r, f.curve * slope[i], slope, hessian + i * r);
  }
  return sum;
}

void thrum_acting_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                          const double *v, double *product) {
  double slope[THRUM_RANK_MAX];
  tendon t;
  for (int64_t k = 0; k < model->actuator_count; k++) {
    const acting a = acting_of(by, model, k, q);
    if (is_idle(&a))
      continue;
    if (a.kind == THRUM_ACTUATOR_TENDON) {
      stretch_tendon(&a, &t);
      add_tendon_product(&a, &t, model->levels[k], v, product);
      continue;
    }
    const double m = a.kind == THRUM_ACTUATOR_GAS ? polynomial_measure(&a, slope) : 0.0;
    const energy_of_measure f = energy_at(&a, model->levels[k], m);
    add_polynomial_product(&a, f.slope, v, product);
    if (f.curve != 0.0)
      add_times(model->rank, f.curve * dot(model->rank, slope, v), slope, product);
  }
}

double thrum_acting_measure(const thrum_kernel *by, const thrum_model *model, int64_t k,
                            const double *q, double *gradient, double *base) {
  const acting a = acting_of(by, model, k, q);
  double slope[THRUM_RANK_MAX], factor = 1.0, m = 0.0;
  *base = 0.0;
  if (a.kind == THRUM_ACTUATOR_TENDON) {
    tendon t;
    m = -stretch_tendon(&a, &t);
    factor = -1.0;
    if (gradient)
      tendon_gradient(&a, &t, slope);
  } else {
    m = polynomial_measure(&a, slope);
  }
  if (a.kind == THRUM_ACTUATOR_GAS) {
    const double volume = model->actuator_rest[3 * k];
    *base = energy_at(&a, 0.0, m).value;
    factor = volume / (volume + m);
    m = volume * log1p(m / volume);
  }
  for (int64_t i = 0; gradient && i < model->rank; i++)
    gradient[i] = factor * slope[i];
  return m;
}

double thrum_acting_size(const thrum_kernel *by, const thrum_model *model, int64_t k,
                         const double *q) {
  const acting a = acting_of(by, model, k, q);
  double slope[THRUM_RANK_MAX];
  tendon t;
  const double m =
      a.kind == THRUM_ACTUATOR_TENDON ? stretch_tendon(&a, &t) : polynomial_measure(&a, slope);
  return model->actuator_rest[3 * k] + m;
}
