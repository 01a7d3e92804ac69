/* What a short load gives the mesh and what a basis takes of it (precompute/model/blow.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/model/blow.h"

#define DT 0.002
#define STEPS 3

static thrum_precomputed make_model(const body *b, int64_t modes, int64_t rank) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  thrum_precomputed result = {0};
  thrum_error error = {0};
  if (thrum_precompute(&b->mesh, b->fixed, &options, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return result;
}

/* A force at the last vertex of so many newtons. */
static double *force_of(const thrum_model *model, double newtons) {
  double *forces = need((size_t)(3 * model->vertex_count), sizeof *forces);
  forces[3 * model->vertex_count - 1] = newtons;
  forces[3 * model->vertex_count - 3] = 0.5 * newtons;
  return forces;
}

/* A basis of all coordinates takes all that the mesh is given; a smaller one less. */
static void a_basis_takes_what_it_has_of_a_blow(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@0.2x0.1x0.1", "x<0.001");
  thrum_precomputed whole = make_model(&b, 23, 24), few = make_model(&b, 2, 3);
  double *forces = force_of(&whole.model, 1);
  thrum_blow all, some;
  assert_int_equal(thrum_blow_measure(&whole.model, forces, DT, STEPS, &all, NULL), THRUM_OK);
  assert_int_equal(thrum_blow_measure(&few.model, forces, DT, STEPS, &some, NULL), THRUM_OK);
  assert_true(all.mesh > 0);
  assert_close(all.basis, all.mesh, 1e-9);
  assert_close(some.mesh, all.mesh, 1e-12);
  assert_true(some.basis > 0 && some.basis < 0.99 * some.mesh);
  free(forces);
  thrum_precomputed_free(&few);
  thrum_precomputed_free(&whole);
  body_free(&b);
}

/* Without a basis, or where nothing holds the body, it is refused and nothing is written. */
static void a_blow_on_what_nothing_holds_is_refused(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@0.2x0.1x0.1", NULL);
  thrum_precomputed made = make_model(&b, 2, 3);
  double *forces = force_of(&made.model, 1);
  thrum_blow blow = {7, 7};
  assert_int_equal(thrum_blow_measure(&made.model, forces, DT, STEPS, &blow, NULL), THRUM_MISSING);
  thrum_model bare = made.model;
  bare.rigid = NULL;
  bare.basis = NULL;
  assert_int_equal(thrum_blow_measure(&bare, forces, DT, STEPS, &blow, NULL), THRUM_MISSING);
  assert_true(blow.mesh == 7 && blow.basis == 7);
  free(forces);
  thrum_precomputed_free(&made);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_basis_takes_what_it_has_of_a_blow),
      cmocka_unit_test(a_blow_on_what_nothing_holds_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
