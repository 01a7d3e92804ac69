/* Bases that contain the responses to given handles (design 2), and the share of a load that a
 * basis lacks (design 10). SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/basis/handles.h"
#include "precompute/model/load_share.h"

static thrum_precomputed precompute_with(const body *b, int64_t modes, int64_t rank, int64_t count,
                                         const thrum_handle *handles) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  options.handles = handles;
  options.handle_count = count;
  thrum_precomputed result = {0};
  thrum_error error = {0};
  if (thrum_precompute(&b->mesh, b->fixed, &options, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return result;
}

static thrum_handle find_handle(const body *b, const char *spec) {
  thrum_handle handle = {0};
  thrum_error error = {0};
  if (thrum_handle_find(&b->mesh, spec, &handle, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return handle;
}

// the relative error of the reduced linear static answer to forces on all components
static double static_error(const body *b, const thrum_model *model, const double *forces) {
  thrum_fem fem = body_fem(b);
  thrum_sparse k;
  thrum_factor *factor = NULL;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_stiffness(&fem, NULL, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_factor_create(&k, &factor, NULL), THRUM_OK);

  // the full-order answer x, and the reduced one from the modes' frequencies
  const int64_t n = fem.free_count, r = model->rank;
  double *x = need((size_t)n, sizeof *x), *q = need((size_t)r, sizeof *q);
  thrum_fem_gather(&fem, forces, x);
  assert_int_equal(thrum_factor_solve(factor, x, 1, x, NULL), THRUM_OK);
  for (int64_t i = 0; i < r; i++)
    for (int64_t c = 0; c < 3 * fem.vertex_count; c++)
      q[i] += model->basis[c * r + i] * forces[c] / model->omega2[i];

  // the relative distance of U q from x
  double off = 0;
  for (int64_t i = 0; i < n; i++) {
    const double difference = x[i] - dot_of(model->basis + fem.component[i] * r, q, r);
    off += difference * difference;
  }
  off = sqrt(off) / norm_of(x, n);

  free(x);
  free(q);
  thrum_factor_free(factor);
  thrum_sparse_free(&k);
  thrum_fem_free(&fem);
  return off;
}

static thrum_load_share share_of(const thrum_model *model, const double *forces) {
  thrum_load_share share = {0};
  thrum_error error = {0};
  if (thrum_load_share_measure(model, 1, forces, &share, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return share;
}

static void a_pull_at_a_handle_gives_the_full_order_static_answer(void **state) {
  (void)state;
  body b = body_make("beam:10x2x2@1x0.2x0.15", "x<0.001");

  // a group and a single vertex, with and without their responses in the basis
  const char *const specs[] = {"right", "vertex=50"};
  const thrum_handle handles[] = {find_handle(&b, specs[0]), find_handle(&b, specs[1])};
  thrum_precomputed with = precompute_with(&b, 5, 14, 2, handles);
  thrum_precomputed without = precompute_with(&b, 5, 14, 0, NULL);
  assert_true(with.basis_orthonormality < 1e-12 && with.basis_diagonality < 1e-12);

  // with them the static answer is exact; without them it is far off
  for (int h = 0; h < 2; h++) {
    double *forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces);
    const double pull[3] = {3, -2, 5};
    assert_int_equal(thrum_load_fill(&with.model, h == 0 ? handles[0].vertices : &handles[1].vertex,
                                     handles[h].count, pull, forces, NULL),
                     THRUM_OK);
    assert_true(static_error(&b, &with.model, forces) < 1e-8);
    assert_true(static_error(&b, &without.model, forces) > 1e-3);
    assert_true(share_of(&with.model, forces).statics < 1e-8);
    assert_true(share_of(&without.model, forces).statics > 1e-2);
    free(forces);
  }

  thrum_precomputed_free(&with);
  thrum_precomputed_free(&without);
  body_free(&b);
}

static void a_basis_with_handles_holds_the_one_without(void **state) {
  (void)state;
  body b = body_make("beam:10x2x2@1x0.2x0.15", "x<0.001");
  const thrum_handle tip = find_handle(&b, "tip");
  thrum_precomputed with = precompute_with(&b, 5, 16, 1, &tip);
  thrum_precomputed without = precompute_with(&b, 5, 10, 0, NULL);
  thrum_fem fem = body_fem(&b);
  thrum_sparse k, m;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // each of its vectors has its whole length in the larger basis
  double *column = need((size_t)fem.free_count, sizeof *column);
  double *product = need((size_t)fem.free_count, sizeof *product);
  for (int64_t j = 0; j < without.model.rank; j++) {
    for (int64_t i = 0; i < fem.free_count; i++)
      column[i] = without.model.basis[fem.component[i] * without.model.rank + j];
    thrum_sparse_product(&m, column, 1, product);
    double square = 0;
    for (int64_t r = 0; r < with.model.rank; r++) {
      double share = 0;
      for (int64_t i = 0; i < fem.free_count; i++)
        share += with.model.basis[fem.component[i] * with.model.rank + r] * product[i];
      square += share * share;
    }
    assert_true(fabs(square - 1) < 1e-9);
  }

  free(column);
  free(product);
  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  thrum_precomputed_free(&with);
  thrum_precomputed_free(&without);
  body_free(&b);
}

static void the_rank_may_be_just_the_responses_and_the_same_handle_counts_once(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.2x0.15", "x<0.001");
  const thrum_handle one = find_handle(&b, "tip"), twice[] = {one, one};

  // rank equal to the number of responses: nothing but the responses is in the basis
  thrum_precomputed least = precompute_with(&b, 3, 3, 1, &one);
  assert_int_equal(least.model.rank, 3);
  thrum_precomputed same = precompute_with(&b, 3, 3, 2, twice);
  assert_near(same.model.omega2, least.model.omega2, 3, 1e-9);

  // a rank that leaves no room for the three responses is refused
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 3;
  options.rank = 2;
  options.handles = &one;
  options.handle_count = 1;
  thrum_precomputed refused = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &refused, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "handles"));

  thrum_precomputed_free(&least);
  thrum_precomputed_free(&same);
  body_free(&b);
}

/* A file that numbers its vertices from 1000, of which no element uses the first. */
static void a_vertex_is_named_as_in_the_file(void **state) {
  (void)state;
  int64_t number[9];
  int32_t vertex[9];
  for (int n = 0; n < 9; n++) {
    number[n] = 1000 + n;
    vertex[n] = n - 1;
  }
  const thrum_mesh mesh = {
      .vertex_count = 8, .file_vertex_count = 9, .file_number = number, .file_vertex = vertex};
  thrum_handle handle = {0};
  assert_int_equal(thrum_handle_find(&mesh, "vertex=1008", &handle, NULL), THRUM_OK);
  assert_int_equal(handle.vertex, 7);
  assert_int_equal(thrum_handle_find(&mesh, "vertex=8", &handle, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_handle_find(&mesh, "vertex=1000", &handle, NULL), THRUM_INVALID_ARGUMENT);
}

static void handles_that_are_held_or_missing_are_refused(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.2x0.15", "x<0.001");

  // names and numbers that the mesh does not have leave the handle empty
  thrum_handle handle = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_handle_find(&b.mesh, "nowhere", &handle, &error), THRUM_MISSING);
  assert_int_equal(thrum_handle_find(&b.mesh, "vertex=0", &handle, &error), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_handle_find(&b.mesh, "vertex=64", &handle, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_handle_find(&b.mesh, "vertex=1x", &handle, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_null(handle.name);

  // a handle on the clamped face can respond to nothing
  handle = find_handle(&b, "left");
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = 3;
  options.handles = &handle;
  options.handle_count = 1;
  thrum_precomputed result = {0};
  assert_int_equal(thrum_precompute(&b.mesh, b.fixed, &options, &result, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_non_null(strstr(error.message, "left"));

  body_free(&b);
}

static void a_handle_held_along_two_axes_gives_one_response(void **state) {
  (void)state;
  body b = body_make("beam:8x2x2@1x0.2x0.15", "x<0.001");
  const thrum_handle tip = find_handle(&b, "tip");
  for (int64_t n = 0; n < tip.count; n++)
    b.fixed[tip.vertices ? tip.vertices[n] : tip.vertex] = 6;
  thrum_precomputed result = precompute_with(&b, 3, 8, 1, &tip);
  assert_true(result.basis_orthonormality < 1e-12);
  assert_true(isfinite(result.mode_omega2[3]));
  assert_true(isinf(result.mode_omega2[4]) && isinf(result.mode_omega2[5]));
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void a_load_along_a_column_of_mu_is_inside_and_a_point_force_is_not(void **state) {
  (void)state;

  // the load M u_0 has no share outside of the basis, since U U^T M u_0 = u_0
  body b = body_make("beam:8x2x2@1x0.2x0.15", "x<0.001");
  thrum_precomputed held = body_precompute(&b, 4, 8);
  thrum_fem fem = body_fem(&b);
  thrum_sparse k, m;
  assert_int_equal(thrum_fem_pattern(&fem, &k, NULL), THRUM_OK);
  assert_int_equal(thrum_fem_mass(&fem, THRUM_MASS_CONSISTENT, &k, &m, NULL), THRUM_OK);

  // the load that accelerates the body along column 3 of the basis
  double *column = need((size_t)fem.free_count, sizeof *column);
  double *product = need((size_t)fem.free_count, sizeof *product);
  double *forces = need((size_t)(3 * fem.vertex_count), sizeof *forces);
  for (int64_t i = 0; i < fem.free_count; i++)
    column[i] = held.model.basis[fem.component[i] * held.model.rank + 3];
  thrum_sparse_product(&m, column, 1, product);
  thrum_fem_scatter(&fem, product, forces);
  assert_true(share_of(&held.model, forces).load < 1e-12);

  // a smooth basis represents little of a point force, but much of its static response
  memset(forces, 0, sizeof *forces * (size_t)(3 * fem.vertex_count));
  forces[3 * fem.vertex_count - 1] = 1;
  const thrum_load_share point = share_of(&held.model, forces);
  assert_true(point.load > 0.3 && point.load < 1 && point.statics < point.load);

  thrum_sparse_free(&k);
  thrum_sparse_free(&m);
  thrum_fem_free(&fem);
  thrum_precomputed_free(&held);
  body_free(&b);
  free(column);
  free(product);
  free(forces);

  // the response to a handle is exact for a free body too
  b = body_make("beam:8x2x2@1x0.2x0.15", NULL);
  const thrum_handle tip = find_handle(&b, "tip");
  thrum_precomputed loose = precompute_with(&b, 4, 10, 1, &tip);
  forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces);
  assert_int_equal(thrum_load_fill(&loose.model, tip.vertices ? tip.vertices : &tip.vertex,
                                   tip.count, (double[]){0, 1, 2}, forces, NULL),
                   THRUM_OK);
  assert_true(share_of(&loose.model, forces).statics < 1e-8);

  // free fall deforms nothing, so its static share is undefined
  memset(forces, 0, sizeof *forces * (size_t)(3 * b.mesh.vertex_count));
  assert_int_equal(thrum_load_fill_gravity(&loose.model, (double[]){0, 0, -9.81}, forces, NULL),
                   THRUM_OK);
  assert_true(isnan(share_of(&loose.model, forces).statics));

  free(forces);
  thrum_precomputed_free(&loose);
  body_free(&b);
}

/* A slender bar of length L that turns with w across its axis is longer at either end by
 * rho w^2 L^3 / (24 E): the integral of the strain rho w^2 (L^2/4 - x^2) / (2 E) from its middle.
 * About its axis it is hardly stretched. */
static void a_spin_stretches_a_slender_bar_as_it_should(void **state) {
  (void)state;
  body b = body_make("beam:20x1x1@1x0.04x0.04", NULL);
  thrum_precomputed bar = precompute_with(&b, 6, 12, 0, NULL);
  const double young = bar.model.material[0], density = bar.model.material[2];
  const double spins[2][3] = {{0, 0, 3}, {3, 0, 0}};
  double reach[2];

  // about the middle, wherever the mesh lies
  for (int n = 0; n < 2; n++) {
    double *forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces);
    assert_int_equal(thrum_load_fill_spin(&bar.model, spins[n], forces, NULL), THRUM_OK);
    for (int axis = 0; axis < 3; axis++) {
      double sum = 0;
      for (int64_t v = 0; v < b.mesh.vertex_count; v++)
        sum += forces[3 * v + axis];
      assert_true(fabs(sum) < 1e-9 * density);
    }
    const thrum_load_share share = share_of(&bar.model, forces);
    reach[n] = share.reach;
    if (n == 0)
      assert_true(share.statics > 0.1 && share.statics <= 1);
    free(forces);
  }
  const double closed = density * 9 / (24 * young);
  print_message("stretch %.4g m, %.4g m expected\n", reach[0], closed);
  assert_true(fabs(reach[0] - closed) < 0.06 * closed);
  assert_true(reach[1] < 0.05 * closed);
  thrum_precomputed_free(&bar);
  body_free(&b);
}

/* A mass-PCA that had the modes among its candidates left the mode along the bar out at any rank
 * below 40, and showed a third of the stretch. */
static void the_usual_basis_of_a_bar_shows_what_its_spin_stretches(void **state) {
  (void)state;
  static const char *const bars[] = {"beam:20x1x1@1x0.04x0.04", "beam:20x2x2@1x0.05x0.05"};
  for (int n = 0; n < 2; n++) {
    body b = body_make(bars[n], NULL);
    thrum_precomputed bar = precompute_with(&b, 10, 0, 0, NULL);
    double *forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces);
    assert_int_equal(thrum_load_fill_spin(&bar.model, (double[]){0, 0, 3}, forces, NULL), THRUM_OK);
    assert_true(share_of(&bar.model, forces).statics < 0.05);
    free(forces);
    thrum_precomputed_free(&bar);
    body_free(&b);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_pull_at_a_handle_gives_the_full_order_static_answer),
      cmocka_unit_test(a_basis_with_handles_holds_the_one_without),
      cmocka_unit_test(the_rank_may_be_just_the_responses_and_the_same_handle_counts_once),
      cmocka_unit_test(a_vertex_is_named_as_in_the_file),
      cmocka_unit_test(handles_that_are_held_or_missing_are_refused),
      cmocka_unit_test(a_handle_held_along_two_axes_gives_one_response),
      cmocka_unit_test(a_spin_stretches_a_slender_bar_as_it_should),
      cmocka_unit_test(the_usual_basis_of_a_bar_shows_what_its_spin_stretches),
      cmocka_unit_test(a_load_along_a_column_of_mu_is_inside_and_a_point_force_is_not),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
