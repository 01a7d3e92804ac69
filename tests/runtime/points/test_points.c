/* Tests of models whose energy is summed over cubature points. The sum over points of Saint
 * Venant-Kirchhoff material is a quartic polynomial, whose coefficients are worked out here by the
 * strains of pairs of coordinates, so that every pass, every integrator, lower ranks and scales are
 * those of a model of coefficients; and every kernel gives the same bits.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/points_support.h"

#include "thrum/batch.h"

/* sym(A^T B) of two gradients, or sym A. */
static void strain_of(const double *a, const double *b, double strain[9]) {
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      strain[3 * c + d] = 0.5 * (a[3 * c + d] + a[3 * d + c]);
      if (!b)
        continue;
      strain[3 * c + d] = 0;
      for (int k = 0; k < 3; k++)
        strain[3 * c + d] += 0.5 * (a[3 * k + c] * b[3 * k + d] + b[3 * k + c] * a[3 * k + d]);
    }
}

/* a : C : b. */
static double product_of(double lambda, double mu, const double a[9], const double b[9]) {
  double sum = lambda * (a[0] + a[4] + a[8]) * (b[0] + b[4] + b[8]);
  for (int c = 0; c < 9; c++)
    sum += 2 * mu * a[c] * b[c];
  return sum;
}

/* Adds one point to c3 and c4. g: rank x 9. */
static void add_point(both *made, int64_t rank, double weight, double lambda, double mu,
                      const double *g) {
  // strains of the coordinates and of their pairs, i <= j, i outermost
  const int64_t pairs = rank * (rank + 1) / 2;
  double *linear = random_alloc(9 * rank, sizeof(double));
  double *pair = random_alloc(9 * pairs, sizeof(double)), *at = pair;
  for (int64_t i = 0; i < rank; i++) {
    strain_of(g + 9 * i, NULL, linear + 9 * i);
    for (int64_t j = i; j < rank; j++, at += 9) {
      strain_of(g + 9 * i, g + 9 * j, at);
      for (int c = 0; c < 9 && i == j; c++)
        at[c] *= 0.5;
    }
  }

  // each product of strains is one monomial
  const double *first = pair;
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = i; j < rank; j++, first += 9) {
      for (int64_t k = 0; k < rank; k++) {
        int64_t s[3] = {i, j, k};
        random_sort(s, 3);
        made->m.c3[thrum_c3_index(rank, s[0], s[1], s[2])] +=
            weight * product_of(lambda, mu, linear + 9 * k, first);
      }
      const double *second = pair;
      for (int64_t k = 0; k < rank; k++)
        for (int64_t l = k; l < rank; l++, second += 9) {
          int64_t s[4] = {i, j, k, l};
          random_sort(s, 4);
          made->m.c4[thrum_c4_index(rank, s[0], s[1], s[2], s[3])] +=
              0.5 * weight * product_of(lambda, mu, first, second);
        }
    }
  free(linear);
  free(pair);
}

/* The same and its coefficients. */
static void both_make(both *made, uint64_t seed, int64_t rank, int64_t count, double size) {
  points_make(made, seed, rank, count, size);
  double *g = random_alloc(9 * rank, sizeof(double));
  for (int64_t p = 0; p < count; p++) {
    for (int64_t i = 0; i < rank; i++)
      for (int c = 0; c < 9; c++)
        g[9 * i + c] = made->gradients[(9 * p + c) * rank + i];
    add_point(made, rank, made->weights[p], made->moduli[p], made->moduli[count + p], g);
  }
  free(g);
}

