/* Newton's method with exact Jacobians, the change of T under the tangent form of damping included:
 * it ends in few iterations where a Jacobian without that part needs many or never ends.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "core/polynomial/polynomial_private.h"
#include "core/solve/implicit_problem.h"

enum { RANK = 6, LOW = 2 };

static const double start_q[RANK] = {0.9, -0.5, 0.6, 0.3, -0.4, 0.2};
static const double start_p[RANK] = {-2, 3, 1, -2, 2, 1};

/* Counts the iterations of one step of strong tangent damping from a fast, bent start; -1 when it
 * failed. */
static int iterations_of(thrum_integrator integrator, int32_t split, double dt, double beta,
                         int32_t most) {
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  thrum_state_def def = imexv_def();
  def.integrator = integrator;
  def.split_form = THRUM_FORM_THESIS;
  def.dt = dt;
  def.split_rule = THRUM_SPLIT_COUNT;
  def.explicit_count = split;
  def.damping_form = THRUM_DAMPING_TANGENT;
  def.damping_beta = beta;
  def.tolerance = 1e-13;
  def.iterations_max = most;
  def.adaptive = def.fallback = 0;

  // without fallback and monitor the counter is that of the one solve
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

      // quasi-Newton, and full Newton after it, may take eight iterations each
      const int newton = iterations_of(THRUM_INTEGRATOR_NEWMARK, 0, dts[d], betas[b], 8);
      if (quasi < 1 || newton < 1 || newton > 16)
        fail_msg("dt %g, beta %g: %d and %d iterations", dts[d], betas[b], quasi, newton);
    }
}

/* Computes the scaled residual of Newmark's equation (design 6) for the step from q, p and a that
 * `state` has taken under the load f, over what the solve allows. */
static double residual_of(const random_model *m, thrum_state *state, const thrum_state_def *def,
                          const double *q, const double *p, const double *a, const double *f,
                          double *work) {
  const int32_t n = (int32_t)m->model.rank;
  const double h = def->dt;
  double next[16], force[16], residual = 0, step = 0, rounding = 0;
  assert_int_equal(thrum_state_get(&m->model, state, next, NULL, NULL), THRUM_OK);
  thrum_internal_force(&m->model, next, force, work);

  for (int32_t i = 0; i < n; i++) {
    const double damping = def->damping_alpha + def->damping_beta * m->model.omega2[i];
    const double scale = 1 + 0.25 * h * h * m->model.omega2[i] + 0.5 * h * damping;
    const double d = next[i] - q[i], v = 2 * d / h - p[i];

    // the terms of the equation, each weighted by the scale of its mode
    const double g =
        d - h * p[i] - 0.25 * h * h * a[i] + 0.25 * h * h * (force[i] + damping * v - f[i]);

    residual += g * g / scale;
    step += d * d * scale;
    rounding += (q[i] * q[i] + next[i] * next[i]) * scale +
                0.25 * h * h * h * h * force[i] * force[i] / scale;
  }
  return sqrt(residual) / (def->tolerance * sqrt(step) + THRUM_ROUNDING_FLOOR * state->amplitude +
                           1e-14 * sqrt(rounding));
}

/* Random models move violently under loads that jump. A correction that is not evaluated is as
 * good as promised also where it meets a direction in which the body is soft: there it is large
 * beside the residual that it comes from. */
