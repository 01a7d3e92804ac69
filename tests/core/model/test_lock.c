/* Tests of models whose highest coordinates are held at zero: they are those made by hand from the
 * lowest ones, bit for bit, and their energy is that of the whole with the others at zero.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "thrum/polynomial.h"

static void *lock_model(const thrum_model *model, int64_t rank, const thrum_model **lower) {
  size_t size = 0;
  thrum_error error;
  if (thrum_model_lock_size(model, rank, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  if (thrum_model_lock(memory, size, model, rank, lower, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return memory;
}

static void a_locked_model_is_the_one_made_by_hand(void **context) {
  (void)context;
  enum { RANK = 9, VERTICES = 7 };
  random_model m;
  random_model_make_wild(&m, 3, RANK);
  random_model_add_mesh(&m, 5, VERTICES);
  for (int64_t r = 1; r <= RANK; r++) {
    // the counts are those of the rank
    const thrum_model *lower = NULL;
    void *memory = lock_model(&m.model, r, &lower);
    assert_int_equal(lower->rank, r);
    assert_int_equal(lower->c3_count, thrum_c3_count(r));
    assert_int_equal(lower->c4_count, thrum_c4_count(r));
    assert_int_equal(thrum_model_check(lower, NULL), THRUM_OK);

    // every array holds the entries of the lowest coordinates
    for (int64_t i = 0; i < r; i++) {
      assert_true(lower->omega2[i] == m.omega2[i]);
      for (int64_t axis = 0; axis < 3; axis++)
        assert_true(lower->axis_mass[axis * r + i] == m.axis_mass[axis * RANK + i]);
      for (int64_t row = 0; row < 3 * VERTICES; row++)
        assert_true(lower->basis[row * r + i] == m.basis[row * RANK + i]);
      for (int64_t j = i; j < r; j++)
        for (int64_t k = j; k < r; k++) {
          assert_true(lower->c3[thrum_c3_index(r, i, j, k)] == m.c3[thrum_c3_index(RANK, i, j, k)]);
          for (int64_t l = k; l < r; l++)
            assert_true(lower->c4[thrum_c4_index(r, i, j, k, l)] ==
                        m.c4[thrum_c4_index(RANK, i, j, k, l)]);
        }
    }

    // energy and force are those of the whole with the other coordinates at zero
    double q[RANK] = {0}, whole[RANK], part[RANK];
    double *work = random_alloc((int64_t)thrum_work_count(&m.model), sizeof(double));
    random_state random = {(uint64_t)r};
    random_vector(&random, r, 1, q);
    const double v = thrum_internal_force(&m.model, q, whole, work);
    assert_true(fabs(thrum_internal_force(lower, q, part, work) - v) <= 1e-13 * (1 + fabs(v)));
    assert_true(largest_difference(whole, part, r) <= 1e-13 * 100);

    free(work);
    free(memory);
  }
  random_model_free(&m);
}

static void a_state_of_it_is_stepped_with_the_bits_of_the_model_made_by_hand(void **context) {
  (void)context;
  enum { RANK = 12, LOWER = 7 };

  // a model, and the coefficients of its lowest coordinates copied by hand
  random_model m, hand;
  random_model_make(&m, 3, RANK, 5, 200, 1.0);
  random_model_make(&hand, 3, LOWER, 5, 200, INFINITY);
  memcpy(hand.omega2, m.omega2, LOWER * sizeof(double));
  for (int64_t i = 0; i < LOWER; i++)
    for (int64_t j = i; j < LOWER; j++)
      for (int64_t k = j; k < LOWER; k++) {
        hand.c3[thrum_c3_index(LOWER, i, j, k)] = m.c3[thrum_c3_index(RANK, i, j, k)];
        for (int64_t l = k; l < LOWER; l++)
          hand.c4[thrum_c4_index(LOWER, i, j, k, l)] = m.c4[thrum_c4_index(RANK, i, j, k, l)];
      }

  // states of the locked model and of the one made by hand, from the same start
  const thrum_model *lower = NULL;
  void *memory = lock_model(&m.model, LOWER, &lower);
  hand.model.identity = thrum_model_identity(&hand.model);
  assert_true(lower->identity == hand.model.identity);
  thrum_state_def def = thrum_default_state_def();
  def.dt = 0.02;
  thrum_state *a = state_make(lower, &def), *b = state_make(&hand.model, &def);
  static const double q[LOWER] = {0.2, -0.1, 0.1}, p[LOWER] = {1, 0.5, 0, -0.5};
  state_put(lower, a, q, p);
  state_put(&hand.model, b, q, p);

  // the bytes of both states agree after the same steps
  state_steps(lower, a, 100);
  state_steps(&hand.model, b, 100);
  assert_memory_equal(a, b, thrum_state_kept_bytes(b));

  state_free(a);
  state_free(b);
  free(memory);
  random_model_free(&m);
  random_model_free(&hand);
}

static void ranks_and_memory_that_do_not_fit_are_refused(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, 5, 5, 200, 1.0);

  // ranks outside the model's own, and a missing model
  size_t size = 7;
  thrum_error error;
  const thrum_model *lower = NULL;
  assert_int_equal(thrum_model_lock_size(&m.model, 0, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_lock_size(&m.model, 6, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_model_lock_size(NULL, 1, &size, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(size, 7);

  // memory that is too small, misaligned or missing
  assert_int_equal(thrum_model_lock_size(&m.model, 3, &size, &error), THRUM_OK);
  unsigned char *memory = aligned_alloc(64, size + 64);
  assert_non_null(memory);
  assert_int_equal(thrum_model_lock(memory, size - 1, &m.model, 3, &lower, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_model_lock(memory + 8, size, &m.model, 3, &lower, &error),
                   THRUM_MISALIGNED);
  assert_int_equal(thrum_model_lock(NULL, size, &m.model, 3, &lower, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_null(lower);

  // without a mesh only the polynomial is copied
  assert_int_equal(thrum_model_lock(memory, size, &m.model, 3, &lower, &error), THRUM_OK);
  assert_null(lower->basis);
  assert_int_equal(thrum_model_check(lower, NULL), THRUM_OK);

  free(memory);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_locked_model_is_the_one_made_by_hand),
      cmocka_unit_test(a_state_of_it_is_stepped_with_the_bits_of_the_model_made_by_hand),
      cmocka_unit_test(ranks_and_memory_that_do_not_fit_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
