/* A precompute that finds no memory says so and leaves the result alone, whichever of its own
 * allocations fails, or has the same bits where memory only saves time; and one that follows has
 * the bits of one without a failure before it. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "tests/support/failing_allocator.h"

/* A hash of the model's numbers. */
static uint64_t hash_of(const thrum_model *model) {
  const struct {
    const double *numbers;
    int64_t count;
  } arrays[] = {{model->basis, 3 * model->vertex_count * model->rank},
                {model->omega2, model->rank},
                {model->c3, model->c3_count},
                {model->c4, model->c4_count}};
  uint64_t hash = 1469598103934665603u;
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++)
    for (int64_t k = 0; arrays[n].numbers != NULL && k < arrays[n].count; k++) {
      uint64_t bits;
      memcpy(&bits, arrays[n].numbers + k, sizeof bits);
      hash = (hash ^ bits) * 1099511628211u;
    }
  return hash;
}

/* Makes a model with each `stride`th of its allocations failing in turn. */
static void insist(const body *b, const thrum_precompute_options *options, int64_t stride) {
  thrum_error error = {0};
  thrum_precomputed first = {0}, last = {0}, poison;
  memset(&poison, 0xff, sizeof poison);
  if (thrum_precompute(&b->mesh, b->fixed, options, &first, &error) < 0)
    fail_msg("%s", error.message);
  for (int64_t n = 1;; n += stride) {
    thrum_precomputed result = poison;
    error = (thrum_error){0};
    fail_call(n);
    const thrum_status status = thrum_precompute(&b->mesh, b->fixed, options, &result, &error);
    if (!has_failed()) {
      assert_true(status >= 0);
      last = result;
      break;
    }
    if (status >= 0) {
      assert_true(hash_of(&result.model) == hash_of(&first.model));
      thrum_precomputed_free(&result);
      continue;
    }
    if (status != THRUM_OUT_OF_MEMORY || error.status != status || error.message[0] == 0)
      fail_msg("allocation %lld ends with %d: %s", (long long)n, (int)status, error.message);
    assert_memory_equal(&result, &poison, sizeof poison);
  }

  assert_true(hash_of(&last.model) == hash_of(&first.model));
  thrum_precomputed_free(&first);
  thrum_precomputed_free(&last);
}

static thrum_precompute_options options_of(int64_t modes, int64_t rank) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  options.check = THRUM_CHECK_SEARCH;
  return options;
}

static void a_held_body_of_tetrahedra(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@0.4x0.1x0.1", "x<0.001");
  thrum_precompute_options options = options_of(3, 6);
  const thrum_handle handle = {.name = "corner", .count = 1, .vertex = 7};
  options.handles = &handle;
  options.handle_count = 1;
  options.parameters = true;
  insist(&b, &options, 1);
  body_free(&b);
}

static void a_free_body_of_ten_nodes(void **state) {
  (void)state;
  body b = body_quadratic("beam:2x1x1@0.4x0.1x0.1", NULL, 0, 0);
  const thrum_precompute_options options = options_of(3, 6);
  insist(&b, &options, 1);
  body_free(&b);
}

static void a_body_of_solid_shells(void **state) {
  (void)state;
  body b = body_make("beam:3x2x1@0.3x0.2x0.01,hex", "x<0.001");
  const thrum_precompute_options options = options_of(3, 6);
  insist(&b, &options, 1);
  body_free(&b);
}

static void a_body_of_cubature_points(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@0.4x0.1x0.1", "x<0.001");
  thrum_precompute_options options = options_of(2, 4);
  options.cubature = true;
  options.cubature_error = 0.2;
  options.cubature_refine = 20;
  options.law = THRUM_LAW_COROTATIONAL;
  insist(&b, &options, 1);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_held_body_of_tetrahedra),
      cmocka_unit_test(a_free_body_of_ten_nodes),
      cmocka_unit_test(a_body_of_solid_shells),
      cmocka_unit_test(a_body_of_cubature_points),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
