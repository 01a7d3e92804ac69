/* What actuators add to V(q), docs/actuation.md: for each a function f of its measure
 * m, a volume or a length beyond that at rest, or the work of a strain of 1:
 *
 *   pressure, strain   f = -a m,   m = g q + 1/2 q H q + C(q), C cubic and of chambers alone
 *   tendon             f = a m,    m = sum |x_{i+1} - x_i| - L(0)
 *   gas                f = -(p + a) V0 ln(1 + m/V0) + p m
 *
 * so that the force is f' grad m, and the tangent f' m'' + f'' (grad m)(grad m)^T. What is a
 * polynomial times a level is summed up where levels change: all pressures and strains are then one
 * polynomial. C is stored by its gradient, sum over i <= j of q_i q_j times a row: products with
 * those rows are products of matrices, which every kernel has. The straight parts of all tendons
 * are taken together, axis by axis, in bundles.
 * Cost: r^2 of all strains, r^3/2 of all pressures and of each gas, 6 n r of tendons with n
 * straight parts in all; of a tangent a chamber r^3, tendons 2 n r^2. A change of the levels of a
 * actuators: a r^2, and r^3/2 of each chamber where there are two.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/actuation/acting.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"

/* Numbers that describe how straight parts turn, at a time: two parts at least. */
enum { TURNS_MAX = 4 * THRUM_RANK_MAX };

/* Straight parts that are taken together. */
enum { BUNDLE = 64 };

#define LITTLE 0.1 /* of a Jacobian: less turning of tendons is left out */

/* --- what is kept ----------------------------------------------------------------------------- */

static int64_t guide_begin(const thrum_model *model, int64_t k) {
  return k > 0 && model->guide_ends ? model->guide_ends[k - 1] : 0;
}

static int64_t guides_of(const thrum_model *model, int64_t k) {
  return model->guide_ends ? model->guide_ends[k] - guide_begin(model, k) : 0;
}

static int64_t count_of(const thrum_model *model, int32_t kind) {
  int64_t count = 0;
  for (int64_t k = 0; k < model->actuator_count; k++)
    count += model->actuator_kind[k] == kind;
  return count;
}

/* Where the numbers behind the rows begin: the summed polynomial, whose cubic part is there where
 * several pressures have one; how much of turning each tendon has at a tension of 1, by
 * coordinates; the tension of each straight part of all tendons; and of the parts, their length at
 * rest, and in bundles, each axis by axis: how they are at rest (3), how they move with the
 * coordinates (3 x rank), and the same transposed. */
typedef struct kept {
  int64_t linear, quadratic, cubic, turning, tension, length, rest, rows, turned, end;
  int64_t pressures, parts;
} kept;

static kept kept_of(const thrum_model *model) {
  const int64_t r = model->rank;
  kept at = {.linear = THRUM_ACTING_ROWS * model->actuator_count,
             .pressures = count_of(model, THRUM_ACTUATOR_PRESSURE),
             .parts = model->guide_count - count_of(model, THRUM_ACTUATOR_TENDON)};
  at.quadratic = at.linear + r;
  at.cubic = at.quadratic + r * r;
  at.turning = at.cubic + (at.pressures > 1 ? model->actuator_cube : 0);
  at.tension = at.turning + (at.parts > 0 ? model->actuator_count * r : 0);
  at.length = at.tension + at.parts;
  at.rest = at.length + at.parts;
  at.rows = at.rest + 3 * at.parts;
  at.turned = at.rows + 3 * at.parts * r;
  at.end = at.turned + 3 * at.parts * r;
  return at;
}

