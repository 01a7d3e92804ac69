/* Tests of periodic motions: Duffing's oscillator against closed forms, the theorems that hold for
 * every model, and what is refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/condensed_support.h"

#include <complex.h>

#include "thrum/response.h"

/* A sweep: its steps, its rate, how long it rests before, and where jumps are over. */
#define SWEEP_DT 0.02
#define SWEEP_RATE 1e-5
#define SWEEP_REST 400
#define SWEEP_LATE 0.015

enum { POINTS_MAX = 4000, NUMBERS_MAX = 400 };

/* A curve as it was visited. */
typedef struct curve {
  thrum_response_point points[POINTS_MAX]; /* without their arrays */
  double coefficients[POINTS_MAX][NUMBERS_MAX];
  double multipliers[POINTS_MAX][8]; /* the four of the largest */
  double first;                      /* product of all multipliers of the last point */
  int count, numbers, rank;
  thrum_response_report report;
} curve;

static bool keep(void *context, const thrum_response_point *point) {
  curve *c = context;
  assert_in_range(c->count, 0, POINTS_MAX - 1);
  c->points[c->count] = *point;
  memcpy(c->coefficients[c->count], point->coefficients, (size_t)c->numbers * sizeof(double));
  if (point->multipliers != NULL) {
    const int shown = c->rank < 2 ? 2 * c->rank : 4;
    memcpy(c->multipliers[c->count], point->multipliers, (size_t)shown * 2 * sizeof(double));
    c->first = 1;
    for (int i = 0; i < 2 * c->rank; i++)
      c->first *= hypot(point->multipliers[2 * i], point->multipliers[2 * i + 1]);
  }
  c->count++;
  return true;
}

