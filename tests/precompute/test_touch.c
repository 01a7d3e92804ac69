/* How a model follows pulls at its surface, and touch modes (design 2).
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"

#include "precompute/model/load_share.h"
#include "precompute/model/touch_follow.h"
#include "thrum/condensed_model.h"

static thrum_precomputed make_model(const body *b, int64_t modes, int64_t rank,
                                    const double *trained, int64_t count) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank + count;
  options.trained = trained;
  options.trained_count = count;
  thrum_precomputed result = {0};
  thrum_error error = {0};
  if (thrum_precompute(&b->mesh, b->fixed, &options, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return result;
}

static thrum_touch *make_touch(const thrum_model *model) {
  thrum_touch *touch = NULL;
  thrum_error error = {0};
  if (thrum_touch_create(model, &touch, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return touch;
}

/* A basis of all coordinates of a small body spans all displacements, so it shows the whole give.
 */
static void a_basis_of_all_coordinates_follows_every_pull(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@0.2x0.1x0.1", "x<0.001");
  thrum_precomputed whole = make_model(&b, 23, 24, NULL, 0);
  thrum_touch *touch = make_touch(&whole.model);
  thrum_touch_coverage coverage;
  thrum_touch_measure(touch, &whole.model, &coverage);
  assert_true(fabs(coverage.worst - 1) < 1e-9 && fabs(coverage.mean - 1) < 1e-9);
  assert_true(fabs(coverage.direction - 1) < 1e-9);
  assert_int_equal(coverage.places + coverage.stiff, 8);

  thrum_touch_free(touch);
  thrum_precomputed_free(&whole);
  body_free(&b);
}

/* The share of the energy of a static answer that is shown is that of the give: for a patch of one
 * vertex 1 less the square of the share that the load is said to lack, weighed by the gives. */
static void the_worst_place_is_followed_as_the_share_of_its_loads_says(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.5x0.5", "x<0.001");
  thrum_precomputed made = make_model(&b, 4, 8, NULL, 0);
  thrum_touch *touch = make_touch(&made.model);
  thrum_touch_coverage coverage;
  thrum_touch_measure(touch, &made.model, &coverage);
  assert_true(coverage.worst > 0 && coverage.worst < coverage.mean && coverage.mean < 1);

  // vertices are farther from each other than a patch reaches
  double shown = 0, whole = 0;
  const int64_t rank = made.model.rank, all = 3 * made.model.vertex_count;
  for (int axis = 0; axis < 3; axis++) {
    double *forces = need((size_t)all, sizeof *forces), give = 0;
    thrum_load_share share;
    forces[3 * coverage.vertex + axis] = 1;
    assert_int_equal(thrum_load_share_measure(&made.model, 1, forces, &share, NULL), THRUM_OK);
    for (int64_t i = 0; i < rank; i++) {
      const double u = made.model.basis[(3 * coverage.vertex + axis) * rank + i];
      give += u * u / made.model.omega2[i];
    }
    shown += give;
    whole += give / (1 - share.statics * share.statics);
    free(forces);
  }
  assert_true(fabs(coverage.worst - shown / whole) < 1e-9);

  thrum_touch_free(touch);
  thrum_precomputed_free(&made);
  body_free(&b);
}

/* No direction at the place of the worst direction is followed by less than is said of it, and one
 * is by hardly more: the shares of many directions are those that single loads have. */
static void the_worst_direction_is_the_least_of_many_at_its_place(void **state) {
  (void)state;
  body b = body_make("beam:6x2x2@1x0.5x0.5", "x<0.001");
  thrum_precomputed made = make_model(&b, 4, 8, NULL, 0);
  thrum_touch *touch = make_touch(&made.model);
  thrum_touch_coverage coverage;
  thrum_touch_measure(touch, &made.model, &coverage);
  assert_true(coverage.direction < coverage.worst);

  // directions over half a sphere, twelve degrees apart at most
  double least = INFINITY;
  double *forces = need((size_t)(3 * made.model.vertex_count), sizeof *forces);
  for (int k = 0; k < 400; k++) {
    const double up = (k + 0.5) / 400, turn = 2.399963229728653 * k, out = sqrt(1 - up * up);
    double *force = forces + 3 * coverage.direction_vertex;
    force[0] = out * cos(turn);
    force[1] = out * sin(turn);
    force[2] = up;
    thrum_load_share share;
    assert_int_equal(thrum_load_share_measure(&made.model, 1, forces, &share, NULL), THRUM_OK);
    least = fmin(least, 1 - share.statics * share.statics);
  }
  assert_true(least > coverage.direction - 1e-9 && least < coverage.direction + 0.05);

  free(forces);
  thrum_touch_free(touch);
  thrum_precomputed_free(&made);
  body_free(&b);
}

