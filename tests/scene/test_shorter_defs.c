/* Tests of defs of programs that were compiled with the headers of an earlier version: those of the
 * library without their last members (docs/versioning.md). SPDX-License-Identifier: Apache-2.0 */
#include "core/base/def.h"
#include "tests/support/state_support.h"

#include "thrum/scene.h"

enum { RANK = 4, LESS = 2 * sizeof(int32_t) };

/* What the members that such a program lacks would read, if they were read. */
enum { BEYOND = 0xa5 };

static void a_shorter_state_def_has_the_defaults_of_the_rest(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  const double q[RANK] = {0.1, -0.2, 0.05, 0.02};

  // the last two members are of a later version; a library that read them would refuse these
  thrum_state_def whole = thrum_default_state_def(), shorter;
  memset(&shorter, BEYOND, sizeof shorter);
  thrum_state_def_init(&shorter, sizeof shorter - LESS);
  assert_int_equal(shorter.cookie, sizeof shorter - LESS);
  assert_int_equal(((unsigned char *)&shorter)[sizeof shorter - 1], BEYOND);
  whole.dt = shorter.dt = 1e-3;

  thrum_state *a = state_make(&m.model, &whole), *b = state_make(&m.model, &shorter);
  state_put(&m.model, a, q, NULL);
  state_put(&m.model, b, q, NULL);
  state_steps(&m.model, a, 20);
  state_steps(&m.model, b, 20);
  assert_memory_equal(a, b, thrum_state_kept_bytes(a));
  state_free(a);
  state_free(b);
  random_model_free(&m);
}

static void a_size_that_no_version_had_is_no_def(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  thrum_state_def def = thrum_default_state_def();
  const uint32_t whole = def.cookie,
                 wrong[] = {0, 1, THRUM_DEF_LEAST - 4, whole - 1, whole + 4, UINT32_MAX};
  for (size_t n = 0; n < sizeof wrong / sizeof *wrong; n++) {
    size_t size;
    def.cookie = wrong[n];
    assert_int_equal(thrum_state_size(&m.model, &def, &size, NULL), THRUM_UNINITIALISED_DEF);
  }
  random_model_free(&m);
}

/* What a later version has besides is 0, and this library takes the def. */
static void a_longer_def_is_taken_as_far_as_it_is_known(void **state) {
  (void)state;
  struct {
    thrum_scene_wind_def known;
    double later;
  } longer;
  memset(&longer, BEYOND, sizeof longer);
  thrum_scene_wind_def_init(&longer.known, sizeof longer);
  assert_int_equal(longer.known.cookie, sizeof longer.known);
  assert_true(longer.later == 0);
}

static void a_shorter_body_with_a_shorter_state_is_the_same_body(void **state) {
  (void)state;
  random_model m;
  random_model_make(&m, 3, RANK, 1.0, 30.0, 0.4);
  const double q[RANK] = {0.1, -0.2, 0.05, 0.02};
  thrum_scene_body_def whole = thrum_default_scene_body_def();
  whole.model = &m.model;
  whole.q = q;
  whole.stiffness = 2;

  // the same without the last members of both: what lies behind the state has moved up
  const size_t size = sizeof whole - 2 * LESS, inner = sizeof whole.state - LESS;
  union {
    thrum_scene_body_def def;
    unsigned char bytes[sizeof(thrum_scene_body_def)];
  } shorter;
  memset(&shorter, BEYOND, sizeof shorter);
  thrum_scene_body_def_init(&shorter.def, size, inner);
  assert_int_equal(shorter.def.cookie, size);
  assert_int_equal(shorter.def.state.cookie, inner);
  assert_int_equal(shorter.bytes[size], BEYOND);
  shorter.def.model = &m.model;
  memcpy(shorter.bytes + offsetof(thrum_scene_body_def, q) - LESS, &whole.q, sizeof whole.q);
  memcpy(shorter.bytes + offsetof(thrum_scene_body_def, stiffness) - LESS, &whole.stiffness,
         sizeof(double));

  double end[2][RANK];
  for (int n = 0; n < 2; n++) {
    thrum_scene *scene;
    assert_int_equal(thrum_scene_create(1e-3, &scene, NULL), THRUM_OK);
    assert_int_equal(thrum_scene_add_body(scene, n == 0 ? &whole : &shorter.def, NULL, NULL),
                     THRUM_OK);
    for (int k = 0; k < 20; k++)
      assert_true(thrum_scene_step(scene, NULL) >= 0);
    assert_true(thrum_scene_body_get(scene, 0, end[n], NULL, NULL) >= 0);
    thrum_scene_destroy(scene);
  }
  assert_memory_equal(end[0], end[1], sizeof end[0]);
  assert_true(end[0][0] != q[0]);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_shorter_state_def_has_the_defaults_of_the_rest),
      cmocka_unit_test(a_size_that_no_version_had_is_no_def),
      cmocka_unit_test(a_longer_def_is_taken_as_far_as_it_is_known),
      cmocka_unit_test(a_shorter_body_with_a_shorter_state_is_the_same_body),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