static void steps_that_end_without_an_evaluation_solve_their_equation(void **context) {
  (void)context;
  for (uint64_t seed = 5210; seed < 5220; seed++) {
    // a random model: frequencies, and how nonlinear it is
    random_state random = {seed * 7919 + 1};
    const int32_t n = 1 + (int32_t)random_index(&random, 10);
    const double omega = exp(3 * random_uniform(&random) + 3);
    const double amplitude = random_index(&random, 6) ? 1 : INFINITY;
    const double last = omega * (1 + 20 * fabs(random_uniform(&random)));
    random_model m;
    random_model_make(&m, seed, n, omega, last, amplitude);

    // Newmark at random steps, damping and tolerances
    thrum_state_def def = imexv_def();
    random_index(&random, 2);
    def.integrator = THRUM_INTEGRATOR_NEWMARK;
    def.dt = exp(3 * random_uniform(&random)) / omega;
    if (random_index(&random, 3) == 0) {
      def.damping_alpha = fabs(random_uniform(&random));
      def.damping_beta = 1e-3 * fabs(random_uniform(&random));
    }
    def.tolerance = pow(10, -3 - 9 * fabs(random_uniform(&random)));

    thrum_state *state = state_make(&m.model, &def);
    double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof *work);

    // a start and loads of random size
    double q[16], p[16], a[16], f[16] = {0};
    const double size = exp(5 * random_uniform(&random) - 2);
    random_vector(&random, n, size, q);
    random_vector(&random, n, size * omega, p);
    state_put(&m.model, state, q, p);

    const bool jumps = random_index(&random, 2) != 0;
    for (int k = 0; k < 300; k++) {
      if (jumps && k % 50 == 20) {
        random_vector(&random, n, size * omega * omega * exp(3 * random_uniform(&random)), f);
        assert_int_equal(thrum_state_set_force(&m.model, state, f, NULL), THRUM_OK);
      }

      // the state before the step, with the acceleration under the new load
      assert_int_equal(thrum_state_get(&m.model, state, q, p, NULL), THRUM_OK);
      const thrum_state_view view = thrum_state_view_of(state);
      for (int32_t i = 0; i < n; i++)
        a[i] = view.acceleration[i] + f[i] - view.load_before[i];

      // steps in parts satisfy other equations, and are passed over
      const int64_t fallback_levels = thrum_state_report_get(state).substep_steps;
      if (thrum_step(&m.model, state, NULL) < 0)
        break;
      if (thrum_state_report_get(state).substep_steps > fallback_levels)
        continue;

      const double left = residual_of(&m, state, &def, q, p, a, f, work);
      if (!(left < 1000))
        fail_msg("seed %d, step %d: %g times the tolerance", (int)seed, k, left);
    }

    free(work);
    state_free(state);
    random_model_free(&m);
  }
}

/* --- the solver newton ------------------------------------------------------------------------ */

/* A Jacobian in every iteration leads to the solution that quasi-Newton finds, in every scheme. */
static void both_solvers_lead_to_the_same_steps(void **context) {
  (void)context;
  static const struct {
    thrum_integrator integrator;
    thrum_split_form form;
  } cases[] = {{THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS},
               {THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION},
               {THRUM_INTEGRATOR_MIDPOINT, THRUM_FORM_THESIS},
               {THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS},
               {THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS}};
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++)
    for (int damped = 0; damped < 3; damped++) {
      thrum_state_def def = imexv_def();
      def.integrator = cases[n].integrator;
      def.split_form = cases[n].form;
      def.split_rule = THRUM_SPLIT_COUNT;
      def.explicit_count = LOW;
      def.dt = 0.05;
      def.tolerance = 1e-13;
      def.adaptive = def.fallback = 0;
      def.damping_form = damped == 2 ? THRUM_DAMPING_TANGENT : THRUM_DAMPING_REST;
      def.damping_beta = damped > 0 ? 0.01 : 0;

      thrum_state *quasi = state_make(&m.model, &def);
      def.solver = THRUM_SOLVER_NEWTON;
      thrum_state *newton = state_make(&m.model, &def);
      state_put(&m.model, quasi, start_q, start_p);
      state_put(&m.model, newton, start_q, start_p);
      state_steps(&m.model, quasi, 100);
      state_steps(&m.model, newton, 100);

      double q[2][RANK], p[2][RANK];
      state_read(&m.model, quasi, q[0], p[0]);
      state_read(&m.model, newton, q[1], p[1]);
      if (!(largest_difference(q[0], q[1], RANK) < 1e-9 &&
            largest_difference(p[0], p[1], RANK) < 1e-8))
        fail_msg("case %d, damping %d", (int)n, damped);

      // an inverse for each correction, and full Newton never
      const thrum_state_report report = thrum_state_report_get(newton);
      assert_true(report.iterations > 100 && report.factorisations == report.iterations);
      assert_int_equal(report.newton_steps, 0);

      state_free(quasi);
      state_free(newton);
    }
  random_model_free(&m);
}

/* The thesis' scheme with the thesis' solver and nothing around them: where it is lost it says so,
 * from a finite state, and no part of the fallback chain or of the monitor has acted. */
