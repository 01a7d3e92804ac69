/* Fast and slow together: what Stern and Grinspun (2009, Implicit-explicit variational integration
 * of highly oscillatory problems, doi:10.1137/080732936) promise of the split that imexv makes, on
 * their problems, stepped as polynomial models.
 *
 * The Fermi-Pasta-Ulam chain of Hairer, Lubich and Wanner (Geometric Numerical Integration,
 * doi:10.1007/3-540-30666-8, I.5.1): three stiff linear springs, omega = 50, between soft quartic
 * ones. x_i are the slow coordinates, y_i the stretches of the stiff springs; the oscillatory
 * energies I_i = 1/2 (y_i'^2 + omega^2 y_i^2) pass from one spring to the next while their sum
 * stays.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "core/base/pi.h"
#include "thrum/polynomial.h"
#include "validation/published/published.h"

#define SPRINGS 3
#define RANK (2 * SPRINGS)
#define OMEGA 50.0
#define LOST 1e4
#define FAR 1000.0 /* how long the chain runs where resonances are looked for [s] */

/* The results of a run. */
typedef struct chain_run {
  bool lost;           /* a step failed, or the energy passed 1e4 times the first */
  double energy_error; /* largest |H - H_0| / H_0 */
  double energy_rms;   /* its root mean square, which the chaos of the chain leaves in peace */
  double fast_error;   /* largest |I - I_0| / I_0 of the sum */
  double exchange;     /* time at which I_3 first exceeds I_1, of means over a unit of time; NaN */
} chain_run;

/* omega2 ascending: the slow coordinates, then the stretches. */
static void make_chain(published_polynomial *p) {
  const double omega2[RANK] = {0, 0, 0, OMEGA * OMEGA, OMEGA * OMEGA, OMEGA * OMEGA};
  published_polynomial_make(p, RANK, omega2);
  // soft springs: wall to first, between, last to wall; a quarter of the fourth power each
  published_polynomial_add(p, 0.25, (const double[RANK]){1, 0, 0, -1, 0, 0});
  published_polynomial_add(p, 0.25, (const double[RANK]){-1, 1, 0, -1, -1, 0});
  published_polynomial_add(p, 0.25, (const double[RANK]){0, -1, 1, 0, -1, -1});
  published_polynomial_add(p, 0.25, (const double[RANK]){0, 0, 1, 0, 0, 1});
}

static void fast_energies(const double *q, const double *p, double fast[SPRINGS]) {
  for (int i = 0; i < SPRINGS; i++)
    fast[i] =
        0.5 * (p[SPRINGS + i] * p[SPRINGS + i] + OMEGA * OMEGA * q[SPRINGS + i] * q[SPRINGS + i]);
}

/* Steps the chain for `time` s and records its energies. */
static thrum_status run_chain(const thrum_state_def *def, double time, chain_run *run,
                              thrum_error *error) {
  static const double q0[RANK] = {1, 0, 0, 1 / OMEGA, 0, 0}, p0[RANK] = {1, 0, 0, 1, 0, 0};
  published_polynomial chain;
  make_chain(&chain);
  thrum_state *state = NULL;
  THRUM_TRY(published_state(&chain.model, def, q0, p0, &state, error));

  // the first energies are those that all others are compared with
  double first = 0, fast_first = 0, mean[SPRINGS] = {0};
  const int64_t steps = thrum_step_count(time, def->dt);
  *run = (chain_run){.exchange = NAN};
  for (int64_t k = 0; k <= steps && !run->lost; k++) {
    double q[RANK], p[RANK], fast[SPRINGS];
    thrum_energies now;

    // a run that cannot go on is lost, and its figures end there
    if (k > 0)
      run->lost = thrum_step(&chain.model, state, NULL) < 0;
    run->lost = run->lost || thrum_state_get(&chain.model, state, q, p, NULL) < 0 ||
                thrum_state_energies(&chain.model, state, &now, NULL) < 0;
    if (run->lost)
      break;

    // the total must stay, and the sum of the fast energies is an adiabatic invariant
    fast_energies(q, p, fast);
    const double sum = fast[0] + fast[1] + fast[2];
    first = k == 0 ? now.total : first;
    fast_first = k == 0 ? sum : fast_first;
    run->lost = !(now.total < LOST * first);
    run->energy_error = fmax(run->energy_error, fabs(now.total / first - 1));
    run->energy_rms += (now.total / first - 1) * (now.total / first - 1);
    run->fast_error = fmax(run->fast_error, fabs(sum / fast_first - 1));

    // the energies wiggle at the fast frequency: means over about a unit of time
    for (int i = 0; i < SPRINGS; i++)
      mean[i] += fmin(1, def->dt) * ((k == 0 ? fast[i] / def->dt : fast[i]) - mean[i]);
    if (isnan(run->exchange) && mean[2] > mean[0])
      run->exchange = (double)k * def->dt;
  }

  run->energy_rms = sqrt(run->energy_rms / (double)(steps + 1));
  thrum_state_destroy(state);
  return THRUM_OK;
}