static curve *follow_from(const thrum_model *model, const thrum_response_def *def,
                          const double *start) {
  size_t size = 0;
  thrum_error error;
  curve *c = random_alloc(1, sizeof *c);
  c->rank = (int)model->rank;
  c->numbers = (2 * def->harmonics + 1) * (int)model->rank;
  assert_in_range(c->numbers, 1, NUMBERS_MAX);
  if (thrum_response_size(model, def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  memset(memory, 0xff, size);
  if (thrum_response(model, def, start, memory, size, keep, c, &c->report, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  free(memory);
  return c;
}

static curve *follow(const thrum_model *model, const thrum_response_def *def) {
  return follow_from(model, def, NULL);
}

/* q'' + d q' + w2 q + e q^3 = F cos(Omega t). */
typedef struct duffing {
  double w2, e, d, force;
  double c3, c4;
  thrum_model model;
} duffing;

static void duffing_make(duffing *o, double w2, double e, double d, double force) {
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  *o = (duffing){.w2 = w2, .e = e, .d = d, .force = force, .c4 = e / 4};
  o->model = (thrum_model){.rank = 1,
                           .c3_count = 1,
                           .c4_count = 1,
                           .format = format,
                           .omega2 = &o->w2,
                           .c3 = &o->c3,
                           .c4 = &o->c4};
}

/* Its curve under force cos(omega t), damped by d. */
static thrum_response_def swept(const duffing *o, double from, double to, int32_t harmonics) {
  thrum_response_def def = thrum_default_response_def();
  def.from = from;
  def.to = to;
  def.harmonics = harmonics;
  def.damping = &o->d;
  def.load_cosine = &o->force;
  return def;
}

/* The complete elliptic integral K of parameter m, by the arithmetic-geometric mean. */
static double elliptic(double m) {
  double a = 1, b = sqrt(1 - m);
  for (int n = 0; n < 40; n++) {
    const double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  return pi / (2 * a);
}

static void duffings_backbone_is_that_of_elliptic_functions(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 4, 3, 0, 0);
  thrum_response_def def = thrum_default_response_def();
  def.mode = 0;
  def.harmonics = 15;
  def.from = 1;
  def.to = 6;
  def.amplitude = 3;
  curve *c = follow(&o.model, &def);
  assert_int_equal(c->report.end, THRUM_RESPONSE_END_AMPLITUDE);
  assert_true(c->count > 20);
  for (int n = 0; n < c->count; n++) {
    double amplitude = 0;
    for (int k = 0; k <= def.harmonics; k++)
      amplitude += c->coefficients[n][k];
    const double stiff = o.w2 + o.e * amplitude * amplitude;
    const double exact =
        pi * sqrt(stiff) / (2 * elliptic(o.e * amplitude * amplitude / (2 * stiff)));
    assert_true(fabs(c->points[n].omega / exact - 1) < 1e-8);

    // the energy of a free motion is that of its greatest displacement
    const double energy = 0.5 * o.w2 * amplitude * amplitude + o.c4 * pow(amplitude, 4);
    assert_true(fabs(c->points[n].energy / energy - 1) < 1e-8);
    assert_int_equal(c->points[n].unstable, 0);
  }

  // the amplitude asked for is the first harmonic's
  assert_true(fabs(c->coefficients[c->count - 1][1] - 3) < 1e-10);
  free(c);
}

/* The forced curve of one harmonic: a^2 ((w2 - s + 3/4 e a^2)^2 + d^2 s) = F^2 with s = Omega^2,
 * and its derivative by a^2. */
static double frequency_equation(const duffing *o, double square, double s, double *slope) {
  const double stiff = o->w2 - s + 0.75 * o->e * square;
  *slope = stiff * stiff + o->d * o->d * s + square * 2 * stiff * 0.75 * o->e;
  return square * (stiff * stiff + o->d * o->d * s) - o->force * o->force;
}

/* Omega of a fold near a point of the curve: Newton's method for both equations. */
static double exact_fold(const duffing *o, double square, double s) {
  for (int it = 0; it < 50; it++) {
    double slope = 0, slope_a = 0, slope_s = 0;
    const double f = frequency_equation(o, square, s, &slope);
    const double da = 1e-6 * square, ds = 1e-6 * s;
    double slope_less = 0, other = 0;
    frequency_equation(o, square + da, s, &slope_a);
    frequency_equation(o, square - da, s, &slope_less);
    const double faa = (slope_a - slope_less) / (2 * da);
    const double more = frequency_equation(o, square, s + ds, &slope_s);
    const double less = frequency_equation(o, square, s - ds, &other);
    const double fs = (more - less) / (2 * ds), fas = (slope_s - other) / (2 * ds);
    const double determinant = slope * fas - fs * faa;
    square -= (f * fas - fs * slope) / determinant;
    s -= (slope * slope - faa * f) / determinant;
  }
  return sqrt(s);
}

static void duffings_forced_curve_and_folds_are_those_of_the_closed_form(void **context) {
  (void)context;
  for (int sign = -1; sign <= 1; sign += 2)
    for (int back = 0; back < 2; back++) {
      duffing o;
      duffing_make(&o, 1, sign < 0 ? -0.2 : 0.8, 0.02, sign < 0 ? 0.01 : 0.02);
      const thrum_response_def def = swept(&o, back ? 1.6 : 0.5, back ? 0.5 : 1.6, 1);
      curve *c = follow(&o.model, &def);
      assert_int_equal(c->report.end, THRUM_RESPONSE_END_ARRIVED);
      assert_int_equal(c->report.folds, 2);
      assert_int_equal(c->report.special, 2);
      assert_true(c->report.balance < 1e-9);
      for (int n = 0; n < c->count; n++) {
        double slope;
        const double *x = c->coefficients[n], omega = c->points[n].omega;
        const double square = x[1] * x[1] + x[2] * x[2];
        const double f = frequency_equation(&o, square, omega * omega, &slope);
        assert_true(fabs(f) < 1e-9 * o.force * o.force);

        if (c->points[n].kind == THRUM_RESPONSE_FOLD)
          assert_true(fabs(omega / exact_fold(&o, square, omega * omega) - 1) < 1e-8);
      }
      assert_true(fabs(c->points[c->count - 1].omega - def.to) < 1e-12);
      free(c);
    }
}

static void a_given_start_may_turn_back_and_ends_as_far_behind_it(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 0.8, 0.02, 0.02);
  thrum_response_def def = swept(&o, 0.5, 1.6, 1);
  curve *c = follow(&o.model, &def);
  int middle = 0;
  while (middle < c->count && c->points[middle].unstable != 1)
    middle++;
  middle += 3;
  assert_true(middle < c->count && c->points[middle].unstable == 1);

  // down from an unstable motion, around the lower fold, and up again
  def.from = c->points[middle].omega;
  def.to = 0.9 * def.from;
  curve *back = follow_from(&o.model, &def, c->coefficients[middle]);
  assert_int_equal(back->report.end, THRUM_RESPONSE_END_LEFT);
  assert_int_equal(back->report.folds, 1);
  const double end = back->points[back->count - 1].omega;
  assert_true(fabs(end * 0.9 / def.from - 1) < 1e-12);
  free(back);
  free(c);
}

static void motions_between_the_folds_are_unstable_and_no_others(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 0.8, 0.02, 0.02);
  thrum_response_def def = swept(&o, 0.5, 1.6, 9);
  curve *c = follow(&o.model, &def);
  assert_int_equal(c->report.special, 2);
  assert_int_equal(c->report.folds, 2);
  for (int n = 0, folds = 0; n < c->count; n++) {
    // at a fold a multiplier is 1
    if (c->points[n].kind == THRUM_RESPONSE_FOLD) {
      assert_true(fabs(c->multipliers[n][0] - 1) < 1e-3 || fabs(c->multipliers[n][2] - 1) < 1e-3);
      folds++;
    } else {
      assert_int_equal(c->points[n].unstable, folds == 1 ? 1 : 0);
    }
  }
  free(c);
}

static void multipliers_of_a_linear_oscillator_are_exponentials(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 2, 0, 0.1, 1);
  const double load[1] = {1};
  thrum_response_def def = thrum_default_response_def();
  def.harmonics = 2;
  def.from = 1;
  def.to = 3;
  def.damping = &o.d;
  def.load_sine = load;
  def.stability_steps = 128;
  curve *c = follow(&o.model, &def);
  for (int n = 0; n < c->count; n++) {
    const double period = 2 * pi / c->points[n].omega, *found = c->multipliers[n];
    const double size = exp(-0.05 * period), angle = sqrt(2 - 0.0025) * period;
    assert_true(fabs(found[0] - size * cos(angle)) < 1e-5);
    assert_true(fabs(fabs(found[1]) - size * fabs(sin(angle))) < 1e-5);

    // and the motion is the linear answer
    const double w = c->points[n].omega, stiff = 2 - w * w, square = stiff * stiff + 0.01 * w * w;
    assert_true(fabs(c->coefficients[n][1] + 0.1 * w / square) < 1e-10);
    assert_true(fabs(c->coefficients[n][3] - stiff / square) < 1e-10);
  }
  free(c);
}

/* A mode of stiffness W^2 (1 + q_1^2 / 2) that turns many times in a step: where 48 of them meet
 * the swing of the stiffness, at W = 700, they alone pump it. */
static void modes_faster_than_the_steps_make_nothing_unstable(void **context) {
  (void)context;
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  for (double fast = 600; fast < 810; fast += 50) {
    const double omega2[2] = {4, fast * fast}, damping[2] = {0.01, 0.02 * fast}, load[2] = {3, 0};
    const double c3[4] = {0}, c4[5] = {0, 0, fast * fast / 4, 0, 0};
    const thrum_model model = {.rank = 2,
                               .c3_count = 4,
                               .c4_count = 5,
                               .format = format,
                               .omega2 = omega2,
                               .c3 = c3,
                               .c4 = c4};
    thrum_response_def def = thrum_default_response_def();
    def.from = 0.95;
    def.to = 1.05;
    def.step = 1;
    def.damping = damping;
    def.load_cosine = load;
    curve *c = follow(&model, &def);
    for (int n = 0; n < c->count; n++)
      assert_int_equal(c->points[n].unstable, 0);
    free(c);
  }
}

/* A model of several modes, a load and damping for it. */
typedef struct several {
  random_model m;
  double damping[4], cosine[4], sine[4];
  thrum_response_def def;
} several;

static void several_make(several *s, double force) {
  random_model_make(&s->m, 5, 4, 1, 7, 2);
  s->def = thrum_default_response_def();
  for (int i = 0; i < 4; i++) {
    s->damping[i] = 0.02 * (i + 1);
    s->cosine[i] = force * (i + 1);
    s->sine[i] = force * (3 - i);
  }
  s->def.from = 0.6;
  s->def.to = 1.6;
  s->def.harmonics = 7;
  s->def.damping = s->damping;
  s->def.load_cosine = s->cosine;
  s->def.load_sine = s->sine;
}

static void every_motion_balances_its_energy_and_solves_the_equation(void **context) {
  (void)context;
  several s;
  several_make(&s, 0.004);
  s.def.harmonics = 12;
  s.def.stability_steps = 192;
  curve *c = follow(&s.m.model, &s.def);
  assert_int_equal(c->report.end, THRUM_RESPONSE_END_ARRIVED);
  assert_true(c->report.balance < 1e-9);
  double *work = random_alloc((int64_t)thrum_work_count(&s.m.model), sizeof(double));
  for (int n = 0; n < c->count; n += 5) {
    // q'' + D q' + R = f at a phase that is no sample, with all harmonics that matter
    const double omega = c->points[n].omega, phase = 0.777, h = 1e-3;
    double q[4], p[4], more[4], less[4], force[4], largest = 0, residual = 0;
    thrum_response_at(4, s.def.harmonics, omega, phase, c->coefficients[n], q, p);
    thrum_response_at(4, s.def.harmonics, omega, phase + h, c->coefficients[n], NULL, more);
    thrum_response_at(4, s.def.harmonics, omega, phase - h, c->coefficients[n], NULL, less);
    thrum_internal_force(&s.m.model, q, force, work);
    for (int i = 0; i < 4; i++) {
      const double load = s.cosine[i] * cos(phase) + s.sine[i] * sin(phase);
      const double rate = omega * (more[i] - less[i]) / (2 * h);
      largest = fmax(largest, fabs(rate));
      residual = fmax(residual, fabs(rate + s.damping[i] * p[i] + force[i] - load));
    }
    assert_true(residual < 2e-5 * largest);

    // Parseval: the mean of the kinetic energy is that of the coefficients
    double mean = 0, sum = 0;
    for (int at = 0; at < 64; at++) {
      thrum_response_at(4, s.def.harmonics, omega, 2 * pi * at / 64, c->coefficients[n], q, p);
      for (int i = 0; i < 4; i++)
        mean += p[i] * p[i] / 128;
    }
    for (int k = 1; k <= s.def.harmonics; k++)
      for (int i = 0; i < 4; i++) {
        const double a = c->coefficients[n][4 * k + i];
        const double b = c->coefficients[n][4 * (s.def.harmonics + k) + i];
        sum += 0.25 * omega * omega * k * k * (a * a + b * b);
      }
    assert_true(fabs(mean / sum - 1) < 1e-9);
  }

  // Liouville: all multipliers together are the decay of the volume
  const double period = 2 * pi / c->points[c->count - 1].omega;
  assert_true(fabs(c->first / exp(-0.2 * period) - 1) < 1e-5);
  free(work);
  free(c);
  random_model_free(&s.m);
}

static void the_curve_does_not_depend_on_its_steps(void **context) {
  (void)context;
  double folds[2][8];
  int counts[2] = {0, 0};
  several s;
  several_make(&s, 0.012);
  for (int run = 0; run < 2; run++) {
    s.def.step = run == 0 ? 0.05 : 0.017;
    curve *c = follow(&s.m.model, &s.def);
    for (int n = 0; n < c->count; n++)
      if (c->points[n].kind == THRUM_RESPONSE_FOLD && counts[run] < 8)
        folds[run][counts[run]++] = c->points[n].omega;
    free(c);
  }
  assert_int_equal(counts[0], counts[1]);
  assert_true(counts[0] >= 2);
  for (int n = 0; n < counts[0]; n++)
    assert_true(fabs(folds[0][n] / folds[1][n] - 1) < 1e-6);
  random_model_free(&s.m);
}

static void units_change_nothing(void **context) {
  (void)context;
  double found[2][2];
  for (int run = 0; run < 2; run++) {
    // mass^1/2 length and time in other units
    const double length = run == 0 ? 1 : 1e-6, rate = run == 0 ? 1 : 1e4;
    duffing o;
    duffing_make(&o, rate * rate, 0.8 * rate * rate / (length * length), 0.02 * rate, 0);
    const double load[1] = {0.02 * length * rate * rate};
    thrum_response_def def = thrum_default_response_def();
    def.from = 0.5 * rate;
    def.to = 1.6 * rate;
    def.damping = &o.d;
    def.load_cosine = load;
    curve *c = follow(&o.model, &def);
    found[run][0] = c->count;
    for (int n = 0; n < c->count; n++)
      if (c->points[n].kind == THRUM_RESPONSE_FOLD)
        found[run][1] = c->points[n].omega / rate;
    free(c);
  }
  assert_true(found[0][0] == found[1][0]);
  assert_true(fabs(found[0][1] / found[1][1] - 1) < 1e-9);
}

static void a_load_on_the_slaves_of_a_condensed_model_does_work(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 9, 6, 1, 9, 3);
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 3, &stepped);
  const double damping[3] = {0.05, 0.05, 0.05};
  const double load[6] = {0.01, 0, 0, 0.02, -0.03, 0.01};
  thrum_response_def def = thrum_default_response_def();
  def.from = 0.7;
  def.to = 1.4;
  const double slave_damping[3] = {0.3, 0.2, 0.1};
  def.damping = damping;
  def.slave_damping = slave_damping;
  def.load_sine = load;
  curve *c = follow(stepped, &def);
  assert_int_equal(c->report.end, THRUM_RESPONSE_END_ARRIVED);
  assert_true(c->report.balance < 1e-9);
  free(c);
  free(memory);
  random_model_free(&m);
}

