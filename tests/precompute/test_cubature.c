/* Cubature points: all points of a mesh with their own volumes give the exact polynomial, chosen
 * ones the error that was asked for in states of other kinds, and the least squares behind them
 * obey the conditions of Kuhn and Tucker.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/model/model_fill.h"
#include "precompute/polynomial/nonnegative.h"
#include "thrum/polynomial.h"

static thrum_precompute_options options_of(int64_t modes, int64_t rank) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  options.check = THRUM_CHECK_SEARCH;
  return options;
}

/* Coordinates whose displacements are some tenths of a metre: even in energy, random in sign. */
static void random_state(const thrum_model *model, double size, double *q) {
  for (int64_t i = 0; i < model->rank; i++)
    q[i] = size * random_number() * sqrt(model->omega2[0] / model->omega2[i]);
}

static void assert_all_points_are_exact(const body *b) {
  enum { RANK = 12 };
  thrum_error error = {0};
  const thrum_precompute_options options = options_of(6, RANK);
  thrum_precomputed made = {0};
  if (thrum_precompute(&b->mesh, b->fixed, &options, &made, &error) < 0)
    fail_msg("%s", error.message);

  // every point of every element, with its own volume
  thrum_fem fem = {0};
  assert_true(thrum_fem_create(&b->mesh, b->fixed, &fem, &error) >= 0);
  const int64_t count = fem.tet_count * fem.point_count;
  int64_t *places = need((size_t)count, sizeof *places);
  for (int64_t p = 0; p < count; p++)
    places[p] = p;
  thrum_model points = made.model;
  points.c3 = points.c4 = NULL;
  points.c3_count = points.c4_count = 0;
  assert_int_equal(thrum_cubature_fill(&fem, count, places, fem.weight, &points, &error), THRUM_OK);
  assert_int_equal(thrum_model_check(&points, &error), THRUM_OK);

  // energy and force, from small displacements to large ones
  double q[RANK], force[2][RANK], *work = need(thrum_work_count(&made.model), sizeof *work);
  for (int n = 0; n < 20; n++) {
    random_state(&made.model, 0.01 * pow(1.4, n), q);
    const double exact = thrum_internal_force(&made.model, q, force[0], work);
    const double found = thrum_internal_force(&points, q, force[1], work);
    assert_true(fabs(found / exact - 1) < 1e-12);
    double size = 0, difference = 0;
    for (int i = 0; i < RANK; i++) {
      size = fmax(size, fabs(force[0][i]));
      difference = fmax(difference, fabs(force[1][i] - force[0][i]));
    }
    assert_true(difference < 1e-11 * size);
  }

  // the points belong to this test, the rest to the result
  thrum_model own = {.point_weights = points.point_weights,
                     .point_moduli = points.point_moduli,
                     .point_gradients = points.point_gradients};
  thrum_model_fill_free(&own);
  thrum_precomputed_free(&made);
  thrum_fem_free(&fem);
  free(places);
  free(work);
}

static void all_points_with_their_volumes_give_the_exact_polynomial(void **state) {
  (void)state;
  body linear = body_make("beam:6x2x2@1x0.2x0.2", "x<0.001");
  assert_all_points_are_exact(&linear);
  body_free(&linear);
  body quadratic = body_quadratic("beam:4x1x1@1x0.2x0.2", "x<0.02", 0.003, 0.003);
  assert_all_points_are_exact(&quadratic);
  body_free(&quadratic);
}

