/* Tests of the kernels: every kernel that this machine has gives the bits of the reference, for
 * every pass and every rank up to 100, and the reference sums in the order that
 * core/polynomial/kernel_private.h promises.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "core/polynomial/polynomial_private.h"
#include "tests/support/random_model.h"

#ifndef RANK_LIMIT
#define RANK_LIMIT 100
#endif
enum { RANK_MAX = RANK_LIMIT, POINTS = 19 };

/* One set of coefficients serves every rank, since any numbers are coefficients of some model. */
typedef struct setup {
  double *omega2, *c3, *c4;
  int64_t points; /* of the models; 0: coefficients */
  double *weights, *moduli, *gradients;
  double q[RANK_MAX], v[RANK_MAX];
} setup;

/* The results of one kernel at one rank. */
typedef struct outcome {
  double energy, with_force, with_tangent, twice[2];
  double force[RANK_MAX], product[RANK_MAX], tangent[RANK_MAX * RANK_MAX];
  double forces[2][RANK_MAX], tangent_force[RANK_MAX], tangent_again[RANK_MAX * RANK_MAX];
  double part, force_part[RANK_MAX], product_part[RANK_MAX];
  double gradient[RANK_MAX], hessian[RANK_MAX * RANK_MAX];
  double *restricted;
} outcome;

static int setup_make(void **state) {
  setup *s = random_alloc(1, sizeof *s);
  random_state random = {17};
  s->omega2 = random_alloc(RANK_MAX, sizeof(double));

  // the arrays have their exact length, so that a sanitizer sees a read past the end
  s->c3 = random_alloc(thrum_c3_count(RANK_MAX), sizeof(double));
  s->c4 = random_alloc(thrum_c4_count(RANK_MAX), sizeof(double));
  random_vector(&random, RANK_MAX, 1, s->omega2);
  random_vector(&random, thrum_c3_count(RANK_MAX), 1, s->c3);
  random_vector(&random, thrum_c4_count(RANK_MAX), 1, s->c4);
  random_vector(&random, RANK_MAX, 1, s->q);
  random_vector(&random, RANK_MAX, 1, s->v);

  // points that the energy may be summed from in place of c3 and c4
  s->weights = random_alloc(POINTS, sizeof(double));
  s->moduli = random_alloc(2 * POINTS, sizeof(double));
  s->gradients = random_alloc(9 * POINTS * RANK_MAX, sizeof(double));
  random_vector(&random, POINTS, 1, s->weights);
  random_vector(&random, 2 * POINTS, 1, s->moduli);
  random_vector(&random, 9 * POINTS * RANK_MAX, 1, s->gradients);
  *state = s;
  return 0;
}

static int setup_free(void **state) {
  setup *s = *state;
  free(s->omega2);
  free(s->c3);
  free(s->c4);
  free(s->weights);
  free(s->moduli);
  free(s->gradients);
  free(s);
  return 0;
}

/* The model of a rank takes the last coefficients of the arrays and so ends where they end. */
static thrum_model model_of(const setup *s, int64_t rank) {
  thrum_model model = {0};
  model.rank = rank;
  model.omega2 = s->omega2;

  // points in place of coefficients
  if (s->points > 0) {
    model.point_count = s->points;
    model.point_weights = s->weights + (POINTS - s->points);
    model.point_moduli = s->moduli + 2 * (POINTS - s->points);
    model.point_gradients = s->gradients + 9 * (POINTS * RANK_MAX - s->points * rank);
    return model;
  }

  model.c3_count = thrum_c3_count(rank);
  model.c4_count = thrum_c4_count(rank);
  model.c3 = s->c3 + (thrum_c3_count(RANK_MAX) - model.c3_count);
  model.c4 = s->c4 + (thrum_c4_count(RANK_MAX) - model.c4_count);
  return model;
}