/* Frequency of the backbone of the first mode at an amplitude, and how far two multipliers are
 * from 1. */
static double backbone_at(const thrum_model *model, double amplitude, int32_t inertia,
                          double *from_one) {
  thrum_response_def def = thrum_default_response_def();
  def.mode = 0;
  def.harmonics = 7;
  def.from = 0.5;
  def.to = 2;
  def.amplitude = amplitude;
  def.inertia = inertia;
  curve *c = follow(model, &def);
  assert_int_equal(c->report.end, THRUM_RESPONSE_END_AMPLITUDE);
  const double *found = c->multipliers[c->count - 1];
  *from_one = 0;
  for (int i = 0; i < (model->rank < 2 ? 2 : 4); i++)
    if (fabs(hypot(found[2 * i], found[2 * i + 1]) - 1) < 0.1 && fabs(found[2 * i] - 1) < 0.1)
      *from_one = fmax(*from_one, hypot(found[2 * i] - 1, found[2 * i + 1]));
  const double omega = c->points[c->count - 1].omega;
  free(c);
  return omega;
}

static void inertia_of_slaves_brings_a_backbone_to_that_of_all_coordinates(void **context) {
  (void)context;
  // a slave of six times the frequency, which is pushed by the square of the master
  random_model m;
  random_model_make(&m, 3, 2, 1, 6, INFINITY);
  m.c3[thrum_c3_index(2, 0, 0, 1)] = 3;
  m.c4[thrum_c4_index(2, 0, 0, 0, 0)] = 0.2;
  const thrum_model *stepped = NULL;
  void *memory = condense(&m.model, 1, &stepped);
  double from_one = 0;
  const double whole = backbone_at(&m.model, 0.3, 1, &from_one);
  const double with = backbone_at(stepped, 0.3, 1, &from_one);

  // a free motion has two multipliers at 1, of its phase and its energy
  assert_true(from_one < 1e-3);
  const double without = backbone_at(stepped, 0.3, 0, &from_one);
  assert_true(fabs(whole - 1) > 1e-3);
  assert_true(fabs(with - whole) < 0.2 * fabs(without - whole));
  free(memory);
  random_model_free(&m);
}

