/* Tests of the passes over the coefficients one at a time: each gives what the evaluations of
 * thrum/polynomial.h give, with every kernel, and its cost is that of the terms it meets.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "thrum/kernel_pass.h"

enum { RANK = 9, SPLIT = 5, HIGH = RANK - SPLIT };

/* Memory for the passes of a model. */
typedef struct room {
  double *work, *result;
} room;

static room room_make(const thrum_model *model) {
  const room r = {random_alloc(thrum_work_count(model), sizeof(double)),
                  random_alloc(thrum_pass_result_count(model), sizeof(double))};
  return r;
}

static void room_free(const room *r) {
  free(r->work);
  free(r->result);
}

static void run(const thrum_model *model, int kernel, thrum_pass pass, const double *q,
                const double *v, const room *r) {
  assert_int_equal(
      thrum_pass_run(model, (thrum_kernel_id)kernel, pass, SPLIT, q, v, r->result, r->work, NULL),
      THRUM_OK);
}

static void each_pass_is_the_evaluation_of_its_name(void **context) {
  (void)context;
  static const double q[RANK] = {0.3, -0.1, 0.2, 0.1, -0.2, 0.05, 0.1, -0.05, 0.02};
  static const double v[RANK] = {1, 0.5, -0.5, 0.2, 0.1, -0.3, 0.4, 0.1, -0.2};
  double force[RANK], tangent[RANK * RANK], product[RANK];
  random_model m;
  random_model_make(&m, 5, RANK, 1, 30, 1);
  random_model_pack(&m);
  const room r = room_make(&m.model);
  const double energy = thrum_internal_force(&m.model, q, force, r.work);
  thrum_tangent_stiffness(&m.model, q, tangent, r.work);
  thrum_tangent_product(&m.model, q, v, product, r.work);

  // a kernel that this machine has not stands for the best one
  for (int id = THRUM_KERNEL_BEST; thrum_kernel_name((thrum_kernel_id)id); id++) {
    run(&m.model, id, THRUM_PASS_ENERGY, q, v, &r);
    assert_true(fabs(r.result[0] - energy) <= 1e-12 * fabs(energy));
    run(&m.model, id, THRUM_PASS_FORCE, q, v, &r);
    assert_memory_equal(r.result, force, sizeof force);
    run(&m.model, id, THRUM_PASS_TANGENT, q, v, &r);
    assert_memory_equal(r.result, tangent, sizeof tangent);
    run(&m.model, id, THRUM_PASS_TANGENT_VECTOR, q, v, &r);
    assert_memory_equal(r.result, product, sizeof product);

    // T_II of the restriction is the block of T, but for the quadratic part, which is added to it
    run(&m.model, id, THRUM_PASS_RESTRICT, q, v, &r);
    run(&m.model, id, THRUM_PASS_RESTRICTED_TANGENT, q, v, &r);
    for (int i = 0; i < HIGH; i++)
      for (int j = 0; j < HIGH; j++) {
        const double expected = tangent[(SPLIT + i) * RANK + SPLIT + j];
        assert_true(fabs(r.result[i * HIGH + j] - expected) <= 1e-11 * m.omega2[RANK - 1]);
      }
  }

  room_free(&r);
  random_model_free(&m);
}

static void a_pass_costs_what_its_terms_do(void **context) {
  (void)context;
  const double all = (double)(thrum_c3_count(40) + thrum_c4_count(40));
  const double inner = (double)(thrum_c3_count(4) + thrum_c4_count(4));
  const double held = (double)(thrum_c3_count(36) + thrum_c4_count(36));
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_ENERGY, 0).operations == 2 * all);
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_FORCE, 36).operations == 4 * all);
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_TANGENT, 36).coefficients == all);
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_TANGENT_VECTOR, 0).operations == 8 * all);
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_RESTRICT, 36).coefficients == all - inner - held);
  assert_true(thrum_pass_cost_of(40, THRUM_PASS_RESTRICTED_TANGENT, 36).operations == 6 * inner);

  // a tangent takes pairs of the r(r + 3)/2 monomials of degree 1 and 2
  assert_true(thrum_pass_cost_of(4, THRUM_PASS_TANGENT, 0).coefficients == 14 * 15 / 2);
  assert_true(thrum_pass_cost_of(4, THRUM_PASS_TANGENT_VECTOR, 0).operations == 4 * 14 * 15 / 2);

  // arguments that mean nothing cost nothing
  assert_true(thrum_pass_cost_of(0, THRUM_PASS_ENERGY, 0).operations == 0);
  assert_true(thrum_pass_cost_of(4, THRUM_PASS_COUNT, 0).operations == 0);
  assert_true(thrum_pass_cost_of(4, THRUM_PASS_ENERGY, 5).coefficients == 0);
}

static void wrong_arguments_are_refused(void **context) {
  (void)context;
  static const double q[RANK] = {0};
  random_model m;
  random_model_make(&m, 5, RANK, 1, 30, 1);
  const room r = room_make(&m.model);
  thrum_error error = {0};

  // no model, no such pass, more rows than there are
  assert_int_equal(
      thrum_pass_run(NULL, THRUM_KERNEL_BEST, THRUM_PASS_FORCE, 0, q, q, r.result, r.work, &error),
      THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_pass_run(&m.model, THRUM_KERNEL_BEST, THRUM_PASS_COUNT, 0, q, q, r.result,
                                  r.work, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_pass_run(&m.model, THRUM_KERNEL_BEST, THRUM_PASS_RESTRICT, RANK + 1, q, q,
                                  r.result, r.work, &error),
                   THRUM_INVALID_ARGUMENT);

  room_free(&r);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_pass_is_the_evaluation_of_its_name),
      cmocka_unit_test(a_pass_costs_what_its_terms_do),
      cmocka_unit_test(wrong_arguments_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