/* Work space full of NaN, with a marker behind it. */
static double *dirty_work(const thrum_model *model) {
  const int64_t count = (int64_t)thrum_work_count(model);
  double *work = random_alloc(count + 1, sizeof *work);
  for (int64_t i = 0; i < count; i++)
    work[i] = NAN;
  work[count] = -12345.0;
  return work;
}

/* The inverse reads both triangles of a matrix. */
static void assert_symmetric(const double *matrix, int64_t n) {
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < i; j++)
      assert_true(matrix[i * n + j] == matrix[j * n + i]);
}

static void evaluate(const setup *s, const thrum_kernel *by, bool pack, int64_t rank, int32_t split,
                     outcome *o) {
  thrum_model model = model_of(s, rank);
  void *memory = NULL;
  if (pack) {
    // the packed copy has its exact length
    const size_t size = thrum_model_pack_size(&model);
    memory = aligned_alloc(64, size);
    assert_true(memory != NULL);
    assert_true(thrum_model_pack(&model, memory, size, NULL) == THRUM_OK);
    assert_true(model.packed != NULL || model.packed_single != NULL);
  }

  // every pass at the same point, each with the work space that the one before left behind
  double *work = dirty_work(&model);
  o->energy = thrum_strain_energy_by(by, &model, s->q, work);
  o->with_force = thrum_internal_force_by(by, &model, s->q, o->force, work);
  thrum_tangent_stiffness_by(by, &model, s->q, o->tangent, work);
  o->with_tangent =
      thrum_internal_force_tangent_by(by, &model, s->q, o->tangent_force, o->tangent_again, work);

  // two points at once, the second of which is the point of the other passes
  const double *const points[2] = {s->v, s->q};
  double *const forces[2] = {o->forces[0], o->forces[1]};
  thrum_internal_forces_by(by, &model, points, forces, o->twice, work);

  // the product with a vector, and the parts for the explicit modes
  thrum_tangent_product_by(by, &model, s->q, s->v, o->product, work);
  o->part = thrum_internal_force_part(by, &model, split, s->q, o->force_part, work);
  thrum_tangent_product_part(by, &model, split, s->q, s->v, o->product_part, work);

  // the restricted polynomial and its derivatives
  o->restricted = random_alloc(thrum_restriction_count(&model, rank - split), sizeof(double));
  thrum_polynomial_restrict(by, &model, split, s->q, o->restricted, work);
  thrum_restricted_gradient(by, &model, split, o->restricted, s->v, o->gradient, work);
  thrum_restricted_hessian(by, &model, split, o->restricted, s->v, o->hessian, work);

  // matrices are symmetric to the bit, and nothing was written behind the work space
  assert_symmetric(o->tangent, rank);
  assert_symmetric(o->tangent_again, rank);
  assert_symmetric(o->hessian, rank - split);
  assert_true(work[thrum_work_count(&model)] == -12345.0);

  free(work);
  free(memory);
}

/* The second holds `restricted` numbers of V with the first coordinates held. */
static void assert_same(const outcome *a, const outcome *b, int64_t rank, int32_t split,
                        int64_t restricted) {
  const size_t vector = (size_t)rank * sizeof(double), n = (size_t)(rank - split);
  assert_true(a->energy == b->energy && a->with_force == b->with_force);
  assert_true(a->with_tangent == b->with_tangent);

  assert_true(a->twice[0] == b->twice[0] && a->twice[1] == b->twice[1]);
  assert_memory_equal(a->forces[0], b->forces[0], vector);
  assert_memory_equal(a->forces[1], b->forces[1], vector);
  assert_memory_equal(a->tangent_force, b->tangent_force, vector);
  assert_memory_equal(a->tangent_again, b->tangent, (size_t)rank * vector);

  // a point that is evaluated with another one has the bits of the point alone
  assert_true(a->twice[1] == b->with_force);
  assert_memory_equal(a->forces[1], b->force, vector);
  assert_memory_equal(a->force, b->force, vector);
  assert_memory_equal(a->product, b->product, vector);
  assert_memory_equal(a->tangent, b->tangent, (size_t)rank * vector);

  // the parts of a split, and the restricted polynomial
  assert_true(a->part == b->part);
  assert_memory_equal(a->force_part, b->force_part, (size_t)split * sizeof(double));
  assert_memory_equal(a->product_part, b->product_part, (size_t)split * sizeof(double));
  assert_memory_equal(a->restricted, b->restricted, (size_t)restricted * sizeof(double));
  assert_memory_equal(a->gradient, b->gradient, n * sizeof(double));
  assert_memory_equal(a->hessian, b->hessian, n * n * sizeof(double));
}

