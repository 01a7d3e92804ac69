/* A precompute that finds no memory says so and leaves the result alone, whichever of its own
 * allocations fails, or has the same bits where memory only saves time; and one that follows has
 * the bits of one without a failure before it. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/full/full.h"
#include "precompute/model/basis_judge.h"
#include "precompute/model/blow.h"
#include "precompute/model/touch.h"
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

/* --- what is done with a model ---------------------------------------------------------------- */

/* A model, its whole mesh, forces on it, and room for fields. */
typedef struct work {
  const thrum_model *model;
  thrum_full *full;
  double *forces, *field;
} work;

static thrum_error why;

static thrum_status make_whole(work *w) {
  thrum_full *full = NULL;
  const thrum_full_def def = thrum_default_full_def();
  const thrum_status status = thrum_full_create(w->model, NULL, &def, &full, &why);
  assert_true(status >= 0 || full == NULL);
  thrum_full_free(full);
  return status;
}

static thrum_status rest_whole(work *w) {
  thrum_full_equilibrium found;
  const int32_t right[3] = {2, 5, 8};
  const thrum_full_follower moment = {.vertices = right, .count = 3, .moment = {0, 1, 0}};
  const thrum_full_loading loading = {
      .forces = w->forces, .followers = &moment, .follower_count = 1};
  return thrum_full_rest_under(w->full, &loading, &found, &why);
}

static thrum_status watch_whole(work *w) {
  thrum_full_equilibrium found;
  const thrum_full_loading loading = {.forces = w->forces, .watch = true};
  return thrum_full_rest_under(w->full, &loading, &found, &why);
}

static thrum_status step_whole(work *w) {
  return thrum_full_step(w->full, &why);
}

static thrum_status blow_at(work *w) {
  thrum_blow blow;
  return thrum_blow_measure(w->model, w->forces, 0.01, 2, &blow, &why);
}

static thrum_status judge(work *w) {
  thrum_basis_judge *made = NULL;
  thrum_status status = thrum_basis_judge_create(w->model, 2, &made, &why);
  assert_true(status >= 0 || made == NULL);
  THRUM_THEN(status, thrum_basis_judge_begin(made, &why));
  thrum_basis_judge_free(made);
  return status;
}

static thrum_status touch(work *w) {
  thrum_touch *made = NULL;
  const thrum_status status = thrum_touch_create(w->model, &made, &why);
  assert_true(status >= 0 || made == NULL);
  thrum_touch_free(made);
  return status;
}

static void calls_on_a_model_leave_the_whole_mesh_as_it_was(void **state) {
  (void)state;
  static const struct {
    const char *what;
    thrum_status (*call)(work *w);
  } calls[] = {{"a whole mesh", make_whole},
               {"a step", step_whole},
               {"an equilibrium", rest_whole},
               {"one that is watched", watch_whole},
               {"a blow", blow_at},
               {"a judge", judge},
               {"touch", touch}};
  body b = body_make("beam:2x1x2@0.4x0.1x0.1", "x<0.001");
  thrum_precomputed made = body_precompute(&b, 3, 6);
  const size_t all = 3 * (size_t)made.model.vertex_count;
  work w = {.model = &made.model,
            .forces = need(all, sizeof(double)),
            .field = need(all, sizeof(double))};
  w.forces[all - 1] = 0.5;
  const thrum_full_def def = thrum_default_full_def();
  assert_int_equal(thrum_full_create(&made.model, NULL, &def, &w.full, &why), THRUM_OK);
  assert_int_equal(thrum_full_set_force(w.full, w.forces, &why), THRUM_OK);

  // each allocation of each call fails once; the displacement then is that of before
  double *before = need(all, sizeof *before);
  for (size_t k = 0; k < sizeof calls / sizeof *calls; k++)
    for (int64_t n = 1;; n++) {
      thrum_full_get(w.full, before, NULL);
      fail_call(n);
      const thrum_status status = calls[k].call(&w);
      if (!has_failed()) {
        if (status < 0)
          fail_msg("%s: %s", calls[k].what, why.message);
        break;
      }
      if (status >= 0)
        continue;
      if (status != THRUM_OUT_OF_MEMORY)
        fail_msg("%s: allocation %lld ends with %d", calls[k].what, (long long)n, (int)status);
      thrum_full_get(w.full, w.field, NULL);
      assert_memory_equal(w.field, before, all * sizeof *before);
    }

  free(before);
  free(w.forces);
  free(w.field);
  thrum_full_free(w.full);
  thrum_precomputed_free(&made);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_held_body_of_tetrahedra),
      cmocka_unit_test(a_free_body_of_ten_nodes),
      cmocka_unit_test(a_body_of_solid_shells),
      cmocka_unit_test(a_body_of_cubature_points),
      cmocka_unit_test(calls_on_a_model_leave_the_whole_mesh_as_it_was),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