static void all_points_of_another_law_give_the_force_of_the_body(void **state) {
  (void)state;
  enum { RANK = 9 };
  body b = body_make("beam:5x2x2@1x0.2x0.2", "x<0.001");
  thrum_error error = {0};
  thrum_precompute_options options = options_of(4, RANK);
  options.cubature = true;
  options.cubature_error = 0.1;
  for (int law = THRUM_LAW_COROTATIONAL; law <= THRUM_LAW_BY_REGION; law++) {
    thrum_precomputed made = {0};
    options.law = (thrum_law)law;
    if (law == THRUM_LAW_BY_REGION)
      body_divide(&b, 1);
    if (thrum_precompute(&b.mesh, b.fixed, &options, &made, &error) < 0)
      fail_msg("%s", error.message);
    assert_int_equal(thrum_model_check(&made.model, &error), THRUM_OK);
    assert_true(thrum_law_of_model(&made.model) == (thrum_law)law);
    assert_int_equal(made.model.format[0], law == THRUM_LAW_BY_REGION
                                               ? THRUM_MODEL_FORMAT_MAJOR_REGIONS
                                               : THRUM_MODEL_FORMAT_MAJOR_LAW);

    // points of one law stand together
    for (int64_t p = 1; p < made.model.point_count && law == THRUM_LAW_BY_REGION; p++)
      assert_true(made.model.region_law[made.model.point_region[p]] >=
                  made.model.region_law[made.model.point_region[p - 1]]);
    assert_true(made.cubature.test_error <= 0.1);

    // every point of every element in the place of those that were chosen
    thrum_fem fem = body_fem(&b);
    fem.law = (thrum_law)law;
    const int64_t count = fem.tet_count * fem.point_count, rows = 3 * fem.vertex_count;
    int64_t *places = need((size_t)count, sizeof *places);
    for (int64_t p = 0; p < count; p++)
      places[p] = p;
    thrum_model points = made.model;
    assert_int_equal(thrum_cubature_fill(&fem, count, places, fem.weight, &points, &error),
                     THRUM_OK);

    // U^T of the force on the mesh, at large displacements
    double q[RANK], force[RANK], whole[RANK] = {0};
    double *u = need((size_t)rows, sizeof *u), *on_mesh = need((size_t)rows, sizeof *on_mesh);
    double *work = need(thrum_work_count(&points), sizeof *work);
    random_state(&points, 0.3, q);
    for (int64_t c = 0; c < rows; c++)
      for (int i = 0; i < RANK; i++)
        u[c] += points.basis[c * RANK + i] * q[i];
    const double energy = thrum_fem_energy(&fem, u, on_mesh);
    for (int64_t c = 0; c < rows; c++)
      for (int i = 0; i < RANK; i++)
        whole[i] += points.basis[c * RANK + i] * on_mesh[c];
    assert_close(thrum_internal_force(&points, q, force, work), energy, 1e-11);
    assert_near(force, whole, RANK, 1e-11);

    // the points belong to this test, the rest to the result
    thrum_model own = {.point_weights = points.point_weights,
                       .point_moduli = points.point_moduli,
                       .point_region = points.point_region,
                       .point_gradients = points.point_gradients};
    thrum_model_fill_free(&own);
    thrum_precomputed_free(&made);
    thrum_fem_free(&fem);
    free(places);
    free(u);
    free(on_mesh);
    free(work);
  }
  body_free(&b);
}

static void chosen_points_have_the_error_that_was_asked_for(void **state) {
  (void)state;
  enum { RANK = 15 };
  body b = body_make("beam:12x3x3@1x0.15x0.15", "x<0.001");
  thrum_error error = {0};
  thrum_precompute_options options = options_of(6, RANK);
  thrum_precomputed exact = {0}, made = {0};
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &exact, &error) >= 0);
  options.cubature = true;
  options.cubature_error = 0.02;
  if (thrum_precompute(&b.mesh, b.fixed, &options, &made, &error) < 0)
    fail_msg("%s", error.message);

  // fewer points than elements, weights positive, the error that was asked for
  const thrum_cubature_figures *figures = &made.cubature;
  assert_true(made.model.c3 == NULL && made.model.point_count == figures->points);
  assert_true(figures->points > 10 && figures->points < b.mesh.tet_count / 4);
  assert_true(figures->test_error <= 0.02 && figures->train_error > 0.001);
  assert_int_equal(thrum_model_check(&made.model, &error), THRUM_OK);
  double volume = 0;
  for (int64_t p = 0; p < made.model.point_count; p++)
    volume += made.model.point_weights[p];
  assert_true(fabs(volume / made.volume - 1) < 0.3);

  // frequencies are exact, and so is the force of small motion
  double q[RANK], force[2][RANK], *work = need(thrum_work_count(&exact.model), sizeof *work);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(made.model.omega2[i] / exact.model.omega2[i] - 1) < 1e-9);
  random_state(&made.model, 1e-7, q);
  thrum_internal_force(&made.model, q, force[0], work);
  for (int i = 0; i < RANK; i++)
    assert_true(fabs(force[0][i] - made.model.omega2[i] * q[i]) <
                1e-4 * fabs(made.model.omega2[i] * q[i]));

  // states that training never saw: the first mode alone, and two of them
  double sum = 0;
  for (int n = 0; n < 20; n++) {
    memset(q, 0, sizeof q);
    q[0] = 0.3 * random_number();
    q[1] = n % 2 ? 0.3 * random_number() : 0;
    thrum_internal_force(&made.model, q, force[0], work);
    thrum_internal_force(&exact.model, q, force[1], work);
    double size = 0, difference = 0;
    for (int i = 0; i < RANK; i++) {
      size += force[1][i] * force[1][i] / exact.model.omega2[i];
      difference += pow(force[0][i] - force[1][i], 2) / exact.model.omega2[i];
    }
    sum += difference / size / 20;
  }
  assert_true(sqrt(sum) < 0.1);

  // gradients are single-precision numbers, which a large model is packed as
  for (int64_t k = 0; k < 9 * made.model.point_count * RANK; k++)
    assert_true((float)made.model.point_gradients[k] == made.model.point_gradients[k]);

  // the same input gives the same points
  thrum_precomputed again = {0};
  assert_true(thrum_precompute(&b.mesh, b.fixed, &options, &again, &error) >= 0);
  assert_int_equal(again.model.point_count, made.model.point_count);
  assert_memory_equal(again.model.point_weights, made.model.point_weights,
                      (size_t)made.model.point_count * sizeof(double));
  thrum_precomputed_free(&exact);
  thrum_precomputed_free(&made);
  thrum_precomputed_free(&again);
  body_free(&b);
  free(work);
}