static void every_pass_is_that_of_the_polynomial(void **context) {
  (void)context;
  static const int64_t ranks[] = {1, 2, 3, 7, 8, 9, 15, 16, 17, 26}, counts[] = {1, 7, 8, 9, 20};
  outcome *found = random_alloc(1, sizeof *found), *expected = random_alloc(1, sizeof *expected);
  for (int r = 0; r < 10; r++)
    for (int c = 0; c < 5; c++) {
      both made;
      const int64_t rank = ranks[r];
      const int32_t split = (int32_t)(rank * (c % 5) / 4);
      both_make(&made, (uint64_t)(10 * r + c), rank, counts[c], 1);
      random_state random = {(uint64_t)(r + c)};
      double q[MOST], v[MOST];
      random_vector(&random, rank, 1, q);
      random_vector(&random, rank, 1, v);
      evaluate(&thrum_kernel_reference, &made.points, split, q, v, found);
      evaluate(&thrum_kernel_reference, &made.m.model, split, q, v, expected);

      // energies, forces and tangents
      assert_near(&found->energy, &expected->energy, 1);
      assert_near(&found->with_force, &expected->energy, 1);
      assert_near(&found->with_tangent, &expected->energy, 1);
      assert_near(found->twice, expected->twice, 2);
      assert_near(found->force, expected->force, rank);
      assert_near(found->forces[0], expected->forces[0], rank);
      assert_near(found->tangent_force, expected->force, rank);
      assert_near(found->tangent, expected->tangent, rank * rank);
      assert_near(found->product, expected->product, rank);
      assert_near(found->force_part, expected->force_part, split);
      assert_near(found->product_part, expected->product_part, split);

      // those with the first coordinates held; the value is a difference of two
      const int64_t n = rank - split;
      assert_true(fabs(found->held - expected->held) <=
                  1e-12 * (fabs(expected->held) + fabs(expected->energy)) * 100);
      assert_near(found->gradient, expected->gradient, n);
      assert_near(found->hessian, expected->hessian, n * n);
      both_free(&made);
    }
  free(found);
  free(expected);
}

static void every_kernel_gives_the_same_bits(void **context) {
  (void)context;
  outcome *found = random_alloc(1, sizeof *found), *expected = random_alloc(1, sizeof *expected);
  for (int64_t rank = 1; rank <= MOST; rank++) {
    both made;
    both_make(&made, (uint64_t)rank, rank, 1 + rank % 19, 1);
    const int32_t split = (int32_t)(rank * (rank % 5) / 4);
    random_state random = {(uint64_t)rank};
    double q[MOST], v[MOST];
    random_vector(&random, rank, 1, q);
    random_vector(&random, rank, 1, v);
    evaluate(&thrum_kernel_reference, &made.points, split, q, v, expected);
    for (int64_t i = 0; i < rank * rank; i++)
      assert_true(expected->tangent[i] == expected->tangent[i % rank * rank + i / rank]);

    // every number of every pass
    for (int id = THRUM_KERNEL_AVX2; thrum_kernel_name((thrum_kernel_id)id); id++) {
      if (!thrum_kernel_usable((thrum_kernel_id)id))
        continue;
      evaluate(thrum_kernel_get(id), &made.points, split, q, v, found);
      assert_memory_equal(found, expected, sizeof *found);
    }
    both_free(&made);
  }
  free(found);
  free(expected);
}

/* Compares a packed copy with the model as it lies in a file, by one kernel. */
static void assert_packed_the_same(const both *made, int id, int32_t split, bool single) {
  thrum_model packed = made->points;
  void *memory = pack(&packed);
  assert_true(single ? packed.packed_single && !packed.packed
                     : packed.packed && !packed.packed_single);

  // every number of every pass
  random_state random = {(uint64_t)split + 1};
  double q[MOST], v[MOST];
  random_vector(&random, packed.rank, 1, q);
  random_vector(&random, packed.rank, 1, v);
  outcome *found = random_alloc(1, sizeof *found), *expected = random_alloc(1, sizeof *expected);
  evaluate(&thrum_kernel_reference, &made->points, split, q, v, expected);
  evaluate(thrum_kernel_get(id), &packed, split, q, v, found);
  assert_memory_equal(found, expected, sizeof *found);
  free(found);
  free(expected);
  free(memory);
}