static void every_kernel_gives_the_bits_of_the_reference_at_every_rank(void **state) {
  const setup *s = *state;
  outcome *expected = random_alloc(1, sizeof *expected), *found = random_alloc(1, sizeof *found);
  for (int64_t rank = 1; rank <= RANK_MAX; rank++) {
    // splits of every kind occur as the rank goes up
    const int32_t split = (int32_t)(rank * (rank % 5) / 4);
    evaluate(s, &thrum_kernel_reference, true, rank, split, expected);

    // the other kernels that this machine can run
    for (int id = THRUM_KERNEL_AVX2; thrum_kernel_name((thrum_kernel_id)id); id++) {
      if (!thrum_kernel_usable((thrum_kernel_id)id))
        continue;
      evaluate(s, thrum_kernel_get(id), true, rank, split, found);
      assert_same(found, expected, rank, split, thrum_restricted_count(rank - split));
      free(found->restricted);
    }
    free(expected->restricted);
  }
  free(expected);
  free(found);
}

static void every_kernel_gives_the_bits_of_the_reference_with_points(void **state) {
  setup *s = *state;
  outcome *expected = random_alloc(1, sizeof *expected), *found = random_alloc(1, sizeof *found);
  for (int64_t rank = 1; rank <= RANK_MAX; rank += rank < 20 ? 1 : 7) {
    const int32_t split = (int32_t)(rank * (rank % 5) / 4);
    s->points = 1 + rank % POINTS;
    const thrum_model model = model_of(s, rank);
    const int64_t restricted = thrum_restriction_count(&model, rank - split);
    evaluate(s, &thrum_kernel_reference, false, rank, split, expected);

    // every kernel that this machine can run, packed and as points lie in a file
    for (int id = THRUM_KERNEL_REFERENCE; thrum_kernel_name((thrum_kernel_id)id); id++)
      for (int pack = 0; pack < 2 && thrum_kernel_usable((thrum_kernel_id)id); pack++) {
        evaluate(s, thrum_kernel_get(id), pack == 1, rank, split, found);
        assert_same(found, expected, rank, split, restricted);
        free(found->restricted);
      }
    free(expected->restricted);
  }
  s->points = 0;
  free(expected);
  free(found);
}

static void the_reference_gives_the_same_bits_without_packed_coefficients(void **state) {
  const setup *s = *state;
  outcome *expected = random_alloc(1, sizeof *expected), *found = random_alloc(1, sizeof *found);
  for (int64_t rank = 1; rank <= RANK_MAX; rank += rank < 30 ? 1 : 23) {
    const int32_t split = (int32_t)(rank * (rank % 4) / 3);
    evaluate(s, &thrum_kernel_reference, true, rank, split, expected);
    evaluate(s, &thrum_kernel_reference, false, rank, split, found);
    assert_same(found, expected, rank, split, thrum_restricted_count(rank - split));
    free(found->restricted);
    free(expected->restricted);
  }
  free(expected);
  free(found);
}

