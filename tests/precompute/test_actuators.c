/* Actuators on the mesh and in reduced coordinates: what they are, that both bodies have the same
 * energies, forces and tangents, and what is refused. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/acting_body.h"

#include "precompute/model/model_fem.h"

/* Theorem: on U q both bodies have the same energy and, by U^T, the same force. */
static void reduced_and_full_bodies_agree(bool quadratic) {
  acting_body a = act_on(hollow(true, quadratic), all_kinds, 3, 6);
  const thrum_model *model = &a.found.model;
  const int64_t r = model->rank, all = 3 * model->vertex_count;
  thrum_model_fem whole = {0};
  thrum_error error = {0};
  thrum_model acting;
  assert_int_equal(thrum_model_actuators(model), 6);
  double *memory = need((size_t)thrum_model_actuation_count(model), sizeof *memory);
  assert_int_equal(thrum_model_actuate(model, all_levels, memory, &acting, &error), THRUM_OK);
  assert_int_equal(thrum_model_fem_create(model, &whole, &error), THRUM_OK);
  if (thrum_model_fem_actuate(model, &whole, &error) < 0)
    fail_msg("%s", error.message);
  memcpy(whole.acting->levels, all_levels, sizeof all_levels);

  double *u = need((size_t)all, sizeof *u), *force = need((size_t)all, sizeof *force);
  double *work = need((size_t)thrum_work_count(model), sizeof *work);
  double *q = need((size_t)(6 * r), sizeof *q), *reduced = q + r, *ahead = q + 2 * r;
  double *v = q + 3 * r, *product = q + 4 * r, *behind = q + 5 * r;
  double *tangent = need((size_t)(r * r), sizeof *tangent);
  for (int64_t i = 0; i < r; i++) {
    q[i] = 0.02 * random_number();
    v[i] = random_number();
  }
  for (int64_t c = 0; c < all; c++)
    u[c] = dot_of(model->basis + c * r, q, r);
  const double energy = thrum_fem_energy(&whole.fem, u, force);
  assert_true(fabs(thrum_internal_force(&acting, q, reduced, work) / energy - 1) < 1e-10);
  assert_true(fabs(energy / thrum_strain_energy(model, q, work) - 1) > 0.01);
  for (int64_t i = 0; i < r; i++) {
    double sum = 0;
    for (int64_t c = 0; c < all; c++)
      sum += model->basis[c * r + i] * force[c];
    assert_true(fabs(sum - reduced[i]) < 1e-10 * norm_of(reduced, r));
  }

  // the tangent, its products, and differences of forces
  thrum_tangent_stiffness(&acting, q, tangent, work);
  thrum_tangent_product(&acting, q, v, product, work);
  const double h = 1e-5;
  for (int side = 0; side < 2; side++) {
    for (int64_t i = 0; i < r; i++)
      reduced[i] = q[i] + (side ? -h : h) * v[i];
    thrum_internal_force(&acting, reduced, side ? behind : ahead, work);
  }
  for (int64_t i = 0; i < r; i++) {
    const double row = dot_of(tangent + i * r, v, r);
    assert_true(fabs(row - product[i]) < 1e-11 * norm_of(product, r));
    assert_true(fabs((ahead[i] - behind[i]) / (2 * h) - row) < 1e-6 * norm_of(product, r));
    assert_true(fabs(model->actuator_rest[3 * (i % 6) + 2] - 1) < 1e-9);
  }

  free(tangent);
  free(q);
  free(work);
  free(force);
  free(u);
  free(memory);
  thrum_model_fem_free(&whole);
  acting_free(&a);
}

static void both_bodies_have_one_energy_and_force(void **state) {
  (void)state;
  reduced_and_full_bodies_agree(false);
  reduced_and_full_bodies_agree(true);
}