/* Touch modes of a body, held or free, and the model with them. */
static void check_modes(const char *fix, double share) {
  body b = body_make("beam:8x2x2@1x0.2x0.2", fix);
  thrum_precomputed usual = make_model(&b, 4, 6, NULL, 0);
  thrum_touch *touch = make_touch(&usual.model);
  thrum_touch_coverage before, after;
  thrum_touch_measure(touch, &usual.model, &before);
  assert_true(before.worst < share);

  // no more are made than it takes
  int64_t found = 0, fewer = 0;
  double *fields = need((size_t)(40 * 3 * b.mesh.vertex_count), sizeof *fields);
  assert_int_equal(thrum_touch_shapes(touch, &usual.model, share, 40, fields, &found, NULL),
                   THRUM_OK);
  assert_true(found > 1 && found < 40);

  // the model with them follows as was asked, and so by more than with one fewer
  thrum_precomputed with = make_model(&b, 4, 6, fields, found);
  thrum_touch_measure(touch, &with.model, &after);
  assert_true(with.model.rank == 6 + found && with.basis_orthonormality < 1e-12);
  assert_true(after.worst >= share && after.mean > before.mean);
  thrum_precomputed less = make_model(&b, 4, 6, fields, found - 1);
  thrum_touch_measure(touch, &less.model, &after);
  assert_true(after.worst < share);
  thrum_precomputed_free(&less);

  // as many as there is room for, where that is fewer; none where nothing lacks
  assert_int_equal(thrum_touch_shapes(touch, &usual.model, share, 1, fields, &fewer, NULL),
                   THRUM_OK);
  assert_int_equal(fewer, 1);
  assert_int_equal(thrum_touch_shapes(touch, &with.model, share, 40, fields, &fewer, NULL),
                   THRUM_OK);
  assert_int_equal(fewer, 0);

  free(fields);
  thrum_touch_free(touch);
  thrum_precomputed_free(&with);
  thrum_precomputed_free(&usual);
  body_free(&b);
}

static void touch_modes_let_every_place_of_a_held_body_follow(void **state) {
  (void)state;
  check_modes("x<0.001", 0.8);
}

static void touch_modes_let_every_place_of_a_free_body_follow(void **state) {
  (void)state;
  check_modes(NULL, 0.6);
}

/* Adds touch modes that follow to the usual model, steps the model with them, and compares what it
 * shows of a static pull. */
