/* Models, starts, loads and time steps have any size. Whatever a call answers, the state holds
 * finite numbers alone afterwards, and every byte of it as before when the call failed (design 8).
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "core/base/finite.h"
#include "core/state/state_layout.h"

enum { RANK = 4, ROUNDS = 300, CALLS = 40, INTEGRATORS = 5 };

/* Draws 10^x with x from -limit to limit, or 0. */
static double any_size(random_state *random, double limit) {
  return random_index(random, 12) == 0 ? 0.0 : pow(10.0, limit * random_uniform(random));
}

static void any_vector(random_state *random, double limit, double *out) {
  // one size for all and a sign for each; now and then sizes of their own
  const double size = any_size(random, limit);
  const bool mixed = random_index(random, 3) == 0;
  for (int i = 0; i < RANK; i++)
    out[i] = (mixed ? any_size(random, limit) : size) * random_uniform(random);
}

static thrum_state_def any_def(random_state *random) {
  thrum_state_def def = imexv_def();

  def.integrator = (thrum_integrator)random_index(random, INTEGRATORS);
  def.dt = pow(10.0, 12.0 * random_uniform(random) - 3.0);

  // now and then a step of any size at all
  if (random_index(random, 8) == 0)
    def.dt = pow(10.0, 250.0 * random_uniform(random));

  // choices of every kind
  def.split_rule = (thrum_split_rule)random_index(random, 3);
  def.explicit_count = (int32_t)random_index(random, RANK + 1);
  def.split_form = (thrum_split_form)random_index(random, 3);
  def.damping_form = (thrum_damping_form)random_index(random, 2);
  def.adaptive = (int32_t)random_index(random, 2);
  def.fallback = (int32_t)random_index(random, 2);
  def.solver = (thrum_implicit_solver)random_index(random, 2);
  def.newmark_beta = random_index(random, 3) == 0 ? 0.0 : 0.25;

  if (random_index(random, 2) == 0) {
    def.damping_alpha = any_size(random, 20);
    def.damping_beta = any_size(random, 20);
  }
  return def;
}

static void expect_finite(thrum_state *state, const char *call) {
  const thrum_state_view view = thrum_state_view_of(state);
  const thrum_state_report report = thrum_state_report_get(state);

  // the doubles of the monitor lie side by side in memory
  for (size_t at = 0; at < offsetof(thrum_stability_monitor, samples); at += sizeof(double)) {
    double number;
    memcpy(&number, (const unsigned char *)&state->monitor + at, sizeof number);
    if (!isfinite(number))
      fail_msg("after %s the monitor holds %g at byte %d", call, number, (int)at);
  }

  assert_true(isfinite(state->target.energy) && isfinite(state->target.moved));
  assert_true(isfinite(report.balance_peak) && isfinite(report.stability_number_peak));
  assert_true(isfinite(state->amplitude) && isfinite(report.time));

  // the inverses come last, and count only where one is kept
  for (const double *at = view.q; at < view.inverses; at++)
    if (!isfinite(*at))
      fail_msg("after %s number %d of the arrays is %g", call, (int)(at - view.q), *at);

  if (state->jacobian_kept)
    for (const double *at = view.inverses; at < view.q_next; at++)
      assert_true(isfinite(*at));
}

static void expect_kept(thrum_state *state, const void *before, thrum_status status,
                        const char *call) {
  if (status < 0 && memcmp(state, before, thrum_state_kept_bytes(state)) != 0)
    fail_msg("%s failed with %d and left a trace", call, (int)status);
  expect_finite(state, call);
}

/* Makes one call of any kind; returns whether it succeeded. */
static bool any_call(random_state *random, const thrum_model *model, thrum_state *state,
                     double size) {
  double a[RANK], b[RANK];
  thrum_energies energies;

  void *before = state_snapshot(state);

  thrum_status status;
  const char *name = "thrum_step";
  switch (random_index(random, 12)) {
  case 0:
    any_vector(random, size, a);
    any_vector(random, size, b);
    name = "thrum_state_set";
    status = thrum_state_set(model, state, a, b, NULL);
    break;
  case 1:
    any_vector(random, size, a);
    name = "thrum_state_set_force";
    status = thrum_state_set_force(model, state, a, NULL);
    break;
  case 2:
    name = "thrum_state_set_dt";
    status = thrum_state_set_dt(model, state, any_size(random, 6), NULL);
    break;
  case 3:
    name = "thrum_state_energies";
    status = thrum_state_energies(model, state, &energies, NULL);
    if (status >= 0)
      assert_true(isfinite(energies.total) && isfinite(energies.high));
    break;
  case 4:
    name = "thrum_state_get";
    status = thrum_state_get(model, state, a, b, NULL);
    if (status >= 0)
      assert_true(thrum_all_finite(a, RANK) && thrum_all_finite(b, RANK));
    break;
  default:
    status = thrum_step(model, state, NULL);
    break;
  }

  // whatever it answered, the state is finite, and unchanged if it failed
  expect_kept(state, before, status, name);
  free(before);
  return status >= 0;
}

static void no_call_leaves_a_number_that_is_not_finite(void **context) {
  (void)context;
  random_state random = {2024};
  int done = 0, failed = 0;
  for (int round = 0; round < ROUNDS; round++) {
    // a random model and def
    random_model m;
    const double stiff = pow(10.0, 8.0 * random_uniform(&random));
    random_model_make(&m, (uint64_t)round, RANK, stiff, 20.0 * stiff,
                      pow(10.0, 4.0 * random_uniform(&random)));
    const thrum_state_def def = any_def(&random);
    thrum_state *state = state_make(&m.model, &def);

    // loads and starts of extreme size in every other round
    const double size = round % 2 == 0 ? 160.0 : 6.0;
    for (int call = 0; call < CALLS; call++)
      any_call(&random, &m.model, state, size) ? done++ : failed++;

    state_free(state);
    random_model_free(&m);
  }

  // both ways were taken often
  assert_true(done > ROUNDS * CALLS / 4 && failed > ROUNDS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(no_call_leaves_a_number_that_is_not_finite),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