int64_t thrum_acting_count(const thrum_model *model) {
  return kept_of(model).end;
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

static int64_t bundle_size(const kept *at, int64_t first) {
  return at->parts - first < BUNDLE ? at->parts - first : BUNDLE;
}

/* A straight part of tendon k, from guide g on, which is part n of all. */
static void fill_part(const thrum_model *model, const kept *at, int64_t k, int64_t g, int64_t n,
                      double *levels) {
  const int64_t r = model->rank, first = n / BUNDLE * BUNDLE, size = bundle_size(at, first);
  double square = 0.0;
  for (int64_t axis = 0; axis < 3; axis++) {
    const int64_t place = axis * size + (n - first);
    const double *from = model->guide_rows + (3 * g + axis) * r, *to = from + 3 * r;
    const double x = model->guide_places[3 * (g + 1) + axis] - model->guide_places[3 * g + axis];
    levels[at->rest + 3 * first + place] = x;
    square += x * x;
    for (int64_t i = 0; i < r; i++) {
      levels[at->rows + (3 * first + place) * r + i] = to[i] - from[i];
      levels[at->turned + 3 * first * r + i * 3 * size + place] = to[i] - from[i];
    }
  }
  levels[at->length + n] = sqrt(square);
  for (int64_t axis = 0; axis < 3; axis++) {
    const double *row = levels + at->rows + (3 * first + axis * size + (n - first)) * r;
    for (int64_t i = 0; i < r; i++)
      levels[at->turning + k * r + i] += row[i] * row[i] / sqrt(square);
  }
}

void thrum_acting_fill(const thrum_model *model, double *levels) {
  const kept at = kept_of(model);
  memset(levels, 0, (size_t)at.length * sizeof *levels);
  for (int64_t k = 0, n = 0; k < model->actuator_count; k++)
    for (int64_t g = 0; g + 1 < guides_of(model, k); g++, n++)
      fill_part(model, &at, k, guide_begin(model, k) + g, n, levels);
}

static bool has_volume(const thrum_model *model, int64_t k) {
  return model->actuator_kind[k] == THRUM_ACTUATOR_PRESSURE ||
         model->actuator_kind[k] == THRUM_ACTUATOR_GAS;
}

/* Whether it is one of the polynomials that are summed up. */
static bool is_summed(const thrum_model *model, int64_t k) {
  return model->actuator_kind[k] == THRUM_ACTUATOR_PRESSURE ||
         model->actuator_kind[k] == THRUM_ACTUATOR_STRAIN;
}

/* The tension of each straight part. */
static void put_tensions(const thrum_model *model, const double *tensions, double *parts) {
  for (int64_t k = 0; k < model->actuator_count; k++)
    for (int64_t g = 0; g + 1 < guides_of(model, k); g++)
      *parts++ = tensions[k];
}

void thrum_acting_sum(const thrum_model *model, double *levels) {
  const kept at = kept_of(model);
  const int64_t r = model->rank;
  const double *cubic = model->actuator_cubic;
  memset(levels + at.linear, 0, (size_t)(at.turning - at.linear) * sizeof *levels);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (is_summed(model, k) && levels[k] != 0.0) {
      add_times(r, -levels[k], model->actuator_linear + k * r, levels + at.linear);
      add_times(r * r, -levels[k], model->actuator_quadratic + k * r * r, levels + at.quadratic);
      if (at.pressures > 1 && has_volume(model, k))
        add_times(model->actuator_cube, -levels[k], cubic, levels + at.cubic);
    }
    if (has_volume(model, k))
      cubic += model->actuator_cube;
  }
  put_tensions(model, levels, levels + at.tension);
}

/* --- polynomials ------------------------------------------------------------------------------ */

/* linear q + 1/2 q quadratic q + by C(q), where it is evaluated. */
typedef struct form {
  const thrum_kernel *kernel;
  int64_t rank;
  const double *linear, *quadratic, *cubic; /* the last one by the rows of its gradient, or NULL */
  double by;
} form;

static const double *cubic_of(const thrum_model *model, int64_t k) {
  if (!has_volume(model, k))
    return NULL;
  int64_t before = 0;
  for (int64_t n = 0; n < k; n++)
    before += has_volume(model, n);
  return model->actuator_cubic + before * model->actuator_cube;
}