/* imexv with the stretches implicit and nothing that adapts. */
static thrum_state_def imexv_def(double dt, thrum_split_form form) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  def.dt = dt;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = SPRINGS;
  def.split_form = form;
  def.adaptive = 0;
  def.fallback = 0;
  def.tolerance = 1e-12;
  return def;
}

/* The largest h at which a run is not lost, between a stable and an unstable one. */
static double largest_stable(bool (*lost)(double dt), double stable, double unstable) {
  for (int k = 0; k < 12; k++) {
    const double middle = 0.5 * (stable + unstable);
    if (lost(middle))
      unstable = middle;
    else
      stable = middle;
  }
  return stable;
}

static bool verlet_is_lost(double dt) {
  thrum_state_def def = imexv_def(dt, THRUM_FORM_THESIS);
  chain_run run = {.lost = true};
  def.integrator = THRUM_INTEGRATOR_VERLET;
  return run_chain(&def, 200, &run, NULL) < 0 || run.lost;
}

/* Energy error, root mean square, at h omega = k pi over that 0.2 and 0.4 beside it. */
static thrum_status resonance(thrum_split_form form, int k, double *ratio, thrum_error *error) {
  double errors[5];
  for (int n = 0; n < 5; n++) {
    const thrum_state_def def = imexv_def((k * THRUM_PI + 0.2 * (n - 2)) / OMEGA, form);
    chain_run run;
    THRUM_TRY(run_chain(&def, FAR, &run, error));
    errors[n] = run.lost ? INFINITY : run.energy_rms;
  }
  *ratio = errors[2] / (0.25 * (errors[0] + errors[1] + errors[3] + errors[4]));
  return THRUM_OK;
}

static thrum_status add_exchange(const published_sink *sink, const char *quantity,
                                 thrum_split_form form, double exchange, thrum_error *error) {
  static const double steps[] = {0.03, 0.015, 0.0075, 0.00375, 0.001875};
  for (int n = 0; n < 3 + (sink->level > 0 ? 2 : 0); n++) {
    const thrum_state_def def = imexv_def(steps[n], form);
    chain_run run;
    char setting[64];
    THRUM_TRY(run_chain(&def, 200, &run, error));
    snprintf(setting, sizeof setting, "h = %g s", steps[n]);
    published_add(sink, "fermi", quantity, setting, 0, exchange, run.exchange);
  }
  return THRUM_OK;
}