/* The backbone in terms of the normal form: the first harmonic a_1 of the mode is 4 rho omega /
 * (omega + Omega). */
static void the_normal_form_is_the_backbone_at_small_amplitudes(void **context) {
  (void)context;
  for (int rank = 1; rank <= 3; rank += 2) {
    random_model m;
    random_model_make(&m, 6, rank, 1, 4.5, 2);
    size_t size = 0;
    assert_int_equal(thrum_normal_form_size(&m.model, 0, &size, NULL), THRUM_OK);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    thrum_normal_form form, other = {.omega = 7};
    assert_int_equal(thrum_normal_form_find(&m.model, 0, 0.3, memory, size, &form, NULL), THRUM_OK);
    const thrum_normal_form kept = other;
    assert_int_equal(thrum_normal_form_find(&m.model, 0, 1e33, memory, size, &other, NULL),
                     THRUM_NOT_FINITE);
    assert_memory_equal(&other, &kept, sizeof kept);
    assert_int_equal(thrum_normal_form_find(&m.model, 0, 0.6, memory, size, &other, NULL),
                     THRUM_OK);
    for (int k = 0; k < 3; k++)
      assert_true(fabs(form.coefficients[k] / other.coefficients[k] - 1) < 1e-8);

    thrum_response_def def = thrum_default_response_def();
    def.mode = 0;
    def.harmonics = 9;
    def.from = 0.5;
    def.to = 2;
    def.amplitude = 0.35;
    curve *c = follow(&m.model, &def);
    int compared = 0;
    for (int n = 0; n < c->count; n++) {
      const double omega = c->points[n].omega, a = c->coefficients[n][rank];
      const double square = pow(0.25 * a * (1 + omega / form.omega), 2);
      const double series =
          form.omega + square * (form.coefficients[0] +
                                 square * (form.coefficients[1] + square * form.coefficients[2]));
      const double shift = fabs(omega - form.omega);
      if (a < 0.12) {
        assert_true(fabs(series - omega) < 1e-4 * shift + 1e-13);
        compared++;
      }
    }
    assert_true(compared > 3);
    free(c);
    free(memory);
    random_model_free(&m);
  }
}