/* The measure of one. */
static form form_of(const thrum_kernel *by, const thrum_model *model, int64_t k) {
  const int64_t r = model->rank;
  return (form){by,
                r,
                model->actuator_linear + k * r,
                model->actuator_quadratic + k * r * r,
                cubic_of(model, k),
                1.0};
}

/* What all pressures and strains add to V: false where that is nothing. */
static bool form_of_all(const thrum_kernel *by, const thrum_model *model, form *f) {
  const kept at = kept_of(model);
  bool acts = false;
  *f = (form){by, model->rank, model->levels + at.linear, model->levels + at.quadratic, NULL, 1.0};
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (!is_summed(model, k) || model->levels[k] == 0.0)
      continue;
    acts = true;
    if (!has_volume(model, k))
      continue;
    f->cubic = at.pressures > 1 ? model->levels + at.cubic : cubic_of(model, k);
    f->by = at.pressures > 1 ? 1.0 : -model->levels[k];
  }
  return acts;
}

/* The gradient of C at q. */
static void cubic_gradient(const form *f, const double *q, double *gradient) {
  const double *rows = f->cubic;
  const int64_t r = f->rank;
  double part[THRUM_RANK_MAX];
  memset(gradient, 0, (size_t)r * sizeof *gradient);
  for (int64_t i = 0; i < r; rows += (r - i) * r, i++) {
    f->kernel->product(r - i, r, rows, q + i, part);
    add_times(r, q[i], part, gradient);
  }
}

/* Its value and gradient. */
static double form_value(const form *f, const double *q, double *gradient) {
  const int64_t r = f->rank;
  double cubic[THRUM_RANK_MAX];
  f->kernel->product(r, r, f->quadratic, q, gradient);
  double sum = dot(r, f->linear, q) + 0.5 * dot(r, gradient, q);
  add_times(r, 1.0, f->linear, gradient);
  if (f->cubic) {
    cubic_gradient(f, q, cubic);
    sum += f->by * dot(r, cubic, q) / 3.0;
    add_times(r, f->by, cubic, gradient);
  }
  return sum;
}

/* hessian += times its Hessian */
static void add_form_hessian(const form *f, double times, const double *q, double *hessian) {
  const int64_t r = f->rank;
  const double by = times * f->by, *row = f->cubic;
  add_times(r * r, times, f->quadratic, hessian);
  for (int64_t i = 0; row && i < r; i++)
    for (int64_t j = i; j < r; j++, row += r) {
      add_times(r, by * q[j], row, hessian + i * r);
      add_times(r, by * q[i], row, hessian + j * r);
    }
}

/* product += times its Hessian times v */
static void add_form_product(const form *f, double times, const double *q, const double *v,
                             double *product) {
  const int64_t r = f->rank;
  const double by = times * f->by, *rows = f->cubic;
  double part[THRUM_RANK_MAX];
  f->kernel->product(r, r, f->quadratic, v, part);
  add_times(r, times, part, product);
  for (int64_t i = 0; rows && i < r; rows += (r - i) * r, i++) {
    f->kernel->product(r - i, r, rows, q + i, part);
    add_times(r, by * v[i], part, product);
    f->kernel->product(r - i, r, rows, v + i, part);
    add_times(r, by * q[i], part, product);
  }
}

/* --- tendons ---------------------------------------------------------------------------------- */

/* Straight parts of tendons, axis by axis, under the tensions of their tendons. */
typedef struct bundle {
  const thrum_kernel *kernel;
  int64_t rank, size;
  const double *rest, *rows, *turned, *still, *tension; /* still: lengths at rest */
  double along[3 * BUNDLE], length[BUNDLE];
} bundle;

