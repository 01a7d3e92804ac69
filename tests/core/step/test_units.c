/* Tests that no unit is special: a body with other units of length and of time, powers of two, has
 * the motion of the first one bit for bit, with every integrator and whatever the monitors,
 * fallbacks and searches do. What compares quantities of different units fails here.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 9, STEPS = 150 };

/* How many of the new units make one of the old ones. */
typedef struct units {
  double length, time;
} units;

/* The same body in other units. Its coordinates have the unit of length times the root of mass. */
static void convert_model(const units *u, random_model *m) {
  const double rate = 1 / (u->time * u->time);
  for (int64_t i = 0; i < m->model.rank; i++)
    m->omega2[i] *= rate;
  for (int64_t k = 0; k < m->model.c3_count; k++)
    m->c3[k] *= rate / u->length;
  for (int64_t k = 0; k < m->model.c4_count; k++)
    m->c4[k] *= rate / (u->length * u->length);
}

/* A run with a start, a load that comes and goes, a kick and a rest, in units; all counts of its
 * report, and the coordinates, momenta and energies of all its steps in the old units. */
typedef struct run {
  double q[STEPS][RANK], p[STEPS][RANK], total[STEPS];
  thrum_status status[STEPS];
  thrum_state_report report;
} run;

/* The run of a def that is given in the old units. */
static void step_all(const thrum_model *model, thrum_state_def def, const units *u, run *out) {
  const double speed = u->length / u->time, force = speed / u->time;
  def.dt *= u->time;
  def.damping_alpha /= u->time;
  def.damping_beta *= u->time;
  thrum_state *state = state_make(model, &def);
  random_state random = {51};
  double q[RANK] = {0.3 * u->length}, p[RANK], load[RANK];
  random_vector(&random, RANK, 4000 * force, load);
  state_put(model, state, q, NULL);

  // one mode that stands still at times, a load so large that fallbacks and switches occur, free
  // motion, and a kick
  for (int k = 0; k < STEPS; k++) {
    if (k == 40 || k == 100)
      state_push(model, state, k == 40 ? load : NULL);
    if (k == 120) {
      state_read(model, state, q, NULL);
      random_vector(&random, RANK, 300 * speed, p);
      state_put(model, state, q, p);
    }
    out->status[k] = thrum_step(model, state, NULL);

    // what it has come to, in the old units
    state_read(model, state, out->q[k], out->p[k]);
    for (int i = 0; i < RANK; i++) {
      out->q[k][i] /= u->length;
      out->p[k][i] /= speed;
    }
    out->total[k] = state_energy(model, state).total / (speed * speed);
  }
  out->report = thrum_state_report_get(state);
  state_free(state);
}

static void assert_alike(const run *a, const run *b) {
  assert_memory_equal(a->status, b->status, sizeof a->status);
  assert_memory_equal(a->q, b->q, sizeof a->q);
  assert_memory_equal(a->p, b->p, sizeof a->p);
  assert_memory_equal(a->total, b->total, sizeof a->total);

  // the same work, and the same measures without a unit
  const thrum_state_report *x = &a->report, *y = &b->report;
  assert_int_equal(x->iterations, y->iterations);
  assert_int_equal(x->factorisations, y->factorisations);
  assert_int_equal(x->newton_steps, y->newton_steps);
  assert_int_equal(x->substep_steps, y->substep_steps);
  assert_int_equal(x->corrections, y->corrections);
  assert_int_equal(x->single_steps, y->single_steps);
  assert_int_equal(x->scheme, y->scheme);
  assert_int_equal(x->explicit_modes, y->explicit_modes);
  assert_true(x->balance_peak == y->balance_peak && x->residual_last == y->residual_last);
  assert_true(x->stability_number_peak == y->stability_number_peak);
}

/* Compares a def in several units with itself in the old ones. */
static void expect_no_unit(const thrum_state_def *def) {
  static const units others[] = {{0x1p30, 0x1p6}, {0x1p-30, 0x1p-5}};
  run *runs = random_alloc(2, sizeof *runs);
  random_model m;
  random_model_make(&m, 52, RANK, 3, 150, 1);
  step_all(&m.model, *def, &(units){1, 1}, runs);

  // the same body made again, since its numbers are converted in place
  for (size_t n = 0; n < sizeof others / sizeof others[0]; n++) {
    random_model other;
    random_model_make(&other, 52, RANK, 3, 150, 1);
    convert_model(others + n, &other);
    step_all(&other.model, *def, others + n, runs + 1);
    assert_alike(runs, runs + 1);
    random_model_free(&other);
  }
  random_model_free(&m);
  free(runs);
}

static void every_integrator_steps_alike_in_all_units(void **context) {
  (void)context;
  for (int n = 0; n < INTEGRATOR_COUNT; n++) {
    if (every_integrator[n] == THRUM_INTEGRATOR_MANIFOLD)
      continue;
    thrum_state_def def = thrum_default_state_def();
    def.integrator = every_integrator[n];
    const bool is_explicit =
        def.integrator == THRUM_INTEGRATOR_VERLET || def.integrator == THRUM_INTEGRATOR_RK4;
    def.dt = is_explicit ? 0.002 : 0.03;
    expect_no_unit(&def);

    // damping that brings the body nearly to rest under the load
    def.damping_alpha = 10;
    def.damping_beta = 1e-4;
    expect_no_unit(&def);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_integrator_steps_alike_in_all_units),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