static void packed_points_give_the_same_bits_in_either_precision(void **context) {
  (void)context;

  // 600 points at rank 41 are 1.8 MB, and so packed in single precision where they can be
  static const int64_t ranks[] = {1, 9, 24, MOST, MOST}, counts[] = {3, 8, 17, 600, 600};
  for (int n = 0; n < 5; n++) {
    both made;
    points_make(&made, (uint64_t)(70 + n), ranks[n], counts[n], 1);
    const bool single = n == 4;
    for (int64_t k = 0; single && k < 9 * counts[n] * ranks[n]; k++)
      made.gradients[k] = (float)made.gradients[k];
    for (int id = THRUM_KERNEL_REFERENCE; thrum_kernel_name((thrum_kernel_id)id); id++)
      if (thrum_kernel_usable((thrum_kernel_id)id))
        assert_packed_the_same(&made, id, (int32_t)(ranks[n] / 3), single);
    both_free(&made);
  }
}

static void a_batch_steps_packed_points_as_each_alone(void **context) {
  (void)context;
  enum { RANK = 9, STATES = 5 };
  both made;
  points_make(&made, 12, RANK, 20, 0.2);
  void *packed = pack(&made.points);
  size_t size = 0;
  assert_int_equal(thrum_batch_size(&made.points, &size, NULL), THRUM_OK);
  void *workspace = aligned_alloc(64, (size + 63) / 64 * 64);

  // each state twice from the same start
  random_state random = {4};
  const thrum_state_def def = thrum_default_state_def();
  thrum_state *alone[STATES], *together[STATES];
  for (int n = 0; n < STATES; n++) {
    double start[RANK], zero[RANK] = {0};
    random_vector(&random, RANK, 1, start);
    alone[n] = state_make(&made.points, &def);
    together[n] = state_make(&made.points, &def);
    state_put(&made.points, alone[n], start, zero);
    state_put(&made.points, together[n], start, zero);
  }

  // they stay equal to the last bit
  for (int step = 0; step < 50; step++) {
    assert_true(thrum_batch_step(&made.points, together, STATES, NULL, workspace, size, NULL) >= 0);
    for (int n = 0; n < STATES; n++) {
      state_steps(&made.points, alone[n], 1);
      assert_memory_equal(together[n], alone[n], thrum_state_kept_bytes(alone[n]));
    }
  }
  for (int n = 0; n < STATES; n++) {
    state_free(alone[n]);
    state_free(together[n]);
  }
  free(workspace);
  free(packed);
  both_free(&made);
}

static void every_integrator_steps_points_as_it_steps_the_polynomial(void **context) {
  (void)context;
  enum { RANK = 9, STEPS = 200 };
  both made;
  both_make(&made, 5, RANK, 20, 0.2);
  made.points.identity = thrum_model_identity(&made.points);
  made.m.model.identity = thrum_model_identity(&made.m.model);
  assert_true(made.points.identity != 0 && made.points.identity != made.m.model.identity);

  // the same start for both
  random_state random = {8};
  double start[RANK], zero[RANK] = {0}, q[2][RANK], p[2][RANK];
  random_vector(&random, RANK, 1, start);
  for (int n = 0; n < INTEGRATOR_COUNT; n++) {
    thrum_state_def def = thrum_default_state_def();
    def.integrator = every_integrator[n];
    def.dt = 0.02;
    const thrum_model *const models[2] = {&made.points, &made.m.model};
    for (int k = 0; k < 2; k++) {
      thrum_state *state = state_make(models[k], &def);
      state_put(models[k], state, start, zero);
      state_steps(models[k], state, STEPS);
      state_read(models[k], state, q[k], p[k]);
      state_free(state);
    }
    assert_true(largest_difference(q[0], q[1], RANK) <= 1e-7);
    assert_true(largest_difference(p[0], p[1], RANK) <= 1e-7);
  }
  both_free(&made);
}

static void the_energy_integrator_keeps_the_energy_of_points_to_rounding(void **context) {
  (void)context;
  enum { RANK = 12, STEPS = 20000 };
  both made;
  both_make(&made, 6, RANK, 30, 0.2);

  // a swing that the quartic part has a say in
  random_state random = {9};
  double start[RANK], zero[RANK] = {0};
  random_vector(&random, RANK, 2, start);
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = 0.3;
  thrum_state *state = state_make(&made.points, &def);
  state_put(&made.points, state, start, zero);

  const double before = state_energy(&made.points, state).total;
  for (int n = 0; n < 20; n++) {
    state_steps(&made.points, state, STEPS / 20);
    assert_true(fabs(state_energy(&made.points, state).total / before - 1) < 1e-13);
  }
  state_free(state);
  both_free(&made);
}