/* The parts from `first` on, under their tensions; false where there is none. */
static bool bundle_take(const thrum_kernel *by, const thrum_model *model, const kept *at,
                        int64_t first, const double *tension, bundle *b) {
  const double *levels = model->levels;
  const int64_t r = model->rank;
  b->kernel = by;
  b->rank = r;
  b->size = bundle_size(at, first);
  b->rest = levels + at->rest + 3 * first;
  b->rows = levels + at->rows + 3 * first * r;
  b->turned = levels + at->turned + 3 * first * r;
  b->still = levels + at->length + first;
  b->tension = tension + first;
  for (int64_t n = 0; n < b->size; n++)
    if (b->tension[n] != 0.0)
      return true;
  return false;
}

/* Where its parts lead at q. */
static void bundle_stretch(bundle *b, const double *q) {
  const int64_t n = b->size;
  double *x = b->along, *y = x + n, *z = y + n;
  b->kernel->product(b->rank, 3 * n, b->turned, q, x);
  add_times(3 * n, 1.0, b->rest, x);
  for (int64_t i = 0; i < n; i++)
    b->length[i] = sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
}

/* gradient += that of tension times length */
static void add_bundle_gradient(const bundle *b, double *gradient) {
  double pull[3 * BUNDLE], part[THRUM_RANK_MAX];
  const int64_t n = b->size;
  for (int64_t i = 0; i < n; i++) {
    const double by = b->tension[i] == 0.0 ? 0.0 : b->tension[i] / b->length[i];
    for (int64_t axis = 0; axis < 3; axis++)
      pull[axis * n + i] = by * b->along[axis * n + i];
  }
  b->kernel->product(3 * n, b->rank, b->rows, pull, part);
  add_times(b->rank, 1.0, part, gradient);
}

/* Two directions across that of a straight part. */
static void across(const double along[3], double side[2][3]) {
  const int least = fabs(along[0]) <= fabs(along[1]) && fabs(along[0]) <= fabs(along[2]) ? 0
                    : fabs(along[1]) <= fabs(along[2])                                   ? 1
                                                                                         : 2;
  double unit[3] = {0.0, 0.0, 0.0};
  unit[least] = 1.0;
  for (int s = 0; s < 2; s++) {
    thrum_cross3(along, s == 0 ? unit : side[0], side[s]);
    const double length = sqrt(dot(3, side[s], side[s]));
    for (int axis = 0; axis < 3; axis++)
      side[s][axis] /= length;
  }
}

/* How the coordinates move part i across, along both sides: rank numbers each. */
static void turned_by(const bundle *b, int64_t i, double *turned) {
  const int64_t r = b->rank, n = b->size;
  const double *x = b->rows + i * r, *y = x + n * r, *z = y + n * r;
  const double along[3] = {b->along[i], b->along[n + i], b->along[2 * n + i]};
  double side[2][3];
  across(along, side);
  for (int s = 0; s < 2; s++)
    for (int64_t c = 0; c < r; c++)
      turned[s * r + c] = side[s][0] * x[c] + side[s][1] * y[c] + side[s][2] * z[c];
}

/* hessian += that: what moves a straight part across turns its pull. Parts go into one pass over
 * the matrix, as many as there is room for. */
static void add_bundle_hessian(const bundle *b, double *hessian) {
  const int64_t r = b->rank, most = TURNS_MAX / (2 * r);
  double turned[TURNS_MAX], scaled[TURNS_MAX];
  for (int64_t i = 0; i < b->size;) {
    int64_t count = 0;
    for (; i < b->size && count < most; i++) {
      if (b->tension[i] == 0.0)
        continue;
      double *at = turned + 2 * count * r;
      turned_by(b, i, at);
      for (int64_t c = 0; c < 2 * r; c++)
        scaled[2 * count * r + c] = b->tension[i] / b->length[i] * at[c];
      count++;
    }
    const thrum_two pairs = {scaled, turned, scaled + r, turned + r, count, 2 * r};
    b->kernel->rank_two(r, false, &pairs, hessian);
  }
}

/* Whether weight times the Hessian of all tendons counts in a Jacobian, which is about
 * 1 + weight omega^2. */