/* The tangent of the elements is the derivative of their force, but for caps and tendons. */
static void the_full_tangent_is_the_derivative_of_the_force(void **state) {
  (void)state;
  static const char *const texts[] = {"air=chamber:inside", "heat=swell:1", NULL};
  acting_body a = act_on(hollow(false, true), texts, 2, 4);
  thrum_model_fem whole = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_model_fem_create(&a.found.model, &whole, &error), THRUM_OK);
  assert_int_equal(thrum_model_fem_actuate(&a.found.model, &whole, &error), THRUM_OK);
  const thrum_fem *fem = &whole.fem;
  const int64_t n = fem->free_count, all = 3 * fem->vertex_count;
  double *u = need((size_t)(5 * all), sizeof *u), *force = u + all, *x = u + 2 * all;
  double *product = u + 3 * all, *at = u + 4 * all;
  for (int64_t i = 0; i < n; i++)
    x[i] = random_number();
  for (int64_t k = 0; k < 2; k++) {
    whole.acting->levels[0] = k == 0 ? 5e3 : 0;
    whole.acting->levels[1] = k == 1 ? 0.05 : 0;
    assert_int_equal(thrum_fem_stiffness(fem, u, &whole.stiffness, &error), THRUM_OK);
    thrum_sparse_product(&whole.stiffness, x, 1, product);
    double off = 0;
    const double h = 1e-6;
    for (int side = 0; side < 2; side++) {
      for (int64_t c = 0; c < all; c++)
        at[c] = u[c] + (fem->dof[c] < 0 ? 0 : (side ? -h : h) * x[fem->dof[c]]);
      thrum_fem_energy(fem, at, force);
      for (int64_t i = 0; i < n; i++)
        product[i] -= (side ? -1 : 1) * force[fem->component[i]] / (2 * h);
    }
    for (int64_t i = 0; i < n; i++)
      off = fmax(off, fabs(product[i]));
    assert_true(off < 1e-3 * 1e5 * 0.1);
  }
  free(u);
  thrum_model_fem_free(&whole);
  acting_free(&a);
}

static void specs_that_are_none_are_refused_in_one_line(void **state) {
  (void)state;
  static const struct {
    const char *text, *why;
  } bad[] = {
      {"air=chamber:inside", "open at the edge between vertices"},
      {"air=pressure:inside", "open at the edge between vertices"},
      {"air=chamber:nowhere", "no group 'nowhere'"},
      {"air=chamber:tip,lid", "comes cap"},
      {"wire=tendon:vertex=1,vertex=9999", "no vertex 9999"},
      {"wire=tendon:vertex=1", "two points"},
      {"wire=tendon:vertex=1,vertex=1", "are the same"},
      {"m=muscle:all,0,0,0", "direction"},
      {"m=muscle:all,1,0", "REGION,dx,dy,dz"},
      {"m=swell:7", "no region of the mesh"},
      {"e=eigenstrain:1,0,0,0,0,0,0", "does nothing"},
      {"no spec", "NAME=SPEC"},
      {"x=lever:1", "an actuator is"},
      {"x=lever", "what it is"},
  };
  body b = hollow(true, false);
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    thrum_error error = {0};
    thrum_actuator actuator;
    assert_true(thrum_actuator_read(&b.mesh, b.fixed, bad[n].text, &actuator, &error) < 0);
    if (!strstr(error.message, bad[n].why) || strchr(error.message, '\n'))
      fail_msg("%s: %s", bad[n].text, error.message);
    assert_null(actuator.text);
  }

  // a region that nothing is of
  thrum_error error = {0};
  thrum_actuator actuator;
  body_divide(&b, -1);
  assert_true(thrum_actuator_read(&b.mesh, b.fixed, "m=swell:1", &actuator, &error) < 0);
  assert_non_null(strstr(error.message, "no tetrahedra"));
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(both_bodies_have_one_energy_and_force),
      cmocka_unit_test(the_full_tangent_is_the_derivative_of_the_force),
      cmocka_unit_test(specs_that_are_none_are_refused_in_one_line),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
