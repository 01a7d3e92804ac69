/* Learned gradients of cubature points: the slope of the objective is that of its differences,
 * points find back to those that made the forces, what is exact stays as it is, and a model of
 * refined points is right where points of the mesh are not.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/polynomial/cubature_refine.h"
#include "precompute/polynomial/quartic_stress.h"
#include "precompute/polynomial/refine_slope.h"
#include "thrum/polynomial.h"

enum { RANK = 5, POINTS = 4, SAMPLES = 4 * THRUM_REFINE_BATCH, NUMBERS = 9 * POINTS * RANK };

/* Points, and states with the forces of other points. */
typedef struct problem {
  double lambda[POINTS], mu[POINTS], gradients[NUMBERS];
  double q[SAMPLES * RANK], force[SAMPLES * RANK], scale[SAMPLES];
  thrum_law laws[POINTS];
  thrum_free_points points;
  thrum_force_samples samples;
  double *work;
} problem;

/* Moduli, gradients and states at random; forces are those of these points, which are of all laws
 * or, where they are not `mixed`, of Saint Venant-Kirchhoff material. */
static problem *problem_make_of(bool mixed) {
  problem *made = need(1, sizeof *made);
  for (int p = 0; p < POINTS; p++)
    made->laws[p] = mixed ? (thrum_law)(p % 3) : THRUM_LAW_STVK;
  made->points = (thrum_free_points){
      POINTS, RANK, made->lambda, made->mu, made->gradients, mixed ? made->laws : NULL};
  made->samples = (thrum_force_samples){SAMPLES, RANK, made->q, made->force, made->scale};
  made->work = need((size_t)thrum_refine_work(&made->points, THRUM_REFINE_BATCH), sizeof(double));
  for (int p = 0; p < POINTS; p++) {
    made->lambda[p] = 1.2 + random_number();
    made->mu[p] = 1.2 + random_number();
  }
  for (int n = 0; n < NUMBERS; n++)
    made->gradients[n] = 0.5 * random_number();
  for (int n = 0; n < SAMPLES * RANK; n++)
    made->q[n] = random_number();

  // a sample of force zero and scale one has the force of the points as its residual
  for (int s = 0; s < SAMPLES; s++) {
    double force[RANK] = {0}, size = 0;
    for (int p = 0; p < POINTS; p++) {
      const double *rows = made->gradients + 9 * p * RANK;
      double g[3][3] = {{0}}, stress[3][3];
      for (int c = 0; c < 9; c++)
        for (int i = 0; i < RANK; i++)
          g[c / 3][c % 3] += rows[c * RANK + i] * made->q[s * RANK + i];
      thrum_nonlinear_stress(made->laws[p], made->lambda[p], made->mu[p], g, stress);
      for (int c = 0; c < 9; c++)
        for (int i = 0; i < RANK; i++)
          force[i] += stress[c / 3][c % 3] * rows[c * RANK + i];
    }
    for (int i = 0; i < RANK; i++)
      size += pow(force[i] + made->q[s * RANK + i], 2);
    made->scale[s] = 1 / sqrt(size);
    for (int i = 0; i < RANK; i++)
      made->force[s * RANK + i] = force[i] * made->scale[s];
  }
  return made;
}

static problem *problem_make(void) {
  return problem_make_of(false);
}

static void problem_free(problem *p) {
  free(p->work);
  free(p);
}

static void move_gradients(problem *p, double size) {
  for (int n = 0; n < NUMBERS; n++)
    p->gradients[n] += size * random_number();
}

static double objective(problem *p, double *slope) {
  return thrum_refine_objective(&p->points, &p->samples, THRUM_REFINE_BATCH, THRUM_REFINE_BATCH,
                                slope, p->work);
}

static void check_slope(problem *p) {
  double slope[NUMBERS], direction[NUMBERS], at[NUMBERS], value[2], along = 0;
  move_gradients(p, 0.2);
  memcpy(at, p->gradients, sizeof at);
  const double middle = objective(p, slope);
  assert_true(middle > 1e-4);

  // along a random direction, halved steps quarter the error of central differences
  for (int n = 0; n < NUMBERS; n++) {
    direction[n] = random_number();
    along += slope[n] * direction[n];
  }
  double off[2];
  for (int half = 0; half < 2; half++) {
    const double h = half ? 5e-3 : 1e-2;
    for (int side = 0; side < 2; side++) {
      for (int n = 0; n < NUMBERS; n++)
        p->gradients[n] = at[n] + (side ? h : -h) * direction[n];
      value[side] = objective(p, NULL);
    }
    off[half] = (value[1] - value[0]) / (2 * h) - along;
  }
  assert_true(fabs(off[0]) < 0.1 * fabs(along));
  assert_true(fabs(off[0] / off[1] - 4) < 0.2);
  problem_free(p);
}