static void every_split_gives_the_bits_of_the_reference(void **state) {
  const setup *s = *state;
  outcome *expected = random_alloc(1, sizeof *expected), *found = random_alloc(1, sizeof *found);
  for (int64_t rank = 1; rank <= 20; rank++)
    for (int32_t split = 0; split <= rank; split++) {
      evaluate(s, &thrum_kernel_reference, false, rank, split, expected);
      evaluate(s, thrum_kernel_get(THRUM_KERNEL_BEST), true, rank, split, found);
      assert_same(found, expected, rank, split, thrum_restricted_count(rank - split));
      free(found->restricted);
      free(expected->restricted);
    }
  free(expected);
  free(found);
}

static void single_precision_coefficients_are_packed_as_such_and_keep_the_bits(void **state) {
  const setup *s = *state;
  const int64_t c3_count = thrum_c3_count(RANK_MAX), c4_count = thrum_c4_count(RANK_MAX);

  // coefficients that single precision holds exactly
  setup rounded = *s;
  rounded.c3 = random_alloc(c3_count, sizeof(double));
  rounded.c4 = random_alloc(c4_count, sizeof(double));
  for (int64_t k = 0; k < c3_count; k++)
    rounded.c3[k] = (double)(float)s->c3[k];
  for (int64_t k = 0; k < c4_count; k++)
    rounded.c4[k] = (double)(float)s->c4[k];

  outcome *expected = random_alloc(1, sizeof *expected), *found = random_alloc(1, sizeof *found);
  for (int64_t rank = 40; rank <= RANK_MAX; rank += 21) {
    // such a model is packed in single precision
    thrum_model model = model_of(&rounded, rank);
    const size_t size = thrum_model_pack_size(&model);
    void *memory = aligned_alloc(64, size);
    assert_true(memory != NULL);
    assert_true(thrum_model_pack(&model, memory, size, NULL) == THRUM_OK);
    assert_true(model.packed == NULL && model.packed_single != NULL);
    free(memory);

    // every kernel gives the bits of the reference without packed coefficients
    evaluate(&rounded, &thrum_kernel_reference, false, rank, 7, expected);
    for (int id = THRUM_KERNEL_REFERENCE; thrum_kernel_name((thrum_kernel_id)id); id++) {
      if (!thrum_kernel_usable((thrum_kernel_id)id))
        continue;
      evaluate(&rounded, thrum_kernel_get(id), true, rank, 7, found);
      assert_same(found, expected, rank, 7, thrum_restricted_count(rank - 7));
      free(found->restricted);
    }
    free(expected->restricted);
  }

  free(expected);
  free(found);
  free(rounded.c3);
  free(rounded.c4);
}

static void a_copy_with_other_coefficients_is_not_taken_for_packed(void **state) {
  const setup *s = *state;

  // a packed model
  thrum_model model = model_of(s, 9), other = model_of(s, 9);
  const size_t size = thrum_model_pack_size(&model);
  void *memory = aligned_alloc(64, size);
  assert_true(memory != NULL);
  assert_true(thrum_model_pack(&model, memory, size, NULL) == THRUM_OK);
  double *work = dirty_work(&model), expected[9], force[9];

  // a copy of it with other coefficients of the same count: the beginning of the array
  other.c4 = s->c4;
  thrum_model copy = model;
  copy.c4 = other.c4;

  // the copy is evaluated with its own coefficients
  const double energy = thrum_internal_force(&other, s->q, expected, work);
  assert_true(thrum_internal_force(&copy, s->q, force, work) == energy);
  assert_memory_equal(force, expected, sizeof force);

  free(work);
  free(memory);
}

static double tree(const double lane[8]) {
  return ((lane[0] + lane[4]) + (lane[2] + lane[6])) + ((lane[1] + lane[5]) + (lane[3] + lane[7]));
}

/* Returns c3 or c4 of q_a q_b q_c q_d, a <= b <= c <= d, where a = -1 stands for a factor of 1. */
static double coefficient(const thrum_model *model, int64_t a, int64_t b, int64_t c, int64_t d) {
  return a < 0 ? model->c3[thrum_c3_index(model->rank, b, c, d)]
               : model->c4[thrum_c4_index(model->rank, a, b, c, d)];
}