/* The coefficient of a term of a pair; 0 where it has none. */
static double term_of(const thrum_normal_form_pair *form, int of, int a, int b, int c, int d) {
  for (int n = 0; n < form->count; n++) {
    const int32_t *p = form->terms[n].powers;
    if (form->terms[n].of == of && p[0] == a && p[1] == b && p[2] == c && p[3] == d)
      return form->terms[n].coefficient;
  }
  return 0;
}

/* V = .. + k q_1^2 q_2 (1:2), k q_1^3 q_2 (1:3) and k q_1^2 q_2^2 (1:1): the lowest terms of their
 * normal forms are those of the forces, over 2 omega. */
static void the_normal_form_of_two_modes_has_the_terms_of_their_polynomial(void **context) {
  (void)context;
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  for (int ratio = 1; ratio <= 3; ratio++) {
    const double k = 0.7, omega2[2] = {1, (ratio + 0.05) * (ratio + 0.05)};
    double c3[4] = {0}, c4[5] = {0};
    if (ratio == 2)
      c3[thrum_c3_index(2, 0, 0, 1)] = k;
    else
      c4[ratio == 3 ? thrum_c4_index(2, 0, 0, 0, 1) : thrum_c4_index(2, 0, 0, 1, 1)] = k;
    const thrum_model model = {.rank = 2,
                               .c3_count = 4,
                               .c4_count = 5,
                               .format = format,
                               .omega2 = omega2,
                               .c3 = c3,
                               .c4 = c4};
    size_t size = 0;
    assert_int_equal(thrum_normal_form_size(&model, 0, &size, NULL), THRUM_OK);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    thrum_normal_form_pair form;
    const int64_t modes[2] = {0, 1}, twice[2] = {1, 1};
    assert_int_equal(
        thrum_normal_form_pair_find(&model, modes, ratio, 3, 0.5, memory, size, &form, NULL),
        THRUM_OK);
    const double second = sqrt(omega2[1]);
    const double first_found = ratio == 1   ? term_of(&form, 0, 1, 0, 1, 1)
                               : ratio == 2 ? term_of(&form, 0, 0, 1, 1, 0)
                                            : term_of(&form, 0, 0, 2, 1, 0);
    const double second_found = ratio == 1   ? term_of(&form, 1, 1, 1, 1, 0)
                                : ratio == 2 ? term_of(&form, 1, 2, 0, 0, 0)
                                             : term_of(&form, 1, 3, 0, 0, 0);
    const double first_force = ratio == 1 ? 4 * k : ratio == 2 ? 2 * k : 3 * k;
    const double second_force = ratio == 1 ? 4 * k : k;
    assert_true(fabs(first_found / (first_force / 2) - 1) < 1e-12);
    assert_true(fabs(second_found / (second_force / (2 * second)) - 1) < 1e-12);
    assert_int_equal(
        thrum_normal_form_pair_find(&model, twice, ratio, 3, 0.5, memory, size, &form, NULL),
        THRUM_INVALID_ARGUMENT);
    assert_int_equal(
        thrum_normal_form_pair_find(&model, modes, 4, 3, 0.5, memory, size, &form, NULL),
        THRUM_INVALID_ARGUMENT);
    free(memory);
  }
}

/* How far a motion of harmonic balance misses the normal form, each row over its frequency; both
 * modes swing with cosines, and rho_j (j Omega's multiple + omega_j) = 2 omega_j times half of the
 * harmonic, as of one mode. */
static double form_misses(const thrum_normal_form_pair *form, int ratio, double omega,
                          const double harmonics[2]) {
  double rho[2], largest = 0;
  for (int j = 0; j < 2; j++) {
    const double turning = (j == 0 ? 1 : ratio) * omega;
    rho[j] = 0.5 * harmonics[j] * (turning + form->omega[j]) / (2 * form->omega[j]);
  }
  for (int j = 0; j < 2; j++) {
    double sum = (form->omega[j] - (j == 0 ? 1 : ratio) * omega) * rho[j];
    for (int n = 0; n < form->count; n++) {
      const int32_t *p = form->terms[n].powers;
      if (form->terms[n].of == j)
        sum += form->terms[n].coefficient * pow(rho[0], p[0] + p[1]) * pow(rho[1], p[2] + p[3]);
    }
    largest = fmax(largest, fabs(sum));
  }
  return largest;
}

/* Backbones near 1:1, 1:2 and 1:3 obey the normal form but for its next order. */
static void the_normal_form_of_two_modes_is_their_backbone(void **context) {
  (void)context;
  for (int ratio = 1; ratio <= 3; ratio++) {
    random_model m;
    const double last = ratio + 0.03;
    random_model_make(&m, 11, 3, 1, last, 2);
    const int64_t modes[2] = {0, 2};
    size_t size = 0;
    assert_int_equal(thrum_normal_form_size(&m.model, 0, &size, NULL), THRUM_OK);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    for (int order = 3; order <= 7; order += 2) {
      thrum_normal_form_pair form;
      if (thrum_normal_form_pair_find(&m.model, modes, ratio, order, 0.3, memory, size, &form,
                                      NULL) != THRUM_OK)
        fail_msg("no form of 1:%d", ratio);
      double misses[2];
      for (int half = 0; half < 2; half++) {
        thrum_response_def def = thrum_default_response_def();
        def.mode = 0;
        def.harmonics = 9;
        def.from = 0.5;
        def.to = 2;
        def.amplitude = (half ? 0.03 : 0.06) * (order == 7 ? 3 : 1);
        def.stability = 0;
        curve *c = follow(&m.model, &def);
        const double *x = c->coefficients[c->count - 1];
        const double harmonics[2] = {x[3], x[3 * ratio + 2]};
        misses[half] = form_misses(&form, ratio, c->points[c->count - 1].omega, harmonics);
        free(c);
      }
      assert_true(misses[0] < 1e-5 && misses[0] > 0);
      assert_true(log2(misses[0] / misses[1]) > order + 0.8);
    }
    free(memory);
    random_model_free(&m);
  }
}

