/* Newton's method with exact Jacobians, the change of T under the tangent form of damping included:
 * it ends in few iterations where a Jacobian without that part needs many or never ends.
 * SPDX-License-Identifier: Apache-2.0 */
#include "state_support.h"

enum { RANK = 6, LOW = 2 };

static const double start_q[RANK] = {0.9, -0.5, 0.6, 0.3, -0.4, 0.2};
static const double start_p[RANK] = {-2, 3, 1, -2, 2, 1};

/* Iterations of one step of strong tangent damping from a fast, bent start; -1: it failed. */
static int iterations_of(thrum_integrator integrator, int32_t split, double dt, double beta,
                         int32_t most) {
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.dt = dt;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = split;
  def.damping_form = THRUM_DAMPING_TANGENT;
  def.damping_beta = beta;
  def.tolerance = 1e-13;
  def.iterations_max = most;
  def.adaptive = def.ladder = 0;
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, start_q, start_p);
  const thrum_status status = thrum_step(&m.model, state, NULL);
  const int iterations = status < 0 ? -1 : thrum_state_report_get(state).iterations_last;
  state_free(state);
  random_model_free(&m);
  return iterations;
}

static void full_newton_ends_where_quasi_newton_does_not_under_tangent_damping(void **context) {
  (void)context;
  static const double dts[3] = {0.2, 0.4, 0.8}, betas[2] = {0.05, 0.25};
  for (int split = 0; split <= LOW; split += LOW)
    for (int d = 0; d < 3; d++)
      for (int b = 0; b < 2; b++) {
        // quasi-Newton gives up after eight iterations, full Newton is then given eight
        const int iterations = iterations_of(THRUM_INTEGRATOR_IMEXV, split, dts[d], betas[b], 8);
        if (iterations <= 8 || iterations > 16)
          fail_msg("split %d, dt %g, beta %g: %d iterations", split, dts[d], betas[b], iterations);
      }
}

static void newmark_under_tangent_damping_is_solved_by_either(void **context) {
  (void)context;
  static const double dts[3] = {0.05, 0.1, 0.2}, betas[2] = {0.01, 0.05};
  for (int d = 0; d < 3; d++)
    for (int b = 0; b < 2; b++) {
      const int quasi = iterations_of(THRUM_INTEGRATOR_NEWMARK, 0, dts[d], betas[b], 50);
      // with eight iterations each
      const int newton = iterations_of(THRUM_INTEGRATOR_NEWMARK, 0, dts[d], betas[b], 8);
      if (quasi < 1 || newton < 1 || newton > 16)
        fail_msg("dt %g, beta %g: %d and %d iterations", dts[d], betas[b], quasi, newton);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(newmark_under_tangent_damping_is_solved_by_either),
      cmocka_unit_test(full_newton_ends_where_quasi_newton_does_not_under_tangent_damping),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
