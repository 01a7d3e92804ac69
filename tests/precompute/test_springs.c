/* Springs between a body and the ground: in stiffness, forces, the reduced polynomial, steps of the
 * whole body and the estimate of its elements. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "mesh/mesh_springs.h"
#include "precompute/fem/fem_forces.h"
#include "precompute/full/full.h"
#include "precompute/model/model_fem.h"
#include "thrum/thrum.h"

static body body_on_springs(const char *name, const char *fix, const char *spring) {
  body made = body_make(name, fix);
  thrum_error error = {0};
  if (thrum_mesh_add_springs(&made.mesh, spring, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return made;
}

static void a_stiff_block_swings_as_a_mass_on_a_spring(void **state) {
  (void)state;
  body b = body_on_springs("beam:2x1x1@0.4x0.2x0.2", NULL, "x>=0:0,0,1000");
  thrum_error error = {0};

  // 16 kg, held across by springs that are stiffer
  assert_int_equal(thrum_mesh_add_springs(&b.mesh, "x>=0:1e6,1e6,0", &error), THRUM_OK);
  for (int64_t i = 0; i < b.mesh.region_count; i++)
    b.mesh.materials[i] = (thrum_material){1e12, 0.3, 1000};
  thrum_precomputed found = body_precompute(&b, 3, 6);
  assert_int_equal(found.rigid_count, 0);
  assert_true(fabs(found.mode_omega2[0] / (1000 / 16.0) - 1) < 1e-6);

  // elements that only move as a whole do not lock
  assert_true(found.order_error_count > 0);
  assert_true(fabs(found.order_error[0]) < 1e-6);
  thrum_precomputed_free(&found);
  body_free(&b);
}

static void the_polynomial_is_that_of_the_body_with_its_springs(void **state) {
  (void)state;
  body b = body_on_springs("beam:4x1x1@1x0.2x0.2", "x<0.001", "tip:3e3,2e3,1e3");
  thrum_precomputed found = body_precompute(&b, 3, 6);
  const thrum_model *model = &found.model;
  const int64_t r = model->rank, all = 3 * model->vertex_count;
  thrum_model_fem whole = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_model_fem_create(model, &whole, &error), THRUM_OK);

  // a large displacement of the model, and the forces there
  double *u = need((size_t)all, sizeof *u), *force = need((size_t)all, sizeof *force);
  double *work = need((size_t)thrum_work_count(model), sizeof *work), q[6], reduced[6];
  for (int64_t i = 0; i < r; i++)
    q[i] = 0.3 * random_number();
  for (int64_t c = 0; c < all; c++)
    u[c] = dot_of(model->basis + c * r, q, r);
  const double energy = thrum_fem_energy(&whole.fem, u, force);
  thrum_internal_force(model, q, reduced, work);
  assert_true(fabs(thrum_strain_energy(model, q, work) / energy - 1) < 1e-12);
  for (int64_t i = 0; i < r; i++) {
    double sum = 0;
    for (int64_t c = 0; c < all; c++)
      sum += model->basis[c * r + i] * force[c];
    assert_true(fabs(sum - reduced[i]) < 1e-10 * norm_of(reduced, r));
  }

  // several displacements at once have the same forces
  double *lanes = need((size_t)(2 * THRUM_FEM_LANES * all), sizeof *lanes);
  for (int64_t i = 0; i < THRUM_FEM_LANES * all; i++)
    lanes[i] = u[i / THRUM_FEM_LANES];
  thrum_fem_forces(&whole.fem, lanes, lanes + THRUM_FEM_LANES * all);
  for (int64_t c = 0; c < all; c++)
    assert_true(fabs(lanes[THRUM_FEM_LANES * (all + c)] - force[c]) < 1e-10 * norm_of(force, all));

  free(lanes);
  free(work);
  free(force);
  free(u);
  thrum_model_fem_free(&whole);
  thrum_precomputed_free(&found);
  body_free(&b);
}

static void steps_of_the_whole_body_keep_its_energy(void **state) {
  (void)state;
  body b = body_on_springs("beam:3x1x1@1x0.2x0.2", "x<0.001", "tip:2e4");
  thrum_precomputed found = body_precompute(&b, 2, 3);
  thrum_full_def def = thrum_default_full_def();
  thrum_full *full = NULL;
  thrum_error error = {0};
  assert_int_equal(thrum_full_create(&found.model, NULL, &def, &full, &error), THRUM_OK);

  // a fast start along z, which stretches the springs
  const int64_t all = 3 * found.model.vertex_count;
  double *v = need((size_t)all, sizeof *v);
  for (int64_t c = 2; c < all; c += 3)
    v[c] = found.model.fixed[c / 3] ? 0 : found.model.vertices[c - 2];
  assert_int_equal(thrum_full_set(full, NULL, v, &error), THRUM_OK);
  const double before = thrum_full_energy(full).total;
  for (int n = 0; n < 20; n++)
    assert_int_equal(thrum_full_step(full, &error), THRUM_OK);
  const double after = thrum_full_energy(full).total;
  assert_true(before > 0 && fabs(after / before - 1) < 1e-9);
  free(v);
  thrum_full_free(full);
  thrum_precomputed_free(&found);
  body_free(&b);
}

static void a_text_that_is_no_spring_changes_nothing(void **state) {
  (void)state;
  static const char *const bad[] = {"tip",     ":5",         "tip:",    "tip:-1", "tip:1,2",
                                    "tip:1,,", "tip:1,2,3,", "tip:nan", "no:5",   "x>9:5"};
  body b = body_make("beam:2x1x1@0.4x0.2x0.2", NULL);
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++) {
    thrum_error error = {0};
    assert_true(thrum_mesh_add_springs(&b.mesh, bad[n], &error) < 0);
    assert_true(error.message[0] != 0 && b.mesh.springs == NULL);
  }

  // what does not pull is no spring
  assert_int_equal(thrum_mesh_add_springs(&b.mesh, "tip:0", NULL), THRUM_OK);
  assert_null(b.mesh.springs);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_stiff_block_swings_as_a_mass_on_a_spring),
      cmocka_unit_test(the_polynomial_is_that_of_the_body_with_its_springs),
      cmocka_unit_test(steps_of_the_whole_body_keep_its_energy),
      cmocka_unit_test(a_text_that_is_no_spring_changes_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