/* Two modes, q1'' + d q1' + 4 q1 + e q2^2 = F cos(2 tau), q2'' + d q2' + q2 + 2 e q1 q2 = 0. Two
 * harmonics of tau have a closed form: q2 = Re(A e^(i tau)), q1 = m + Re(B e^(2 i tau)), m = -e
 * |A|^2 / 8, e |B| = |z2|, |e |A|^2 / 2 - z1 z2 / e| = F with z1 = 4 - 4 s^2 + 2 i d s, z2 = 1 -
 * s^2 + 2 e m
 * + i d s at the frequency s. */
typedef struct pair {
  double omega2[2], damping[2], load[2], c3[4], c4[5], e;
  thrum_model model;
  thrum_response_def def;
} pair;

static void pair_make(pair *o, double e, double d, double force) {
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  *o = (pair){.omega2 = {4, 1}, .damping = {d, d}, .load = {force, 0}, .e = e};
  o->c3[thrum_c3_index(2, 0, 1, 1)] = e;
  o->model = (thrum_model){.rank = 2,
                           .c3_count = 4,
                           .c4_count = 5,
                           .format = format,
                           .omega2 = o->omega2,
                           .c3 = o->c3,
                           .c4 = o->c4};
  o->def = thrum_default_response_def();
  o->def.from = 0.8;
  o->def.to = 1.2;
  o->def.damping = o->damping;
  o->def.load_cosine = o->load;
  o->def.periods = 2;
}

/* How far the force of the closed form is from F, over F, where q2 has the square |A|^2. */
static double pair_misses(const pair *o, double s, double square) {
  const double complex i = I;
  const double m = -o->e * square / 8, d = o->damping[0];
  const double complex z1 = 4 - 4 * s * s + 2 * i * d * s,
                       z2 = 1 - s * s + 2 * o->e * m + i * d * s;
  return cabs(0.5 * o->e * square - z1 * z2 / o->e) / o->load[0] - 1;
}

static void a_curve_goes_on_along_the_other_one_at_a_branch_point(void **context) {
  (void)context;
  pair o;
  pair_make(&o, 0.2, 0.05, 0.1);
  o.def.harmonics = 2;
  curve *straight = follow(&o.model, &o.def);
  double crossings[2];
  int count = 0;
  for (int n = 0; n < straight->count; n++)
    if (straight->points[n].kind == THRUM_RESPONSE_BRANCH && count < 2) {
      crossings[count++] = straight->points[n].omega;
      assert_true(fabs(pair_misses(&o, straight->points[n].omega, 0)) < 1e-5);
    }
  assert_int_equal(count, 2);
  assert_int_equal(straight->report.special, 2);
  assert_int_equal(straight->report.end, THRUM_RESPONSE_END_ARRIVED);

  // the other curve, to both sides, which differ by a period of the load
  double sides[2];
  for (int side = 0; side < 2; side++) {
    o.def.branch = side == 0 ? 1 : -1;
    curve *c = follow(&o.model, &o.def);
    double largest = 0;
    int begun = 0;
    while (c->points[begun].kind != THRUM_RESPONSE_BRANCH)
      begun++;
    assert_true(c->points[begun].omega == crossings[0]);
    for (int n = begun + 1; n < c->count; n++) {
      const double *x = c->coefficients[n];
      const double square = x[3] * x[3] + x[7] * x[7];
      const double bound = c->points[n].kind == THRUM_RESPONSE_BRANCH ? 1e-5 : 1e-9;
      assert_true(fabs(pair_misses(&o, c->points[n].omega, square)) < bound);
      largest = fmax(largest, square);
    }
    sides[side] = c->coefficients[begun + 10][3];
    assert_true(largest > 0.5);
    assert_true(c->report.balance < 1e-9);
    assert_int_equal(c->report.end, THRUM_RESPONSE_END_CLOSED);
    free(c);
  }
  assert_true(fabs(sides[0]) > 1e-2);
  assert_true(fabs(sides[0] + sides[1]) < 1e-6);
  free(straight);
}

static void a_period_doubling_is_a_branch_point_of_two_periods(void **context) {
  (void)context;
  pair o;
  double found[2][2];
  for (int run = 0; run < 2; run++) {
    pair_make(&o, 0.2, 0.05, 0.1);
    o.def.periods = run + 1;
    o.def.harmonics = 5 * (run + 1);
    o.def.from *= 2 - run;
    o.def.to *= 2 - run;
    o.def.stability = run == 0;
    curve *c = follow(&o.model, &o.def);
    const thrum_response_kind kind =
        run == 0 ? THRUM_RESPONSE_PERIOD_DOUBLING : THRUM_RESPONSE_BRANCH;
    int count = 0;
    for (int n = 0; n < c->count; n++)
      if (c->points[n].kind == kind && count < 2)
        found[run][count++] = c->points[n].omega / (2 - run);
    assert_int_equal(count, 2);
    free(c);
  }
  for (int n = 0; n < 2; n++)
    assert_true(fabs(found[1][n] / found[0][n] - 1) < 1e-5);
}