static void the_thesis_alone_is_lost_by_itself_and_says_so(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 21, RANK, 1.0, 12.0, 0.5);
  for (int alone = 0; alone < 2; alone++) {
    thrum_state_def def = imexv_def();
    def.split_form = THRUM_FORM_THESIS;
    def.split_rule = THRUM_SPLIT_COUNT;
    def.explicit_count = LOW;
    def.dt = 0.3;
    def.solver = THRUM_SOLVER_NEWTON;
    def.adaptive = def.fallback = !alone;
    thrum_state *state = state_make(&m.model, &def);
    const double large[RANK] = {6, 4, 3, 2, 1, 1};
    state_put(&m.model, state, large, NULL);

    // the step that fails leaves the bytes before it
    thrum_status status = THRUM_OK;
    void *kept = NULL;
    for (int k = 0; k < 2000 && status >= 0; k++) {
      free(kept);
      kept = state_snapshot(state);
      status = thrum_step(&m.model, state, NULL);
    }

    const thrum_state_report report = thrum_state_report_get(state);
    if (alone) {
      double q[RANK], p[RANK];
      assert_true(status == THRUM_NOT_CONVERGED || status == THRUM_NOT_FINITE);
      assert_memory_equal(state, kept, thrum_state_kept_bytes(state));
      state_read(&m.model, state, q, p);
      for (int i = 0; i < RANK; i++)
        assert_true(isfinite(q[i]) && isfinite(p[i]));
      assert_int_equal(report.newton_steps + report.energy_steps + report.substep_steps, 0);
      assert_int_equal(report.switched_steps + report.corrections + report.split_changes, 0);
      assert_int_equal(report.factorisations, report.iterations);
    } else {
      assert_true(status >= 0);
      assert_true(report.newton_steps + report.energy_steps + report.switched_steps > 0);
    }

    free(kept);
    state_free(state);
  }
  random_model_free(&m);
}

/* A step says how well it is solved, often of an iterate that it has not evaluated. The midpoint
 * rule has no memory but q and p, so a step that is solved to rounding from the same q and p shows
 * it. */
static void a_step_is_as_near_its_solution_as_it_says(void **context) {
  (void)context;
  enum { MODES = 8, STEPS = 300 };
  random_model m;
  random_model_make(&m, 21, MODES, 1.0, 60.0, 0.5);
  int estimated = 0;
  for (double momentum = 0.5; momentum < 20.0; momentum *= 3.0)
    for (double tolerance = 1e-4; tolerance > 1e-9; tolerance *= 1e-2) {
      thrum_state_def def = thrum_default_state_def();
      def.integrator = THRUM_INTEGRATOR_MIDPOINT;
      def.dt = 0.05;
      def.tolerance = tolerance;
      thrum_state *state = state_make(&m.model, &def);
      def.tolerance = 1e-13;
      thrum_state *exact = state_make(&m.model, &def);
      double q[3][MODES], p[MODES];
      for (int i = 0; i < MODES; i++)
        p[i] = (i % 2 ? momentum : -momentum) / (i + 1);
      state_put(&m.model, state, NULL, p);

      // both from the same q and p
      for (int k = 0; k < STEPS; k++) {
        state_read(&m.model, state, q[0], p);
        state_put(&m.model, exact, q[0], p);
        state_steps(&m.model, state, 1);
        state_steps(&m.model, exact, 1);
        state_read(&m.model, state, q[1], NULL);
        state_read(&m.model, exact, q[2], NULL);
        double error = 0, step = 0;
        for (int i = 0; i < MODES; i++) {
          error += (q[1][i] - q[2][i]) * (q[1][i] - q[2][i]);
          step += (q[2][i] - q[0][i]) * (q[2][i] - q[0][i]);
        }
        const double said = thrum_state_report_get(state).residual_last;
        if (!(sqrt(error / step) <= 1.3 * said + 1e-12))
          fail_msg("momentum %g, tolerance %g, step %d: off by %g, and says %g", momentum,
                   tolerance, k, sqrt(error / step), said);
        estimated += said > 1e-10;
      }
      state_free(exact);
      state_free(state);
    }
  assert_true(estimated > 1000);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(steps_that_end_without_an_evaluation_solve_their_equation),
      cmocka_unit_test(newmark_under_tangent_damping_is_solved_by_either),
      cmocka_unit_test(full_newton_ends_where_quasi_newton_does_not_under_tangent_damping),
      cmocka_unit_test(both_solvers_lead_to_the_same_steps),
      cmocka_unit_test(the_thesis_alone_is_lost_by_itself_and_says_so),
      cmocka_unit_test(a_step_is_as_near_its_solution_as_it_says),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