thrum_status published_fermi(const published_sink *sink, thrum_error *error) {
  static const int orders[] = {1, 2, 4};
  chain_run run;
  // what the exchange should be: the conserving integrator at h omega = 0.025
  thrum_state_def def = imexv_def(0.0005, THRUM_FORM_QUADRATIC);
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  THRUM_TRY(run_chain(&def, 100, &run, error));
  const double exchange = run.exchange;

  // the largest step, and the energy error at 0.03 s of both splits
  published_add(sink, "fermi", "Verlet: largest stable h, s", "200 s", 0, 2 / OMEGA,
                largest_stable(verlet_is_lost, 0.03, 0.045));
  def = imexv_def(0.03, THRUM_FORM_QUADRATIC);
  THRUM_TRY(run_chain(&def, 200, &run, error));
  published_add(sink, "fermi", "quadratic split: energy error", "h = 0.03 s, 200 s", 0, 1e-3,
                run.energy_error);
  def = imexv_def(0.03, THRUM_FORM_THESIS);
  THRUM_TRY(run_chain(&def, 200, &run, error));
  published_add(sink, "fermi", "thesis split: energy error", "h = 0.03 s, 200 s", 0, 1e-3,
                run.energy_error);

  // the errors at the resonances h omega = n pi over those beside them
  for (int n = 0; n < 3; n++) {
    double ratio[2];
    char setting[64];
    THRUM_TRY(resonance(THRUM_FORM_QUADRATIC, orders[n], &ratio[0], error));
    THRUM_TRY(resonance(THRUM_FORM_THESIS, orders[n], &ratio[1], error));
    snprintf(setting, sizeof setting, "h omega = %d pi, 1000 s", orders[n]);
    published_add(sink, "fermi", "quadratic split: error at a resonance over beside it", setting, 0,
                  1, ratio[0]);
    published_add(sink, "fermi", "thesis split: error at a resonance over beside it", setting, 0, 1,
                  ratio[1]);
  }

  // the slow exchange between the springs
  THRUM_TRY(add_exchange(sink, "quadratic split: time of the exchange, s", THRUM_FORM_QUADRATIC,
                         exchange, error));
  return add_exchange(sink, "thesis split: time of the exchange, s", THRUM_FORM_THESIS, exchange,
                      error);
}

/* A slow oscillator of frequency 1 and a fast one of 50, V = 1/2 x^2 + 1250 y^2 + c x^2 y^2. */
static bool pair_is_lost_with(double dt, thrum_split_form form) {
  static const double q0[2] = {1, 0.01}, p0[2] = {0, 0};
  published_polynomial pair;
  published_polynomial_make(&pair, 2, (const double[2]){1, OMEGA * OMEGA});
  pair.c4[thrum_c4_index(2, 0, 0, 1, 1)] = 1;

  // only the slow oscillator is explicit
  thrum_state_def def = imexv_def(dt, form);
  def.explicit_count = 1;
  thrum_state *state = NULL;
  if (published_state(&pair.model, &def, q0, p0, &state, NULL) < 0)
    return true;

  thrum_energies first = {0}, now = {0};
  bool lost = thrum_state_energies(&pair.model, state, &first, NULL) < 0;
  for (int k = 0; k < 5000 && !lost; k++)
    lost = thrum_step(&pair.model, state, NULL) < 0 ||
           thrum_state_energies(&pair.model, state, &now, NULL) < 0 ||
           !(now.total < LOST * first.total);
  thrum_state_destroy(state);
  return lost;
}

static bool quadratic_is_lost(double dt) {
  return pair_is_lost_with(dt, THRUM_FORM_QUADRATIC);
}

static bool thesis_is_lost(double dt) {
  return pair_is_lost_with(dt, THRUM_FORM_THESIS);
}

thrum_status published_fast_slow(const published_sink *sink, thrum_error *error) {
  (void)error;
  // stable where the slow oscillator is, h < 2, whatever the fast one does: h omega up to 100
  published_add(sink, "fast_slow", "quadratic split: largest stable h, s", "5000 steps", 0, 2,
                largest_stable(quadratic_is_lost, 0.5, 2.5));
  published_add(sink, "fast_slow", "thesis split: largest stable h, s", "5000 steps", 0, 2,
                largest_stable(thesis_is_lost, 0.5, 2.5));
  return THRUM_OK;
}