static void a_symmetric_oscillator_swings_to_one_side_after_its_symmetry_breaks(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 1, 0.1, 4);
  thrum_response_def def = swept(&o, 1, 0.3, 9);
  double means[2];
  for (int side = 0; side < 2; side++) {
    def.branch = side == 0 ? 1 : -1;
    curve *c = follow(&o.model, &def);
    int begun = 0;
    while (begun < c->count && c->points[begun].kind != THRUM_RESPONSE_BRANCH)
      begun++;
    assert_true(begun + 4 < c->count);
    for (int n = 0; n < begun; n++)
      assert_true(fabs(c->coefficients[n][0]) < 1e-9);

    // past the crossing one of them is stable and the mean grows
    means[side] = c->coefficients[begun + 3][0];
    assert_true(fabs(means[side]) > 1e-3);
    free(c);
  }
  assert_true(fabs(means[0] + means[1]) < 1e-9);
}

/* Duffing's subharmonic of a third: a closed curve of motions of three periods, apart from the
 * motion of one. */
static void an_isola_is_followed_from_a_start_until_it_closes(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 0.1, 0.04, 8);
  thrum_response_def def = swept(&o, 1.15, 6, 9);
  def.periods = 3;
  size_t size = 0;
  assert_int_equal(thrum_response_size(&o.model, &def, &size, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, size);
  memset(memory, 0xff, size);
  curve *c = random_alloc(1, sizeof *c);
  c->rank = 1;
  c->numbers = 19;

  // a swing of a third of the load's frequency, and the linear answer to the load
  double start[19] = {0};
  start[1] = 1.5;
  start[3] = o.force / (1 - 9 * def.from * def.from);
  assert_int_equal(thrum_response(&o.model, &def, start, memory, size, keep, c, &c->report, NULL),
                   THRUM_OK);
  assert_int_equal(c->report.end, THRUM_RESPONSE_END_CLOSED);
  assert_int_equal(c->report.folds, 2);
  assert_true(c->report.balance < 1e-9);
  double low = INFINITY, high = 0;
  for (int n = 0; n < c->count; n++) {
    low = fmin(low, c->points[n].omega);
    high = fmax(high, c->points[n].omega);
    assert_true(hypot(c->coefficients[n][1], c->coefficients[n][10]) > 0.5);
  }
  assert_true(low > 1 && high < def.to && high > 1.2 * low);
  free(c);
  free(memory);
}

static void refused(const thrum_model *model, const thrum_response_def *def, thrum_status status,
                    const char *says) {
  size_t size = 77;
  thrum_error error = {0};
  assert_int_equal(thrum_response_size(model, def, &size, &error), status);
  assert_int_equal(size, 77);
  if (strstr(error.message, says) == NULL)
    fail_msg("'%s' lacks '%s'", error.message, says);
}

static void bad_input_is_refused(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 1, 0.1, 1);
  const double load[1] = {1}, bad[1] = {NAN}, negative[1] = {-1};
  thrum_response_def good = thrum_default_response_def(), def;
  good.from = 0.5;
  good.to = 2;
  good.load_cosine = load;
  refused(NULL, &good, THRUM_INVALID_ARGUMENT, "NULL");
  def = good, def.cookie = 0;
  refused(&o.model, &def, THRUM_UNINITIALISED_DEF, "thrum_default_response_def");
  def = good, def.from = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "above 0");
  def = good, def.to = NAN;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "above 0");
  def = good, def.to = def.from;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "both");
  def = good, def.harmonics = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "harmonics");
  def = good, def.mode = 1;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "mode");
  def = good, def.mode = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "no load");
  def = good, def.step = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "step");
  def = good, def.points = 1;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "points");
  def = good, def.tolerance = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "tolerance");
  def = good, def.periods = 6;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "periods");
  def = good, def.stability_steps = -1;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "stability_steps");
  def = good, def.amplitude = 0;
  refused(&o.model, &def, THRUM_INVALID_ARGUMENT, "amplitude");
  def = good, def.load_cosine = NULL;
  refused(&o.model, &def, THRUM_MISSING, "load that swings");
  def = good, def.load_cosine = bad;
  refused(&o.model, &def, THRUM_BAD_VALUE, "not finite");
  def = good, def.damping = negative;
  refused(&o.model, &def, THRUM_BAD_VALUE, "damping");
  o.model.c4 = NULL;
  refused(&o.model, &good, THRUM_MISSING, "polynomial");
}

/* A force F sin(phase) of which the frequency goes from one to another, slowly; the largest |q| of
 * the last period at each of the frequencies asked for, passed in order. */