/* Evaluates force and energy with every sum in the promised order, one coefficient at a time. */
static double force_by_promise(const thrum_model *model, const double *q, double *force) {
  const int64_t r = model->rank, columns = r * (r + 3) / 2;
  double *w = random_alloc(columns, sizeof *w);
  double g[RANK_MAX] = {0}, h[RANK_MAX] = {0}, s[RANK_MAX] = {0}, quadratic = 0, lane[8];

  // for each pair c, d the sum over its monomials; w gathers the pairs of each monomial
  for (int64_t c = 0; c < r; c++) {
    double outer[8] = {0};
    for (int64_t d = r - 1; d >= c; d--) {
      int64_t column = 0;
      memset(lane, 0, sizeof lane);
      for (int64_t b = 0; b <= c; b++)
        for (int64_t a = -1; a <= b; a++, column++) {
          const double known = coefficient(model, a, b, c, d);
          lane[column % 8] += known * (a < 0 ? q[b] : q[b] * q[a]);
          w[column] += q[c] * q[d] * known;
        }
      const double y = tree(lane);
      g[d] += q[c] * y;
      outer[(r - 1 - d) % 8] += y * q[d];
    }
    s[c] = tree(outer);
  }

  // derivatives by the coordinates of the monomials, weighted by w
  int64_t column = 0;
  double more[RANK_MAX];
  for (int64_t b = 0; b < r; b++) {
    memset(lane, 0, sizeof lane);
    for (int64_t a = -1; a <= b; a++, column++) {
      lane[(a + 1) % 8] += w[column] * (a < 0 ? 1.0 : q[a]);
      if (a >= 0)
        h[a] += q[b] * w[column];
    }
    more[b] = tree(lane);
  }

  // the quadratic part is separate
  memset(lane, 0, sizeof lane);
  for (int64_t i = 0; i < r; i++) {
    lane[i % 8] += q[i] * s[i];
    quadratic += 0.5 * model->omega2[i] * q[i] * q[i];
    force[i] = model->omega2[i] * q[i] + ((g[i] + h[i]) + (s[i] + more[i]));
  }

  free(w);
  return quadratic + tree(lane);
}

/* Evaluates the same for the explicit modes alone, in coordinates z_k = q_{r-1-k}. */
static double force_part_by_promise(const thrum_model *model, int32_t split, const double *q,
                                    double *force) {
  const int64_t r = model->rank, implicit = r - split, last = r - 1;
  double *w = random_alloc(r * (r + 3) / 2, sizeof *w), z[RANK_MAX], lane[8];
  double g[RANK_MAX] = {0}, h[RANK_MAX] = {0}, s[RANK_MAX] = {0}, quadratic = 0;

  // the coordinates in reverse order: the explicit modes come last
  for (int64_t k = 0; k < r; k++)
    z[k] = q[last - k];

  // for each pair c, d the sum over its monomials; only pairs of explicit modes contribute to w
  for (int64_t c = 0; c < r; c++) {
    double outer[8] = {0};
    for (int64_t d = c; d < r; d++) {
      int64_t column = 0;
      memset(lane, 0, sizeof lane);
      for (int64_t b = 0; b <= c; b++)
        for (int64_t a = -1; a <= b; a++, column++) {
          const double known = a < 0 ? coefficient(model, a, last - d, last - c, last - b)
                                     : coefficient(model, last - d, last - c, last - b, last - a);
          lane[column % 8] += known * (a < 0 ? z[b] : z[b] * z[a]);
          w[column] += c < implicit ? 0.0 : z[c] * z[d] * known;
        }
      const double y = tree(lane);
      g[d] += z[c] * y;
      outer[(d - c) % 8] += y * z[d];
    }
    s[c] = tree(outer);
  }

  // derivatives by the coordinates of the monomials, weighted by w
  double more[RANK_MAX];
  for (int64_t b = implicit, column = b * (b + 3) / 2; b < r; b++) {
    memset(lane, 0, sizeof lane);
    for (int64_t a = -1; a <= b; a++, column++) {
      lane[(a + 1) % 8] += w[column] * (a < 0 ? 1.0 : z[a]);
      if (a >= 0)
        h[a] += z[b] * w[column];
    }
    more[b] = tree(lane);
  }

  // the quadratic part is separate, and the force is that of the explicit modes
  memset(lane, 0, sizeof lane);
  for (int64_t k = 0; k < r; k++) {
    lane[k % 8] += z[k] * s[k];
    quadratic += 0.5 * model->omega2[k] * q[k] * q[k];
  }
  for (int64_t i = 0, k = last; i < split; i++, k--)
    force[i] = model->omega2[i] * q[i] + ((g[k] + h[k]) + (s[k] + more[k]));

  free(w);
  return quadratic + tree(lane);
}

