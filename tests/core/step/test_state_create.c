/* Tests of states in heap memory, names of the choices of a def, and the number of steps in a time.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

enum { RANK = 4 };

static void a_created_state_is_one_laid_into_memory(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  const thrum_state_def def = imexv_def();
  const double q[RANK] = {0.1, -0.2, 0.05, 0.02};

  thrum_state *laid = state_make(&m.model, &def), *created = NULL;
  assert_int_equal(thrum_state_create(&m.model, &def, &created, NULL), THRUM_OK);
  assert_int_equal((uintptr_t)created % 64, 0);
  assert_int_equal(thrum_state_bytes(created), thrum_state_bytes(laid));

  // both move alike, byte for byte
  state_put(&m.model, laid, q, NULL);
  state_put(&m.model, created, q, NULL);
  state_steps(&m.model, laid, 50);
  state_steps(&m.model, created, 50);
  assert_memory_equal(laid, created, thrum_state_kept_bytes(laid));

  thrum_state_destroy(created);
  thrum_state_destroy(NULL);
  state_free(laid);
  random_model_free(&m);
}

static void creation_refuses_what_size_refuses(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  thrum_state_def def = imexv_def();
  thrum_state *state = NULL;
  thrum_error error = {.status = THRUM_OK};
  assert_int_equal(thrum_state_create(&m.model, &def, NULL, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_state_create(NULL, &def, &state, NULL), THRUM_INVALID_ARGUMENT);
  def.dt = -1.0;
  assert_int_equal(thrum_state_create(&m.model, &def, &state, &error), THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "dt"));
  assert_null(state);
  random_model_free(&m);
}

static void every_choice_has_a_name_that_leads_back(void **context) {
  (void)context;

  for (int n = 0; n < INTEGRATOR_COUNT; n++) {
    thrum_integrator found = THRUM_INTEGRATOR_ENERGY;
    const char *name = thrum_integrator_name((thrum_integrator)n);
    assert_int_equal(thrum_integrator_from_name(name, &found, NULL), THRUM_OK);
    assert_int_equal((int)found, n);
  }

  for (int n = 0; n < 2; n++) {
    thrum_damping_form damping = THRUM_DAMPING_REST;
    assert_int_equal(thrum_damping_form_from_name(thrum_damping_form_name((thrum_damping_form)n),
                                                  &damping, NULL),
                     THRUM_OK);
    assert_int_equal((int)damping, n);
  }

  for (int n = 0; n < 3; n++) {
    thrum_split_form split = THRUM_FORM_THESIS;
    assert_int_equal(
        thrum_split_form_from_name(thrum_split_form_name((thrum_split_form)n), &split, NULL),
        THRUM_OK);
    assert_int_equal((int)split, n);
  }

  for (int n = 0; n < 2; n++) {
    thrum_implicit_solver solver = THRUM_SOLVER_QUASI_NEWTON;
    const char *name = thrum_implicit_solver_name((thrum_implicit_solver)n);
    assert_int_equal(thrum_implicit_solver_from_name(name, &solver, NULL), THRUM_OK);
    assert_int_equal((int)solver, n);
  }

  // the names themselves are part of the interface
  assert_string_equal(thrum_integrator_name(THRUM_INTEGRATOR_MIDPOINT), "midpoint");
  assert_string_equal(thrum_split_rule_name(THRUM_SPLIT_SAMPLING), "sampling");
  assert_string_equal(thrum_scheme_name(THRUM_SCHEME_NEWMARK), "newmark");
}

static void a_number_or_a_text_that_names_nothing_is_refused(void **context) {
  (void)context;
  assert_null(thrum_integrator_name((thrum_integrator)INTEGRATOR_COUNT));
  assert_null(thrum_integrator_name((thrum_integrator)-1));
  assert_null(thrum_damping_form_name((thrum_damping_form)2));
  assert_null(thrum_split_rule_name((thrum_split_rule)3));
  assert_null(thrum_split_form_name((thrum_split_form)3));
  assert_null(thrum_implicit_solver_name((thrum_implicit_solver)2));
  assert_null(thrum_scheme_name((thrum_scheme)99));

  // a refusal lists the names that there are, and leaves the output as it was
  thrum_integrator found = THRUM_INTEGRATOR_VERLET;
  thrum_error error = {.status = THRUM_OK};
  assert_int_equal(thrum_integrator_from_name("euler", &found, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal((int)found, THRUM_INTEGRATOR_VERLET);
  assert_string_equal(error.message,
                      "'euler' is no integrator; there are imexv newmark verlet midpoint energy "
                      "fox-goodwin backward-euler semi-implicit-euler rk4 manifold");
  assert_int_equal(thrum_integrator_from_name(NULL, &found, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_integrator_from_name("", &found, NULL), THRUM_INVALID_ARGUMENT);

  // each list of names, and whether a name is one of it, without an output
  thrum_damping_form damping = THRUM_DAMPING_TANGENT;
  thrum_split_form split = THRUM_FORM_QUADRATIC;
  thrum_implicit_solver solver = THRUM_SOLVER_NEWTON;
  assert_int_equal(thrum_damping_form_from_name("none", &damping, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_split_form_from_name("none", &split, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_implicit_solver_from_name("none", &solver, NULL), THRUM_INVALID_ARGUMENT);
  assert_true(damping == THRUM_DAMPING_TANGENT && split == THRUM_FORM_QUADRATIC &&
              solver == THRUM_SOLVER_NEWTON);
  assert_int_equal(thrum_integrator_from_name("verlet", NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_damping_form_from_name("rest", NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_split_form_from_name("thesis", NULL, NULL), THRUM_OK);
  assert_int_equal(thrum_implicit_solver_from_name("newton", NULL, NULL), THRUM_OK);
}

static void steps_are_counted_up_to_rounding(void **context) {
  (void)context;
  assert_int_equal(thrum_step_count(0.3, 0.003), 100);
  assert_int_equal(thrum_step_count(10.0, 0.003), 3334);
  assert_int_equal(thrum_step_count(0.003, 0.003), 1);
  assert_int_equal(thrum_step_count(1e-4, 0.003), 1);
  assert_int_equal(thrum_step_count(1e-10, 0.003), 0);
  assert_int_equal(thrum_step_count(0.0, 0.003), 0);
  assert_int_equal(thrum_step_count(-1.0, 0.003), 0);
  assert_int_equal(thrum_step_count(1.0, 0.0), 0);
  assert_int_equal(thrum_step_count(NAN, 0.003), 0);
  assert_int_equal(thrum_step_count(1.0, NAN), 0);
  assert_true(thrum_step_count(INFINITY, 0.003) == INT64_MAX);
  assert_true(thrum_step_count(1.0, 1e-300) == INT64_MAX);
}

static void many_steps_are_as_many_single_ones(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  const thrum_state_def def = imexv_def();
  const double q[RANK] = {0.1, -0.2, 0.05, 0.02};
  thrum_state *once = state_make(&m.model, &def), *often = state_make(&m.model, &def);
  state_put(&m.model, once, q, NULL);
  state_put(&m.model, often, q, NULL);

  // the same bits, and no step where none is asked for
  int64_t made = -1;
  assert_int_equal(thrum_steps(&m.model, once, 0, &made, NULL), THRUM_OK);
  assert_int_equal(made, 0);
  assert_int_equal(thrum_steps(&m.model, once, 50, &made, NULL), THRUM_OK);
  assert_int_equal(made, 50);
  state_steps(&m.model, often, 50);
  assert_memory_equal(once, often, thrum_state_kept_bytes(once));

  // a call that is refused leaves the count
  assert_int_equal(thrum_steps(&m.model, once, -1, &made, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(made, 50);
  assert_int_equal(thrum_steps(&m.model, NULL, 1, NULL, NULL), THRUM_INVALID_ARGUMENT);
  state_free(once);
  state_free(often);
  random_model_free(&m);
}

static void many_steps_end_before_the_one_that_fails(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  thrum_state_def def = imexv_def();
  // explicit, beyond its limit of stability: it grows until a number overflows
  def.integrator = THRUM_INTEGRATOR_RK4;
  def.dt = 1.0;
  const double q[RANK] = {0.1, -0.2, 0.05, 0.02};
  thrum_state *state = state_make(&m.model, &def);
  state_put(&m.model, state, q, NULL);

  int64_t made = -1;
  thrum_error error = {.status = THRUM_OK};
  assert_int_equal(thrum_steps(&m.model, state, 10000, &made, &error), THRUM_NOT_FINITE);
  assert_true(made < 10000);
  assert_int_equal(made, thrum_state_report_get(state).steps);
  double end[RANK];
  assert_int_equal(thrum_state_get(&m.model, state, end, NULL, NULL), THRUM_OK);
  for (int i = 0; i < RANK; ++i)
    assert_true(isfinite(end[i]));
  state_free(state);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_created_state_is_one_laid_into_memory),
      cmocka_unit_test(creation_refuses_what_size_refuses),
      cmocka_unit_test(every_choice_has_a_name_that_leads_back),
      cmocka_unit_test(a_number_or_a_text_that_names_nothing_is_refused),
      cmocka_unit_test(steps_are_counted_up_to_rounding),
      cmocka_unit_test(many_steps_are_as_many_single_ones),
      cmocka_unit_test(many_steps_end_before_the_one_that_fails),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