static bool turning_counts(const thrum_model *model, const kept *at, double weight) {
  double most = 0.0;
  for (int64_t i = 0; i < model->rank; i++) {
    double all = 0.0;
    for (int64_t k = 0; k < model->actuator_count; k++)
      all += fabs(model->levels[k]) * model->levels[at->turning + k * model->rank + i];
    most += weight * all / (1.0 + weight * model->omega2[i]);
  }
  return !(most <= LITTLE);
}

/* What tendons add to V at q, with derivatives where they are asked for. */
static double pull_tendons(const thrum_kernel *by, const thrum_model *model, const double *q,
                           double *gradient, double *hessian, double weight) {
  const kept at = kept_of(model);
  const bool turns =
      hessian && at.parts > 0 && (weight == 0.0 || turning_counts(model, &at, weight));
  double sum = 0.0;
  bundle b;
  for (int64_t first = 0; first < at.parts; first += BUNDLE) {
    if (!bundle_take(by, model, &at, first, model->levels + at.tension, &b))
      continue;
    bundle_stretch(&b, q);
    for (int64_t i = 0; i < b.size; i++)
      sum += b.tension[i] * (b.length[i] - b.still[i]);
    if (gradient)
      add_bundle_gradient(&b, gradient);
    if (turns)
      add_bundle_hessian(&b, hessian);
  }
  return sum;
}

/* Lengths of tendons at q beyond those at rest, into their places of `lengths`; gradient (NULL: not
 * wanted) -= that of the sum of weights times them. */
static void measure_tendons(const thrum_kernel *by, const thrum_model *model, const double *weights,
                            const double *q, double *gradient, double *lengths) {
  const kept at = kept_of(model);
  int64_t k = 0, n = 0; // part n of tendon k, and its pull
  double pulls[BUNDLE];
  bundle b;
  for (int64_t first = 0; first < at.parts; first += BUNDLE) {
    bundle_take(by, model, &at, first, model->levels + at.tension, &b);
    bundle_stretch(&b, q);
    for (int64_t i = 0; i < b.size; i++, n++) {
      for (; n + 1 >= guides_of(model, k); k++)
        n = 0;
      lengths[k] = (n > 0 ? lengths[k] : 0.0) + (b.length[i] - b.still[i]);
      pulls[i] = weights ? -weights[k] : 0.0;
    }
    b.tension = pulls;
    if (gradient)
      add_bundle_gradient(&b, gradient);
  }
}

/* product += the Hessian of all tendons times v */
static void add_tendon_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                               const double *v, double *product) {
  const kept at = kept_of(model);
  double moved[3 * BUNDLE], part[THRUM_RANK_MAX];
  bundle b;
  for (int64_t first = 0; first < at.parts; first += BUNDLE) {
    if (!bundle_take(by, model, &at, first, model->levels + at.tension, &b))
      continue;
    bundle_stretch(&b, q);
    by->product(b.rank, 3 * b.size, b.turned, v, moved);
    for (int64_t i = 0; i < b.size; i++) {
      double along = 0.0;
      for (int64_t axis = 0; axis < 3; axis++)
        along += b.along[axis * b.size + i] * moved[axis * b.size + i];
      along /= b.length[i] * b.length[i];
      for (int64_t axis = 0; axis < 3; axis++) {
        const double across = moved[axis * b.size + i] - along * b.along[axis * b.size + i];
        moved[axis * b.size + i] = b.tension[i] == 0.0 ? 0.0 : b.tension[i] * across / b.length[i];
      }
    }
    by->product(3 * b.size, b.rank, b.rows, moved, part);
    add_times(b.rank, 1.0, part, product);
  }
}

/* --- gas -------------------------------------------------------------------------------------- */

/* f, f' and f'' of a gas whose volume is m beyond that at rest. One of no volume has no energy,
 * which no step passes. */
typedef struct energy_of_gas {
  double value, slope, curve;
} energy_of_gas;