static void check_followers(const char *fix, double share) {
  body b = body_make("beam:8x2x2@1x0.2x0.2", fix);
  thrum_precomputed usual = make_model(&b, 4, 6, NULL, 0);
  thrum_touch *touch = make_touch(&usual.model);
  int64_t found = 0;
  double *fields = need((size_t)(40 * 3 * b.mesh.vertex_count), sizeof *fields);
  assert_int_equal(thrum_touch_shapes(touch, &usual.model, share, 40, fields, &found, NULL),
                   THRUM_OK);
  thrum_touch_followers followers = {0};
  assert_int_equal(thrum_touch_follow(touch, &usual.model, fields, found, &followers, NULL),
                   THRUM_OK);

  // they follow as touch modes that are stepped do, place for place
  thrum_precomputed with = make_model(&b, 4, 6, fields, found);
  thrum_touch_coverage stepped, coverage;
  thrum_touch_measure(touch, &with.model, &stepped);
  thrum_touch_measure(touch, &followers.model, &coverage);
  assert_true(followers.model.rank == with.model.rank && coverage.worst >= share);
  assert_true(fabs(coverage.worst - stepped.worst) < 1e-9);
  assert_true(fabs(coverage.mean - stepped.mean) < 1e-9);

  // what is stepped of it is the usual model, bit for bit
  const thrum_model *steps = NULL;
  size_t size = 0;
  assert_int_equal(thrum_model_condense_size(&followers.model, 6, &size, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_int_equal(thrum_model_condense(memory, size, &followers.model, 6, &steps, NULL), THRUM_OK);
  assert_memory_equal(steps->omega2, usual.model.omega2, 6 * sizeof(double));
  assert_memory_equal(steps->c3, usual.model.c3, (size_t)usual.model.c3_count * sizeof(double));
  assert_memory_equal(steps->c4, usual.model.c4, (size_t)usual.model.c4_count * sizeof(double));

  // a static pull moves the model with followers as the uncondensed one, by U W^-1 U^T f of each
  const int64_t rank = with.model.rank, place = 3 * coverage.vertex;
  for (int axis = 0; axis < 3; axis++) {
    double load[THRUM_RANK_MAX], x[6], q[THRUM_RANK_MAX], moves = 0, same = 0;
    for (int64_t i = 0; i < rank; i++)
      load[i] = followers.model.basis[(place + axis) * rank + i];
    for (int64_t i = 0; i < 6; i++)
      x[i] = load[i] / steps->omega2[i];
    thrum_condensed_shape(steps, x, load, q);
    for (int64_t i = 0; i < rank; i++) {
      const double u = with.model.basis[(place + axis) * rank + i];
      moves += followers.model.basis[(place + axis) * rank + i] * q[i];
      same += u * u / with.model.omega2[i];
    }
    assert_true(fabs(moves - same) < 1e-9 * same);
  }

  free(memory);
  thrum_touch_followers_free(&followers);
  free(fields);
  thrum_touch_free(touch);
  thrum_precomputed_free(&with);
  thrum_precomputed_free(&usual);
  body_free(&b);
}

static void touch_modes_that_follow_a_held_body_give_its_static_answer(void **state) {
  (void)state;
  check_followers("x<0.001", 0.8);
}

static void touch_modes_that_follow_a_free_body_give_its_static_answer(void **state) {
  (void)state;
  check_followers(NULL, 0.6);
}

static void a_body_that_is_held_all_over_has_no_place(void **state) {
  (void)state;
  body b = body_make("beam:2x2x2@1x1x1", "x<0.001");
  thrum_precomputed made = make_model(&b, 2, 2, NULL, 0);

  // all vertices of the surface are held, which leaves the one in the middle free
  thrum_model model = made.model;
  uint8_t *fixed = need((size_t)model.vertex_count, 1);
  for (int64_t v = 0; v < model.vertex_count; v++) {
    const double *x = model.vertices + 3 * v;
    const bool inside = fabs(x[0] - 0.5) + fabs(x[1]) + fabs(x[2]) < 1e-9;
    fixed[v] = inside ? 0 : 7;
  }
  model.fixed = fixed;
  thrum_touch *touch = NULL;
  thrum_error error = {0};
  assert_int_equal(thrum_touch_create(&model, &touch, &error), THRUM_MISSING);
  assert_non_null(strstr(error.message, "no place to pull at"));
  assert_null(touch);

  free(fixed);
  thrum_precomputed_free(&made);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_basis_of_all_coordinates_follows_every_pull),
      cmocka_unit_test(the_worst_place_is_followed_as_the_share_of_its_loads_says),
      cmocka_unit_test(the_worst_direction_is_the_least_of_many_at_its_place),
      cmocka_unit_test(touch_modes_let_every_place_of_a_held_body_follow),
      cmocka_unit_test(touch_modes_let_every_place_of_a_free_body_follow),
      cmocka_unit_test(touch_modes_that_follow_a_held_body_give_its_static_answer),
      cmocka_unit_test(touch_modes_that_follow_a_free_body_give_its_static_answer),
      cmocka_unit_test(a_body_that_is_held_all_over_has_no_place),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