static void lower_ranks_and_scales_are_those_of_the_polynomial(void **context) {
  (void)context;
  enum { RANK = 9, LOWER = 5 };
  both made;
  both_make(&made, 7, RANK, 11, 1);
  const thrum_model *const models[2] = {&made.points, &made.m.model};
  random_state random = {3};
  double q[RANK], force[2][RANK], energy[2][2];
  random_vector(&random, RANK, 1, q);
  double *work = random_alloc((int64_t)thrum_work_count(&made.m.model), sizeof(double));
  for (int k = 0; k < 2; k++) {
    // the lowest coordinates
    size_t size = 0;
    const thrum_model *made_of = NULL;
    assert_int_equal(thrum_model_lock_size(models[k], LOWER, &size, NULL), THRUM_OK);
    void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
    assert_int_equal(thrum_model_lock(memory, size, models[k], LOWER, &made_of, NULL), THRUM_OK);
    assert_int_equal(thrum_model_check(made_of, NULL), THRUM_OK);
    energy[k][0] = thrum_internal_force(made_of, q, force[k], work);
    free(memory);

    // twice as long, three times as stiff, half as heavy
    const thrum_model_scaling by = {2, 3, 0.5};
    assert_int_equal(thrum_model_scale_size(models[k], &size, NULL), THRUM_OK);
    memory = aligned_alloc(64, (size + 63) / 64 * 64);
    assert_int_equal(thrum_model_scale(memory, size, models[k], &by, &made_of, NULL), THRUM_OK);
    assert_int_equal(thrum_model_check(made_of, NULL), THRUM_OK);
    energy[k][1] = thrum_strain_energy(made_of, q, work);
    free(memory);
  }
  assert_near(energy[0], energy[1], 2);
  assert_near(force[0], force[1], LOWER);
  free(work);

  // points have nothing that could follow
  size_t size = 0;
  thrum_error error;
  assert_int_equal(thrum_model_condense_size(&made.points, 3, &size, &error), THRUM_UNSUPPORTED);
  both_free(&made);
}

/* Refused with this status and these words. */
static void assert_refused(const thrum_model *model, thrum_status status, const char *words) {
  thrum_error error;
  assert_int_equal(thrum_model_check(model, &error), status);
  if (!strstr(error.message, words))
    fail_msg("%s", error.message);
}

static void bad_points_are_refused(void **context) {
  (void)context;
  both made;
  both_make(&made, 4, 3, 5, 1);
  thrum_model bad = made.points;
  bad.point_moduli = NULL;
  assert_refused(&bad, THRUM_MISSING, "come together");
  bad = made.points;
  bad.c3 = made.m.c3;
  assert_refused(&bad, THRUM_BAD_SHAPE, "not both");
  bad = made.points;
  bad.point_count = 0;
  assert_refused(&bad, THRUM_BAD_SHAPE, "point_weights");

  // values out of range
  made.weights[2] = -1;
  assert_refused(&made.points, THRUM_BAD_VALUE, "weights are volumes");
  made.weights[2] = 1;
  made.moduli[5] = 0;
  assert_refused(&made.points, THRUM_BAD_VALUE, "mu > 0");
  made.moduli[5] = 1;
  made.gradients[3] = NAN;
  assert_refused(&made.points, THRUM_BAD_VALUE, "not finite");
  both_free(&made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_pass_is_that_of_the_polynomial),
      cmocka_unit_test(every_kernel_gives_the_same_bits),
      cmocka_unit_test(packed_points_give_the_same_bits_in_either_precision),
      cmocka_unit_test(a_batch_steps_packed_points_as_each_alone),
      cmocka_unit_test(every_integrator_steps_points_as_it_steps_the_polynomial),
      cmocka_unit_test(the_energy_integrator_keeps_the_energy_of_points_to_rounding),
      cmocka_unit_test(lower_ranks_and_scales_are_those_of_the_polynomial),
      cmocka_unit_test(bad_points_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