static energy_of_gas gas_at(const thrum_model *model, int64_t k, double level, double m) {
  const double volume = model->actuator_rest[3 * k], now = volume + m;
  const double outside = model->actuator_rest[3 * k + 1], inside = outside + level;
  if (!(now > 0.0))
    return (energy_of_gas){NAN, NAN, NAN};
  return (energy_of_gas){outside * m - inside * volume * log1p(m / volume),
                         outside - inside * volume / now, inside * volume / (now * now)};
}

/* --- their energies --------------------------------------------------------------------------- */

double thrum_acting_energy(const thrum_kernel *by, const thrum_model *model, const double *q,
                           double *gradient, double *hessian, double weight) {
  const int64_t r = model->rank;
  double slope[THRUM_RANK_MAX];
  double sum = pull_tendons(by, model, q, gradient, hessian, weight);

  // all pressures and strains
  form f;
  if (form_of_all(by, model, &f)) {
    sum += form_value(&f, q, slope);
    if (gradient)
      add_times(r, 1.0, slope, gradient);
    if (hessian)
      add_form_hessian(&f, 1.0, q, hessian);
  }

  // each gas
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (model->actuator_kind[k] != THRUM_ACTUATOR_GAS)
      continue;
    f = form_of(by, model, k);
    const energy_of_gas gas = gas_at(model, k, model->levels[k], form_value(&f, q, slope));
    sum += gas.value;
    if (gradient)
      add_times(r, gas.slope, slope, gradient);
    if (hessian)
      add_form_hessian(&f, gas.slope, q, hessian);
    for (int64_t i = 0; hessian && i < r; i++)
      add_times(r, gas.curve * slope[i], slope, hessian + i * r);
  }
  return sum;
}

void thrum_acting_product(const thrum_kernel *by, const thrum_model *model, const double *q,
                          const double *v, double *product) {
  double slope[THRUM_RANK_MAX];
  add_tendon_product(by, model, q, v, product);
  form f;
  if (form_of_all(by, model, &f))
    add_form_product(&f, 1.0, q, v, product);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (model->actuator_kind[k] != THRUM_ACTUATOR_GAS)
      continue;
    f = form_of(by, model, k);
    const energy_of_gas gas = gas_at(model, k, model->levels[k], form_value(&f, q, slope));
    add_form_product(&f, gas.slope, q, v, product);
    add_times(model->rank, gas.curve * dot(model->rank, slope, v), slope, product);
  }
}

void thrum_acting_measures(const thrum_kernel *by, const thrum_model *model, const double *q,
                           const double *weights, double *force, double *measures, double *bases) {
  double slope[THRUM_RANK_MAX];
  measure_tendons(by, model, weights, q, force, measures);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    bases[k] = 0.0;
    if (model->actuator_kind[k] == THRUM_ACTUATOR_TENDON) {
      measures[k] = -measures[k];
      continue;
    }
    const form f = form_of(by, model, k);
    const double m = form_value(&f, q, slope);
    double factor = weights ? weights[k] : 0.0;
    measures[k] = m;
    if (model->actuator_kind[k] == THRUM_ACTUATOR_GAS) {
      const double volume = model->actuator_rest[3 * k];
      bases[k] = gas_at(model, k, 0.0, m).value;
      factor *= volume / (volume + m);
      measures[k] = volume * log1p(m / volume);
    }
    if (force && factor != 0.0)
      add_times(model->rank, factor, slope, force);
  }
}

void thrum_acting_sizes(const thrum_kernel *by, const thrum_model *model, const double *q,
                        double *sizes) {
  double slope[THRUM_RANK_MAX];
  measure_tendons(by, model, NULL, q, NULL, sizes);
  for (int64_t k = 0; k < model->actuator_count; k++) {
    if (model->actuator_kind[k] != THRUM_ACTUATOR_TENDON) {
      const form f = form_of(by, model, k);
      sizes[k] = form_value(&f, q, slope);
    }
    sizes[k] += model->actuator_rest[3 * k];
  }
}