static void sweep(const duffing *o, double from, double to, int count, const double *at,
                  double *largest) {
  thrum_model damped = o->model;
  damped.damping = &o->d;
  thrum_state_def def = thrum_default_state_def();
  def.dt = SWEEP_DT;
  def.frequency_matched = 0;
  thrum_state *state = NULL;
  assert_int_equal(thrum_state_create(&damped, &def, &state, NULL), THRUM_OK);

  // the phase is the integral of the frequency, which rests until the start has died away
  double phase = 0, peak = 0, omega = from, before = 0, seen = 0;
  int done = 0;
  for (int step = 0; done < count; step++) {
    double q = 0;
    const double h = def.dt, rate = (to - from) / fabs(to - from) * SWEEP_RATE;
    omega += step * h < SWEEP_REST ? 0 : rate * h;
    const double turned = omega * h;
    const double force = o->force * (cos(phase) - cos(phase + turned)) / turned;
    assert_int_equal(thrum_state_set_force(&damped, state, &force, NULL), THRUM_OK);
    assert_int_equal(thrum_step(&damped, state, NULL), THRUM_OK);
    assert_int_equal(thrum_state_get(&damped, state, &q, NULL, NULL), THRUM_OK);
    phase += turned;

    // the greatest of a parabola through three steps is that between them
    if (seen > before && seen >= q) {
      const double bend = before - 2 * seen + q, slope = 0.5 * (q - before);
      peak = seen - 0.5 * slope * slope / bend;
    }
    before = seen;
    seen = q;
    if ((omega - at[done]) * rate >= 0)
      largest[done++] = peak;
  }
  thrum_state_destroy(state);
}

/* The greatest displacement of the stable motion of a curve at a frequency, the larger or smaller
 * of two. */
static double greatest_at(const curve *c, int harmonics, double omega, bool upper) {
  double found = upper ? 0 : INFINITY;
  for (int n = 1; n < c->count; n++) {
    const thrum_response_point *a = &c->points[n - 1], *b = &c->points[n];
    if ((a->omega - omega) * (b->omega - omega) > 0 || a->unstable > 0 || b->unstable > 0)
      continue;
    double greatest = 0;
    const double share = (omega - a->omega) / (b->omega - a->omega);
    for (int s = 0; s < 2000; s++) {
      double q[2];
      for (int end = 0; end < 2; end++)
        thrum_response_at(1, harmonics, 1, 2 * pi * s / 2000, c->coefficients[n - 1 + end], &q[end],
                          NULL);
      greatest = fmax(greatest, q[0] + share * (q[1] - q[0]));
    }
    found = upper ? fmax(found, greatest) : fmin(found, greatest);
  }
  return found;
}

static void a_slow_sweep_follows_the_stable_branch_and_jumps_at_the_folds(void **context) {
  (void)context;
  duffing o;
  duffing_make(&o, 1, 1, 0.04, 0.05);
  thrum_response_def def = thrum_default_response_def();
  def.from = 0.8;
  def.to = 1.8;
  def.harmonics = 7;
  def.step = 0.005;
  def.damping = &o.d;
  def.load_sine = &o.force;
  curve *c = follow(&o.model, &def);
  double folds[2];
  int count = 0;
  for (int n = 0; n < c->count && count < 2; n++)
    if (c->points[n].kind == THRUM_RESPONSE_FOLD)
      folds[count++] = c->points[n].omega;
  assert_int_equal(count, 2);
  assert_true(folds[0] > folds[1] + 0.1);

  // up along the upper branch past the first fold, and down along the lower one past the second
  const double up[3] = {folds[1] + 0.02, folds[0] - 0.02, folds[0] + SWEEP_LATE};
  const double down[3] = {folds[0] - 0.02, folds[1] + 0.06, folds[1] - SWEEP_LATE};
  const bool upper_up[3] = {true, true, false}, upper_down[3] = {false, false, true};
  double found[3];
  sweep(&o, folds[1] - 0.03, 1.8, 3, up, found);
  for (int n = 0; n < 3; n++)
    assert_true(fabs(found[n] / greatest_at(c, 7, up[n], upper_up[n]) - 1) < 1e-3);
  sweep(&o, folds[0] + 0.03, 0.8, 3, down, found);
  for (int n = 0; n < 3; n++)
    assert_true(fabs(found[n] / greatest_at(c, 7, down[n], upper_down[n]) - 1) < 1e-3);
  free(c);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_slow_sweep_follows_the_stable_branch_and_jumps_at_the_folds),
      cmocka_unit_test(duffings_backbone_is_that_of_elliptic_functions),
      cmocka_unit_test(duffings_forced_curve_and_folds_are_those_of_the_closed_form),
      cmocka_unit_test(a_given_start_may_turn_back_and_ends_as_far_behind_it),
      cmocka_unit_test(motions_between_the_folds_are_unstable_and_no_others),
      cmocka_unit_test(multipliers_of_a_linear_oscillator_are_exponentials),
      cmocka_unit_test(modes_faster_than_the_steps_make_nothing_unstable),
      cmocka_unit_test(every_motion_balances_its_energy_and_solves_the_equation),
      cmocka_unit_test(the_curve_does_not_depend_on_its_steps),
      cmocka_unit_test(units_change_nothing),
      cmocka_unit_test(a_load_on_the_slaves_of_a_condensed_model_does_work),
      cmocka_unit_test(inertia_of_slaves_brings_a_backbone_to_that_of_all_coordinates),
      cmocka_unit_test(the_normal_form_is_the_backbone_at_small_amplitudes),
      cmocka_unit_test(the_normal_form_of_two_modes_has_the_terms_of_their_polynomial),
      cmocka_unit_test(the_normal_form_of_two_modes_is_their_backbone),
      cmocka_unit_test(a_curve_goes_on_along_the_other_one_at_a_branch_point),
      cmocka_unit_test(a_period_doubling_is_a_branch_point_of_two_periods),
      cmocka_unit_test(a_symmetric_oscillator_swings_to_one_side_after_its_symmetry_breaks),
      cmocka_unit_test(an_isola_is_followed_from_a_start_until_it_closes),
      cmocka_unit_test(bad_input_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