static void the_slope_is_that_of_differences(void **state) {
  (void)state;
  for (int mixed = 0; mixed < 2; mixed++)
    check_slope(problem_make_of(mixed == 1));
}

/* The slope in single precision, of which steps are made: component c of point p is its row
 * c POINTS + p. */
static void the_slope_in_single_precision_is_the_same(void **state) {
  (void)state;
  static float gradients[NUMBERS], q[SAMPLES * RANK], force[SAMPLES * RANK], slope[NUMBERS];
  float lambda[POINTS], mu[POINTS], scale[SAMPLES];
  for (int mixed = 0; mixed < 2; mixed++) {
    problem *p = problem_make_of(mixed == 1);
    double exact[NUMBERS], size = 0, off = 0;
    move_gradients(p, 0.2);
    thrum_refine_objective(&p->points, &p->samples, 0, THRUM_REFINE_BATCH, exact, p->work);

    // the same points side by side
    for (int n = 0; n < POINTS; n++) {
      lambda[n] = (float)p->lambda[n];
      mu[n] = (float)p->mu[n];
      for (int c = 0; c < 9; c++)
        for (int i = 0; i < RANK; i++)
          gradients[(c * POINTS + n) * RANK + i] = (float)p->gradients[(9 * n + c) * RANK + i];
    }
    for (int n = 0; n < THRUM_REFINE_BATCH * RANK; n++) {
      scale[n / RANK] = (float)p->scale[n / RANK];
      q[n] = (float)p->q[n];
      force[n] = (float)p->force[n];
    }
    const thrum_single_points points = {POINTS, RANK, p->points.laws, lambda, mu, gradients};
    const thrum_single_samples samples = {THRUM_REFINE_BATCH, q, force, scale};
    float *work = need((size_t)thrum_refine_slope_work(POINTS, RANK, samples.count), sizeof *work);
    thrum_refine_slope(&points, &samples, slope, work);

    for (int n = 0; n < NUMBERS; n++) {
      const int row = n / RANK, at = (row % 9 * POINTS + row / 9) * RANK + n % RANK;
      off += pow((double)slope[at] - exact[n], 2);
      size += exact[n] * exact[n];
    }
    assert_true(size > 0 && off < 1e-10 * size);
    free(work);
    problem_free(p);
  }
}

static void find_back(problem *p) {
  move_gradients(p, 0.03);
  const double before = thrum_refine_error(&p->points, &p->samples, p->work);
  thrum_error error = {0};
  assert_int_equal(thrum_cubature_refine(&p->samples, 4000, &p->points, NULL, 0, &error), THRUM_OK);
  const double after = thrum_refine_error(&p->points, &p->samples, p->work);
  assert_true(before > 0.005);
  if (!(after < 0.1 * before))
    fail_msg("%g of %g", after, before);
  problem_free(p);
}

static void points_find_back_to_those_that_made_the_forces(void **state) {
  (void)state;
  for (int mixed = 0; mixed < 2; mixed++)
    find_back(problem_make_of(mixed == 1));
}

static void what_is_exact_keeps_its_bits(void **state) {
  (void)state;
  problem *p = problem_make();
  double before[NUMBERS];
  memcpy(before, p->gradients, sizeof before);
  thrum_error error = {0};
  assert_int_equal(thrum_cubature_refine(&p->samples, 50, &p->points, NULL, 0, &error), THRUM_OK);
  assert_memory_equal(before, p->gradients, sizeof before);
  assert_true(thrum_refine_error(&p->points, &p->samples, p->work) < 1e-14);
  problem_free(p);
}

/* Root of the mean square of the relative error of the force in states of the first four modes. */
static double error_of(const thrum_model *model, const thrum_model *exact) {
  enum { RANK_MOST = 16 };
  double q[RANK_MOST], force[2][RANK_MOST], sum = 0,
                                            *work = need(thrum_work_count(exact), sizeof *work);
  uint64_t random = 7;
  for (int n = 0; n < 100; n++) {
    memset(q, 0, sizeof q);
    for (int i = 0; i < 4; i++) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      q[i] = 0.15 * ((double)(random >> 11) / 4503599627370496.0 - 1) *
             sqrt(exact->omega2[0] / exact->omega2[i]);
    }

    // both forces at this state, by the norm of the static response
    thrum_internal_force(model, q, force[0], work);
    thrum_internal_force(exact, q, force[1], work);
    double size = 0, difference = 0;
    for (int i = 0; i < exact->rank; i++) {
      size += force[1][i] * force[1][i] / exact->omega2[i];
      difference += pow(force[0][i] - force[1][i], 2) / exact->omega2[i];
    }
    sum += difference / size / 100;
  }
  free(work);
  return sqrt(sum);
}