static void the_reference_keeps_the_promised_order_of_summation(void **state) {
  const setup *s = *state;
  for (int64_t rank = 1; rank <= 40; rank++) {
    const thrum_model model = model_of(s, rank);

    // the force of all coordinates
    double *work = dirty_work(&model), expected[RANK_MAX], force[RANK_MAX];
    const double energy = force_by_promise(&model, s->q, expected);
    assert_true(thrum_internal_force_by(&thrum_kernel_reference, &model, s->q, force, work) ==
                energy);
    assert_memory_equal(force, expected, (size_t)rank * sizeof(double));

    // the force of the explicit modes
    const int32_t split = (int32_t)(rank * (rank % 4) / 3);
    const double value = force_part_by_promise(&model, split, s->q, expected);
    assert_true(thrum_internal_force_part(&thrum_kernel_reference, &model, split, s->q, force,
                                          work) == value);
    assert_memory_equal(force, expected, (size_t)split * sizeof(double));

    free(work);
  }
}

static void a_kernel_of_another_machine_gives_way_to_the_best_one_here(void **state) {
  (void)state;
  const thrum_kernel_id best = thrum_kernel_chosen(THRUM_KERNEL_BEST);
  assert_true(thrum_kernel_usable(best));
  assert_true(best != THRUM_KERNEL_BEST);
  assert_int_equal(thrum_kernel_chosen(THRUM_KERNEL_REFERENCE), THRUM_KERNEL_REFERENCE);
  for (int id = 0; thrum_kernel_name((thrum_kernel_id)id); id++) {
    const thrum_kernel_id chosen = thrum_kernel_chosen((thrum_kernel_id)id);
    if (id == THRUM_KERNEL_BEST || !thrum_kernel_usable((thrum_kernel_id)id))
      assert_int_equal(chosen, best);
    else
      assert_int_equal(chosen, id);
  }
  assert_null(thrum_kernel_name((thrum_kernel_id)99));
  assert_ptr_equal(thrum_kernel_get(-5), thrum_kernel_get(THRUM_KERNEL_BEST));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kernel_gives_the_bits_of_the_reference_at_every_rank),
      cmocka_unit_test(every_kernel_gives_the_bits_of_the_reference_with_points),
      cmocka_unit_test(the_reference_gives_the_same_bits_without_packed_coefficients),
      cmocka_unit_test(every_split_gives_the_bits_of_the_reference),
      cmocka_unit_test(single_precision_coefficients_are_packed_as_such_and_keep_the_bits),
      cmocka_unit_test(a_copy_with_other_coefficients_is_not_taken_for_packed),
      cmocka_unit_test(the_reference_keeps_the_promised_order_of_summation),
      cmocka_unit_test(a_kernel_of_another_machine_gives_way_to_the_best_one_here),
  };
  return cmocka_run_group_tests(tests, setup_make, setup_free);
}