static void options_out_of_range_are_refused(void **state) {
  (void)state;
  body b = body_make("beam:4x1x1@1x0.2x0.2", "x<0.001");
  thrum_error error = {0};
  thrum_precomputed made = {0};
  thrum_precompute_options options = options_of(3, 6);

  // no set of points is without error
  options.cubature = true;
  options.cubature_error = 0;
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, &error),
                   THRUM_INVALID_ARGUMENT);

  // nor is one of more than all of the force of use, nor more points than a mesh has
  const double errors[] = {1.5, INFINITY, NAN, 0.01, 0.01};
  const double ranges[] = {0.2, 0.2, 0.2, 11, 0.2};
  const int64_t counts[] = {10, 10, 10, 10, INT64_C(1) << 40};
  for (int n = 0; n < 5; n++) {
    options.cubature_error = errors[n];
    options.cubature_range = ranges[n];
    options.cubature_points = counts[n];
    assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, &error),
                     THRUM_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "at most 1, 1000000 and 10"));
  }
  options = options_of(3, 6);

  options.cubature = false;
  options.law = THRUM_LAW_NEO_HOOKEAN;
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "a polynomial cannot hold it"));

  options.law = THRUM_LAW_STVK;
  options.cubature = true;
  options.cubature_error = 0.01;
  options.single = true;
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &made, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "single precision"));
  body_free(&b);
}

enum { UNKNOWNS = 12, ROWS = 30 };

static bool never(void *context, int64_t used, const int64_t *places, const double *x) {
  (void)context, (void)used, (void)places, (void)x;
  return false;
}

static void least_squares_obey_kuhn_and_tucker(void **state) {
  (void)state;
  for (int round = 0; round < 20; round++) {
    // a random problem, every other one with an exact answer that has zeros
    double a[ROWS][UNKNOWNS], b[ROWS], products[UNKNOWNS * UNKNOWNS], projections[UNKNOWNS];
    double answer[UNKNOWNS], target = 0;
    for (int j = 0; j < UNKNOWNS; j++)
      answer[j] = j % 3 ? fabs(random_number()) : 0;
    for (int i = 0; i < ROWS; i++) {
      b[i] = round % 2 ? random_number() : 0;
      for (int j = 0; j < UNKNOWNS; j++) {
        a[i][j] = random_number();
        b[i] += a[i][j] * answer[j];
      }
      target += b[i] * b[i];
    }
    for (int j = 0; j < UNKNOWNS; j++) {
      projections[j] = 0;
      for (int i = 0; i < ROWS; i++)
        projections[j] += a[i][j] * b[i];
      for (int k = 0; k < UNKNOWNS; k++) {
        products[j * UNKNOWNS + k] = 0;
        for (int i = 0; i < ROWS; i++)
          products[j * UNKNOWNS + k] += a[i][j] * a[i][k];
      }
    }

    const thrum_squares squares = {UNKNOWNS, products, projections, target};
    int64_t places[UNKNOWNS], used = 0;
    double x[UNKNOWNS], full[UNKNOWNS] = {0};
    assert_int_equal(thrum_nonnegative(&squares, UNKNOWNS, never, NULL, places, x, &used, NULL),
                     THRUM_OK);
    for (int64_t k = 0; k < used; k++) {
      assert_true(x[k] > 0);
      full[places[k]] = x[k];
    }

    // no slope where x > 0, none downwards where it is 0; the squares are those of the residual
    double left = 0;
    for (int i = 0; i < ROWS; i++) {
      double r = b[i];
      for (int j = 0; j < UNKNOWNS; j++)
        r -= a[i][j] * full[j];
      left += r * r;
    }
    assert_true(fabs(thrum_squares_of(&squares, used, places, x) - left) < 1e-10 * target);
    for (int j = 0; j < UNKNOWNS; j++) {
      double slope = projections[j];
      for (int k = 0; k < UNKNOWNS; k++)
        slope -= products[j * UNKNOWNS + k] * full[k];
      assert_true(full[j] > 0 ? fabs(slope) < 1e-9 : slope < 1e-9);
      if (round % 2 == 0)
        assert_true(fabs(full[j] - answer[j]) < 1e-9);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_points_with_their_volumes_give_the_exact_polynomial),
      cmocka_unit_test(all_points_of_another_law_give_the_force_of_the_body),
      cmocka_unit_test(chosen_points_have_the_error_that_was_asked_for),
      cmocka_unit_test(options_out_of_range_are_refused),
      cmocka_unit_test(least_squares_obey_kuhn_and_tucker),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