/* Points of the mesh tell with how many of them learning would begin. */
static void the_points_to_be_learned_are_told_before(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.15x0.15", "x<0.001");
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 4;
  options.rank = 12;
  options.check = THRUM_CHECK_SEARCH;
  options.cubature = true;
  options.cubature_error = 0.01;
  thrum_precomputed chosen = {0}, learned = {0};
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &chosen, NULL) >= 0);
  options.cubature_refine = 1;
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &learned, NULL) >= 0);
  assert_true(chosen.cubature.few > 0 && chosen.cubature.few < chosen.model.point_count);
  assert_int_equal(learned.model.point_count, chosen.cubature.few);
  assert_int_equal(learned.cubature.few, 0);

  // ten times the steps take ten times as long, and so do points
  assert_close(thrum_cubature_learning(20, 12, 100), thrum_cubature_learning(2, 12, 1000), 1e-12);
  thrum_precomputed_free(&chosen);
  thrum_precomputed_free(&learned);
  body_free(&b);
}

static void refined_points_are_right_where_those_of_the_mesh_are_not(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.15x0.15", "x<0.001");
  thrum_error error = {0};
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 4;
  options.rank = 12;
  options.check = THRUM_CHECK_SEARCH;
  thrum_precomputed exact = {0}, chosen = {0}, refined = {0}, again = {0};
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &exact, &error) >= 0);

  // both models have as many points, and only those of one are refined
  options.cubature = true;
  options.cubature_error = 1e-9;
  options.cubature_points = 16;
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &chosen, &error) >= 0);
  options.cubature_refine = 1500;
  if (thrum_precompute(&b.mesh, b.fixed, &options, &refined, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(refined.model.point_count, chosen.model.point_count);
  assert_true(refined.cubature.chosen_error == chosen.cubature.test_error);
  assert_true(chosen.cubature.chosen_error == 0);

  // a model of the same kind: weights of the mesh, which are positive, and exact frequencies
  assert_int_equal(thrum_model_check(&refined.model, &error), THRUM_OK);
  assert_memory_equal(refined.model.point_weights, chosen.model.point_weights,
                      (size_t)chosen.model.point_count * sizeof(double));
  assert_memory_equal(refined.model.omega2, chosen.model.omega2, 12 * sizeof(double));

  // errors in states that were not trained on, of the same kind and of another
  if (!(refined.cubature.test_error < 0.5 * chosen.cubature.test_error))
    fail_msg("%g of %g", refined.cubature.test_error, chosen.cubature.test_error);
  const double errors[] = {error_of(&refined.model, &exact.model),
                           error_of(&chosen.model, &exact.model)};
  if (!(errors[0] < 0.5 * errors[1]))
    fail_msg("%g of %g", errors[0], errors[1]);

  // the same input gives the same gradients
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &again, &error) >= 0);
  assert_memory_equal(refined.model.point_gradients, again.model.point_gradients,
                      (size_t)(9 * refined.model.point_count * 12) * sizeof(double));
  thrum_precomputed_free(&exact);
  thrum_precomputed_free(&chosen);
  thrum_precomputed_free(&refined);
  thrum_precomputed_free(&again);
  body_free(&b);
}

static void refining_goes_with_points_that_do_not_flow(void **state) {
  (void)state;
  body b = body_make("beam:4x1x1@1x0.2x0.2", "x<0.001");
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 3;
  options.rank = 6;

  // steps without points, of points that flow, fewer than none, and more than anyone waits for
  static const struct {
    bool cubature;
    double yield;
    int64_t steps;
  } wrong[] = {{false, INFINITY, 10},
               {true, 0.02, 10},
               {true, INFINITY, -1},
               {true, INFINITY, INT64_C(1) << 40}};
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    thrum_error error = {0};
    thrum_precomputed made = {0};
    options.cubature = wrong[n].cubature;
    options.law = wrong[n].yield < INFINITY ? THRUM_LAW_COROTATIONAL : THRUM_LAW_STVK;
    options.cubature_yield = wrong[n].yield;
    options.cubature_refine = wrong[n].steps;
    assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "refined"));
  }
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_slope_is_that_of_differences),
      cmocka_unit_test(the_slope_in_single_precision_is_the_same),
      cmocka_unit_test(points_find_back_to_those_that_made_the_forces),
      cmocka_unit_test(what_is_exact_keeps_its_bits),
      cmocka_unit_test(the_points_to_be_learned_are_told_before),
      cmocka_unit_test(refined_points_are_right_where_those_of_the_mesh_are_not),
      cmocka_unit_test(refining_goes_with_points_that_do_not_flow),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
