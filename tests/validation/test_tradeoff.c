/* Tests of the trade-off of speed and accuracy: samples between steps, errors that fall as theory
 * says and obey the triangle inequality, the choice of a setting, and the command.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/precompute_support.h"
#include "tests/support/sanitized.h"
#include "tests/support/test_folder.h"
#include "validation/tradeoff/tradeoff.h"

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x2x2@1x0.15x0.15,split=6", "--order", "1", "-o",
                "beam.npz", "--fix", "x<0.001", "--modes", "5", "--rank", "10", "-q", NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

/* --- samples --------------------------------------------------------------------------- */

static double cubic(double t, double *slope) {
  *slope = 2 - 6 * t + 1.5 * t * t;
  return 1 + 2 * t - 3 * t * t + 0.5 * t * t * t;
}

static void check_cubic(void *context, int64_t index, double share, const double *value) {
  double slope, *last = context;
  const double time = 3.0 * (double)(index + 1) / FULL_MOTION_SAMPLES, exact = cubic(time, &slope);
  assert_true(share > 0 && share <= 1 + 1e-9);
  assert_true(fabs(value[0] - exact) < 1e-13 * 10);
  assert_true(fabs(value[1] - slope) < 1e-12 * 10);
  // every sample comes once, in order
  assert_true((double)index == *last + 1);
  *last = (double)index;
}

static void samples_between_steps_are_exact_for_cubics(void **state) {
  (void)state;
  static const double steps[] = {3.0 / 64, 0.017, 0.4, 3};
  for (int n = 0; n < 4; n++) {
    double last = -1, work[2];
    for (double t = 0; t < 3 - 1e-9; t += steps[n]) {
      double from[2], to[2];
      from[0] = cubic(t, &from[1]);
      to[0] = cubic(t + steps[n], &to[1]);
      full_motion_between(3, FULL_MOTION_SAMPLES, t, steps[n], 1, from, to, check_cubic, &last,
                          work);
    }
    assert_true(last == FULL_MOTION_SAMPLES - 1);
  }
}

/* --- the trade-off of a small beam ----------------------------------------------------- */

typedef struct trade {
  body body;
  thrum_precomputed made;
  double *forces;
  thrum_load course;
  tradeoff_problem problem;
  tradeoff_result result;
} trade;

/* Loads the end of a beam for 0.05 s, strongly enough for a nonlinear response. */
static void trade_make(trade *t, const char *mesh, int64_t modes, int64_t rank, double newtons) {
  memset(t, 0, sizeof *t);

  // the reduced model of a beam that is held at its left end
  t->body = body_make(mesh, "x<0.001");
  t->made = body_precompute(&t->body, modes, rank);
  const thrum_model *model = &t->made.model;

  // the force is shared among the vertices of the right end
  const int32_t *vertices;
  int64_t count;
  assert_int_equal(thrum_model_group(model, "right", &vertices, &count, NULL), THRUM_OK);
  t->forces = need((size_t)(3 * model->vertex_count), sizeof *t->forces);
  for (int64_t n = 0; n < count; n++)
    t->forces[3 * vertices[n] + 2] = newtons / (double)count;

  // three time steps of each integrator against a full-order run
  t->course = (thrum_load){.shape = THRUM_LOAD_CONSTANT, .until = 0.05};
  t->problem = (tradeoff_problem){
      .model = model,
      .script = {.load_count = 1, .courses = &t->course, .forces = t->forces, .time = 0.2},
      .full_dt = 0.001,
      .recipe_count = 1,
      .error = NAN,
      .cost = INFINITY,
      .dt_count = 3,
      .tolerance_count = 1,
      .dts = {0.0025, 0.005, 0.01},
      .tolerances = {1e-10},
      .integrators = {[EXPERIMENT_SCHEME_IMEXV] = true,
                      [EXPERIMENT_SCHEME_NEWMARK] = true,
                      [EXPERIMENT_SCHEME_ENERGY] = true},
      .threads = 2};
}

static void trade_solve(trade *t) {
  thrum_error error = {0};
  if (tradeoff_solve(&t->problem, &t->result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
}

static void trade_free(trade *t) {
  tradeoff_free(&t->result);
  thrum_precomputed_free(&t->made);
  free(t->forces);
  body_free(&t->body);
}

static void errors_fall_with_the_basis_and_with_the_time_step(void **state) {
  (void)state;
  static trade t;

  // bases of 4, 12 and 30 modes beside the model's own basis of 10
  trade_make(&t, "beam:6x2x2@1x0.15x0.15,split=6", 5, 10, 60);
  t.problem.recipe_count = 4;
  t.problem.full_dt = 0.00025;
  t.problem.mode_omega2 = t.made.mode_omega2;
  t.problem.mode_count = 5;
  const int64_t ranks[4] = {0, 4, 12, 30};
  for (int n = 0; n < 4; n++)
    t.problem.recipes[n] = (tradeoff_recipe){.modes = ranks[n] / 2, .rank = ranks[n]};
  trade_solve(&t);

  // the error of the basis falls with its rank
  const tradeoff_basis *bases = t.result.bases;
  assert_int_equal(bases[0].rank, 10);
  assert_true(bases[1].error.displacement > 1.5 * bases[0].error.displacement);
  assert_true(bases[2].error.displacement < bases[0].error.displacement * 1.05);
  assert_true(bases[3].error.displacement < 0.6 * bases[2].error.displacement);
  assert_int_equal(t.result.run_count, 4 * 3 * 3);

  // every run is stable and its cost is that of its step
  int fronts = 0;
  for (int64_t n = 0; n < t.result.run_count; n++) {
    const tradeoff_run *run = &t.result.runs[n];
    const double basis = bases[run->basis].error.displacement;
    assert_true(run->stable && run->us_per_step > 0);
    assert_true(fabs(run->cost - 1e-6 * run->us_per_step / run->dt) < 1e-12);
    // the triangle inequality, both ways: the error against the full order is at most the sum of
    // both parts and at least their difference; the norms differ by the size of the error of the
    // basis
    assert_true(run->error.displacement < 1.1 * (basis + run->time_error.displacement));
    assert_true(run->error.displacement > 0.9 * fabs(basis - run->time_error.displacement) - 1e-3);
    fronts += run->front;

    // energy has the frequency of more modes right the shorter the step, so that its errors fall
    // unevenly, below imexv's; those of the others are of second order
    if (run->integrator == EXPERIMENT_SCHEME_ENERGY) {
      assert_true(run[-3].integrator == EXPERIMENT_SCHEME_IMEXV && run[-3].dt == run->dt);
      assert_true(run->time_error.displacement < run[-3].time_error.displacement);
    } else if (n % 3 > 0) {
      const double ratio = run->time_error.displacement / run[-1].time_error.displacement;
      assert_true(ratio > 2.2 && ratio < 6);
    }
  }

  // some settings are on the front of cost and error, and some are not
  assert_true(fronts > 0 && fronts < t.result.run_count);
  assert_true(t.result.free_count == 6 * 9 * 3 && t.result.full_us_per_step > 0);

  // two linear tetrahedra over the thickness are far too stiff, as precompute says too
  double most = 0;
  for (int64_t i = 0; i < t.made.order_error_count; i++)
    most = fmax(most, t.made.order_error[i]);
  assert_true(most > 0.1 && fabs(t.result.mesh_error / most - 1) < 0.1);
  trade_free(&t);
}

static void a_basis_of_everything_leaves_the_error_in_time_alone(void **state) {
  (void)state;
  static trade t;
  // 4 vertices move: 12 components, all of them in the basis
  trade_make(&t, "beam:1x1x1@1x1x1", 8, 12, 20000);
  t.problem.dts[0] = 0.001;
  t.problem.dt_count = 1;
  t.problem.full_dt = 0.0005;
  trade_solve(&t);
  // the full order's own error in time, which is estimated without the full order
  assert_true(fabs(t.result.bases[0].error.displacement / t.result.full_error - 1) < 0.02);
  assert_true(t.result.full_error < 0.01);
  // a single cell locks
  assert_true(t.result.mesh_error > 0.1);
  trade_free(&t);
}

static void bases_that_the_mesh_does_not_have_are_dropped(void **state) {
  (void)state;
  static trade t;
  thrum_error error = {0};

  // a single cell, whose mesh has fewer components than the first basis asks for
  trade_make(&t, "beam:1x1x1@1x1x1", 3, 5, 1000);
  t.problem.dt_count = 1;
  t.problem.recipe_count = 2;
  t.problem.recipes[0] = (tradeoff_recipe){.modes = 10, .rank = 20}; // of 12 components
  trade_solve(&t);

  // that basis is dropped with a reason; the model's own is left
  assert_int_equal(t.result.dropped, 1);
  assert_non_null(strstr(t.result.dropped_reason.message, "12 free components"));
  assert_int_equal(t.result.basis_count, 1);
  assert_int_equal(t.result.bases[0].rank, 5);
  assert_int_equal(t.result.run_count, 3);

  // with no basis left the problem is refused, and the result is as it was
  t.problem.recipe_count = 1;
  tradeoff_result untouched = {.run_count = 77};
  assert_true(tradeoff_solve(&t.problem, &untouched, &error) < 0);
  assert_int_equal(untouched.run_count, 77);

  // a load that starts after the end of the run is refused
  t.problem.recipes[0] = (tradeoff_recipe){0};
  t.course.from = 5;
  t.course.until = 6;
  assert_int_equal(tradeoff_solve(&t.problem, &untouched, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "moves nothing"));
  trade_free(&t);
}

static void the_choice_is_the_cheapest_or_the_most_accurate(void **state) {
  (void)state;

  // settings by cost, and a cheap one that is unstable
  tradeoff_run runs[4] = {
      {.stable = true, .cost = 1, .error = {0.10, 0, 0}},
      {.stable = true, .cost = 2, .error = {0.02, 0, 0}},
      {.stable = true, .cost = 4, .error = {0.01, 0, 0}},
      {.stable = false, .cost = 0.1, .error = {NAN, NAN, NAN}},
  };
  const tradeoff_result result = {.run_count = 4, .runs = runs};

  // under a bound of the error the cheapest setting is chosen
  assert_int_equal(tradeoff_choose(&result, 0.05, NAN), 1);
  assert_int_equal(tradeoff_choose(&result, 0.1, NAN), 0);

  // under a bound of the cost the most accurate one is
  assert_int_equal(tradeoff_choose(&result, NAN, 3), 1);
  assert_int_equal(tradeoff_choose(&result, NAN, 100), 2);

  // under both bounds a setting may exist or not
  assert_int_equal(tradeoff_choose(&result, 0.05, 3), 1);
  assert_int_equal(tradeoff_choose(&result, 0.015, 3), -1);
  assert_int_equal(tradeoff_choose(&result, 0.001, NAN), -1);
  assert_int_equal(tradeoff_choose(&result, NAN, 0.5), -1);

  // one that owes its error to a basis that is worse comes last, one that cannot be believed never
  tradeoff_basis bases[2] = {{.error = {0.06, 0, 0}}, {.error = {0.03, 0, 0}}};
  tradeoff_run lucky[3] = {
      {.stable = true, .cost = 1, .error = {0.04, 0, 0}, .cancels = true},
      {.stable = true, .cost = 2, .error = {0.04, 0, 0}, .basis = 1},
      {.stable = true, .cost = 0.5, .error = {0.04, 0, 0}, .basis = 1, .disproved = true},
  };
  tradeoff_result two = {.run_count = 3, .runs = lucky, .bases = bases};
  assert_int_equal(tradeoff_choose(&two, 0.05, NAN), 1);
  two.run_count = 1;
  assert_int_equal(tradeoff_choose(&two, 0.05, NAN), 0);

  // each that is not taken says why
  assert_null(tradeoff_barred(&result, &runs[1], 0.05, NAN));
  assert_string_equal(tradeoff_barred(&result, &runs[0], 0.05, NAN), "error too large");
  assert_string_equal(tradeoff_barred(&result, &runs[2], 0.05, 3), "too dear");
  assert_string_equal(tradeoff_barred(&result, &runs[3], 0.05, NAN), "lost");
  assert_string_equal(tradeoff_barred(&two, &lucky[0], 0.05, NAN), "errors cancel");
  assert_null(tradeoff_barred(&two, &lucky[0], NAN, 3));
  assert_string_equal(tradeoff_barred(&two, &lucky[2], 0.05, NAN), "condensed too far");
  runs[1].fallback_steps = 1;
  assert_string_equal(tradeoff_barred(&result, &runs[1], 0.05, NAN), "fell_back");
}

/* --- the search ------------------------------------------------------------------------ */

static void the_search_ends_at_the_first_basis_that_does_it(void **state) {
  (void)state;
  static trade t;

  // three modes are off by more than the error wanted
  trade_make(&t, "beam:6x2x2@1x0.15x0.15", 3, 4, 250);
  t.problem.dts[0] = 0.0025;
  t.problem.dt_count = 1;
  t.problem.error = 0.02;
  t.problem.cost = NAN;
  t.problem.modes = 3;
  trade_solve(&t);
  assert_int_equal(t.result.chosen, -1);
  assert_int_equal(t.result.basis_count, 1);
  assert_true(t.result.bases[0].error.displacement > 0.03);
  tradeoff_free(&t.result);

  // with a limit, the first trained basis does it, and no other is made
  t.problem.rank_max = 60;
  t.problem.test_count = 1;
  t.problem.tests = &t.problem.script;
  trade_solve(&t);
  assert_true(t.result.chosen >= 0);
  assert_int_equal(t.result.basis_count, 2);
  assert_int_equal(t.result.searched, 1);
  const tradeoff_run *run = &t.result.runs[t.result.chosen];
  const tradeoff_basis *basis = &t.result.bases[run->basis];
  assert_true(basis->recipe.trained && run->error.displacement <= 0.02);

  // nothing in a basis is nearer than the projection; a test of the same load has the same error
  assert_true(basis->projection <= basis->error.displacement);
  assert_true(basis->projection <= run->error.displacement);
  assert_true(t.result.test_error[0] == run->error.displacement);
  assert_true(t.result.test_own_error[0] > t.result.test_error[0]);
  trade_free(&t);
}

static void points_are_tried_from_the_rank_on_where_they_may_be_cheaper(void **state) {
  (void)state;
  tradeoff_problem problem = {.cubature_count = 2, .cubature_errors = {0.02, 0.005}};
  tradeoff_recipe recipes[TRADEOFF_POINTS_MAX];

  // four points a coordinate cost less than the coefficients from rank 29 on
  for (int64_t rank = 2; rank <= THRUM_RANK_MAX; rank++) {
    const tradeoff_recipe basis = {.modes = 5, .rank = rank, .trained = true};
    const double points = 12.0 * 4 * (double)(rank * rank);
    const bool pays = points < (double)(thrum_c3_count(rank) + thrum_c4_count(rank));
    assert_int_equal(pays, rank >= 29);
    problem.points_alone = false;
    assert_int_equal(tradeoff_points(&problem, &basis, recipes), pays ? 2 : 0);

    // where no polynomial is, of every rank
    problem.points_alone = true;
    assert_int_equal(tradeoff_points(&problem, &basis, recipes), 2);
    assert_true(recipes[1].cubature_error == 0.005 && recipes[1].rank == rank &&
                recipes[1].trained);
  }

  // two points a coordinate, which are enough where gradients are learned, from rank 20 on
  problem.points_alone = false;
  problem.cubature_refine = 1000;
  for (int64_t rank = 2; rank <= THRUM_RANK_MAX; rank++) {
    const tradeoff_recipe basis = {.modes = 5, .rank = rank, .trained = true};
    assert_int_equal(tradeoff_points(&problem, &basis, recipes), rank >= 20 ? 2 : 0);
  }
}

/* Bases whose error falls with the rank, and rises with that of their points; dear polynomials. */
typedef struct made_up {
  double weight; /* of the error of points */
  int64_t most;  /* rank that loads and modes have shapes for; 0: any */
  double luck; /* share of the error that runs of points are left with by a cancellation; 0: all */
  char asked[512];
} made_up;

static thrum_status take_made_up(void *context, const tradeoff_recipe *recipe,
                                 tradeoff_result *part, thrum_error *error) {
  (void)error;
  made_up *m = context;
  const size_t used = strlen(m->asked);
  snprintf(m->asked + used, sizeof m->asked - used, " %d:%g", (int)recipe->rank,
           recipe->cubature_error);

  // 1.2 over the rank: 2 % from rank 60 on
  const bool points = recipe->cubature_error > 0;
  const double rank = recipe->rank > 0 ? (double)recipe->rank : 4;
  const double off = 1.2 / rank + m->weight * recipe->cubature_error;
  *part = (tradeoff_result){.basis_count = 1, .run_count = 1};
  part->bases = need(1, sizeof *part->bases);
  part->runs = need(1, sizeof *part->runs);
  part->bases[0] = (tradeoff_basis){.recipe = *recipe, .rank = (int64_t)rank, .points = points};
  if (m->most > 0 && part->bases[0].rank > m->most)
    part->bases[0].rank = m->most;
  part->bases[0].error.displacement = off;
  part->runs[0] = (tradeoff_run){.integrator = EXPERIMENT_SCHEME_ENERGY,
                                 .stable = true,
                                 .cost = points ? rank : 1e-3 * pow(rank, 4),
                                 .error = {off, off, off}};
  if (points && m->luck > 0) {
    part->runs[0].cancels = true;
    part->runs[0].error.displacement = m->luck * off;
  }
  return THRUM_OK;
}

static void points_are_tried_before_polynomials_that_are_far_dearer(void **state) {
  (void)state;
  static trade t;
  static const struct {
    double error, weight;
    const char *asked;
    bool points;
  } cases[] = {
      // the own basis is taken for itself, and for its condensed forms; below rank 60 the
      // polynomial
      // leads, and points follow where it is near enough
      {0.042, 0.1, " 0:0 0:0 20:0 30:0 30:0.01", true},
      {0.042, 0.5, " 0:0 0:0 20:0 30:0 30:0.01 30:0.003", true},
      {0.042, 5, " 0:0 0:0 20:0 30:0 30:0.01 30:0.003", false},

      // from there on points lead, and the polynomial follows where they do not do it
      {0.022, 0.1, " 0:0 0:0 20:0 30:0 45:0 60:0.01", true},
      {0.022, 0.5, " 0:0 0:0 20:0 30:0 45:0 60:0.01 60:0.003", true},
      {0.022, 2, " 0:0 0:0 20:0 30:0 45:0 60:0.01 60:0.003 60:0 80:0.01 80:0.003", true},
      {0.022, 5, " 0:0 0:0 20:0 30:0 45:0 60:0.01 60:0.003 60:0 80:0.01 80:0.003", false},
  };
  trade_make(&t, "beam:6x2x2@1x0.15x0.15", 3, 4, 60);
  t.problem.take = take_made_up;
  t.problem.modes = 3;
  t.problem.rank_max = 200;
  t.problem.cost = NAN;
  t.problem.cubature_count = 2;
  t.problem.cubature_errors[0] = 0.01;
  t.problem.cubature_errors[1] = 0.003;
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    made_up context = {.weight = cases[n].weight};
    t.problem.error = cases[n].error;
    t.problem.take_context = &context;
    trade_solve(&t);
    if (strcmp(context.asked, cases[n].asked) != 0)
      fail_msg("%d: %s", (int)n, context.asked);
    const tradeoff_run *run = &t.result.runs[t.result.chosen];
    assert_int_equal(t.result.bases[run->basis].points > 0, cases[n].points);
    assert_true(run->error.displacement <= cases[n].error);
    tradeoff_free(&t.result);
  }

  // runs of points that owe it to a cancellation do not end it: the polynomial does
  made_up lucky = {.weight = 5, .luck = 0.1};
  t.problem.error = 0.022;
  t.problem.take_context = &lucky;
  trade_solve(&t);
  assert_string_equal(lucky.asked, cases[6].asked);
  assert_int_equal(t.result.bases[t.result.runs[t.result.chosen].basis].points, 0);
  tradeoff_free(&t.result);

  // beyond rank 100 there are points alone, and without them nothing
  made_up context = {.weight = 0.1};
  t.problem.error = 0.009;
  t.problem.take_context = &context;
  trade_solve(&t);
  assert_non_null(strstr(context.asked, " 100:0 140:0.01"));
  assert_int_equal(t.result.bases[t.result.runs[t.result.chosen].basis].rank, 140);
  tradeoff_free(&t.result);
  context.asked[0] = 0;
  t.problem.cubature_count = 0;
  trade_solve(&t);
  assert_int_equal(t.result.chosen, -1);
  assert_string_equal(context.asked, " 0:0 0:0 20:0 30:0 45:0 60:0 80:0 100:0");
  tradeoff_free(&t.result);

  // where a higher rank gives no larger basis, the search ends
  context.asked[0] = 0;
  context.most = 40;
  trade_solve(&t);
  assert_string_equal(context.asked, " 0:0 0:0 20:0 30:0 45:0 60:0");
  trade_free(&t);
}

static void points_err_by_little_more_than_the_polynomial_of_their_basis(void **state) {
  (void)state;
  static trade t;
  trade_make(&t, "beam:6x2x2@1x0.15x0.15", 5, 10, 60);
  t.problem.dt_count = 1;
  t.problem.condense = true;
  t.problem.recipe_count = 3;
  t.problem.recipes[1] = (tradeoff_recipe){.modes = 5, .rank = 10, .cubature_error = 0.05};
  t.problem.recipes[2] = (tradeoff_recipe){.modes = 5, .rank = 10, .cubature_error = 0.001};
  trade_solve(&t);

  // the same basis, which is not condensed with points; their errors of motion are at most about
  // twice those of the force
  const tradeoff_basis *exact = &t.result.bases[0], *few = exact + 1, *many = exact + 2;
  assert_int_equal(exact->points, 0);
  assert_true(few->points > 0 && many->points > few->points);
  assert_true(few->force_error <= 0.05 && many->force_error <= 0.001);
  assert_true(few->projection == exact->projection && many->projection == exact->projection);
  const double off_few = fabs(few->error.displacement - exact->error.displacement);
  const double off_many = fabs(many->error.displacement - exact->error.displacement);
  assert_true(off_many < off_few && off_few < 2 * 0.05 && off_many < 2 * 0.001);
  for (int64_t b = 3; b < t.result.basis_count; b++)
    assert_int_equal(t.result.bases[b].points, 0);

  // they are trained as far as the load moves the body: here by more than a hundredth of it
  assert_true(few->cubature_range == many->cubature_range);
  assert_true(few->cubature_range > 0.01 && few->cubature_range < 1);
  trade_free(&t);
}

static void condensed_bases_are_tried_with_their_linear_modes(void **state) {
  (void)state;
  static trade t;
  trade_make(&t, "beam:6x2x2@1x0.15x0.15", 5, 10, 40);
  t.problem.dt_count = 1;
  t.problem.condense = true;
  t.problem.mode_omega2 = t.made.mode_omega2;
  t.problem.mode_count = 5;
  trade_solve(&t);

  // each steps fewer coordinates, and errs by little more than all of them
  assert_true(t.result.basis_count > 1);
  for (int64_t b = 1; b < t.result.basis_count; b++) {
    const tradeoff_basis *basis = &t.result.bases[b];
    assert_true(basis->recipe.masters >= 3 && basis->recipe.masters <= 5);
    assert_int_equal(basis->rank, 10);
    assert_true(basis->projection == t.result.bases[0].projection);
    assert_true(basis->error.displacement < 0.1);
  }
  trade_free(&t);
}

/* --- the command ----------------------------------------------------------------------- */

static void the_command_recommends_what_simulate_takes(void **state) {
  (void)state;

  // the run finds a setting within the bound of the error
  program_result run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "trade", "--load",
                                 "square:0,0,-20@tip,until=0.05", "--quick", "--time", "0.2",
                                 "--error", "50%", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);

  // of the settings within this bound that are not flagged, which come last whatever they cost,
  // none is cheaper than the recommended one
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  const cJSON *recommended = cJSON_GetObjectItem(object, "recommended");
  assert_true(cJSON_GetArraySize(runs) > 2 * 3 * 3);
  const double cost = json_value(recommended, "cost_s_per_s");
  assert_true(json_value(recommended, "error") <= 0.5);
  assert_true(cJSON_IsNull(cJSON_GetObjectItem(recommended, "flag")));
  const cJSON *other;
  cJSON_ArrayForEach(other, runs) {
    if (json_value(other, "error") <= 0.5 && cJSON_IsNull(cJSON_GetObjectItem(other, "flag")) &&
        !cJSON_IsTrue(cJSON_GetObjectItem(other, "disproved")))
      assert_true(json_value(other, "cost_s_per_s") >= cost);
  }

  // the frequencies of what the load moves come out worse at longer steps, and that is said; energy
  // has those of slow modes right
  double before = 0;
  cJSON_ArrayForEach(other, runs) {
    const double off = json_value(other, "frequency_error");
    assert_true(off >= 0 && off <= 1 && json_value(other, "frequency_mode") >= 1);
    if (json_value(other, "dt") > 0.003)
      assert_true(off > before || off == 0);
    before = off;
  }
  const bool warned = strstr(run.err, "is stepped at") != NULL;
  assert_int_equal(warned, json_value(recommended, "frequency_error") > 0.5);

  // simulate takes the recommended setting from the options file
  const double dt = json_value(recommended, "dt");
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "beam.npz", "-o", "run", "--options", "trade/simulate.json",
                  "--time", "0.1", "--load", "square:0,0,-20@tip", "--json", "-q", NULL);
  cJSON *simulated = json_line(run.out);
  assert_non_null(simulated);
  assert_true(json_value(simulated, "dt") == dt);
  cJSON_Delete(simulated);
  cJSON_Delete(object);
  program_result_free(&run);

  // the report page and the table are written
  char path[128];
  snprintf(path, sizeof path, "%s/trade/tradeoff.html", folder);
  char *page = text_file_read(path);
  assert_non_null(page);
  assert_true(strstr(page, "Recommended for an error of 50 %") && strstr(page, "</body></html>") &&
              !strstr(page, ">nan"));
  free(page);
  snprintf(path, sizeof path, "%s/trade/tradeoff.csv", folder);
  assert_true(file_exists(path));
}

static void the_printed_commands_make_what_was_recommended(void **state) {
  (void)state;

  // as a checkout's ./run does, the caller says how the program is called
  setenv("THRUM_COMMAND", "'" THRUM_PROGRAM "'", 1);

  // loads that act together, on a body whose own basis is off by more
  program_result run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "again", "--load",
                                 "square:0,0,-90@tip", "--load", "sine:0,60,0@tip,f=2", "--test",
                                 "square:0,0,-40@tip", "--quick", "--time", "0.3", "--error",
                                 "0.3%", "--ranks", "0", "--rank-max", "30", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *recommended = cJSON_GetObjectItem(object, "recommended");
  assert_true(cJSON_IsTrue(cJSON_GetObjectItem(recommended, "trained")));
  assert_non_null(strstr(
      cJSON_GetObjectItem(cJSON_GetObjectItem(object, "commands"), "precompute")->valuestring,
      "--train 'square:0,0,-90@tip;sine:0,60,0@tip,f=2'"));
  unsetenv("THRUM_COMMAND");
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "tests")), 1);
  program_result_free(&run);

  // the model and its run, as a shell takes the commands
  char shell[] = "/bin/sh", option[] = "-e", script[] = "again/commands.sh";
  char *const words[] = {shell, option, script, NULL};
  run = program_execute(folder, words);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  assert_true(file_exists(in_folder("again/model.npz")));
  assert_true(file_exists(in_folder("again/run/run.json")));
  program_result_free(&run);

  // the error of that model is the same, but for the residual of the full order's steps
  char dt[40], tolerance[40];
  snprintf(dt, sizeof dt, "%.17g", json_value(recommended, "dt"));
  snprintf(tolerance, sizeof tolerance, "%.17g", json_value(recommended, "tolerance"));
  run =
      thrum_run(folder, "tradeoff", "again/model.npz", "-o", "same", "--load", "square:0,0,-90@tip",
                "--load", "sine:0,60,0@tip,f=2", "--quick", "--time", "0.3", "--error", "1%",
                "--ranks", "0", "--dts", dt, "--tolerances", tolerance, "--json", "-q", NULL);
  cJSON *same = json_line(run.out);
  bool found = false;
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, cJSON_GetObjectItem(same, "runs")) {
    if (strcmp(cJSON_GetObjectItem(item, "integrator")->valuestring,
               cJSON_GetObjectItem(recommended, "integrator")->valuestring) != 0)
      continue;
    // the basis is the same, and so is the whole run
    const double projection = json_value(recommended, "projection_error"),
                 error = json_value(recommended, "error");
    assert_true(fabs(json_value(item, "projection_error") / projection - 1) < 1e-6);
    assert_true(fabs(json_value(item, "error") / error - 1) < 1e-6);
    found = true;
  }
  assert_true(found);
  cJSON_Delete(same);
  cJSON_Delete(object);
  program_result_free(&run);
}

/* The model of the pick as its commands make it, tried again as it is: the error of the same run.
 */
static double error_again(const cJSON *recommended, const char *folder_of_it) {
  char dt[40], tolerance[40], model[64];
  snprintf(dt, sizeof dt, "%.17g", json_value(recommended, "dt"));
  snprintf(tolerance, sizeof tolerance, "%.17g", json_value(recommended, "tolerance"));
  snprintf(model, sizeof model, "%s/model.npz", folder_of_it);

  // the search is left with this model, this step and this integrator
  program_result run =
      thrum_run(folder, "tradeoff", model, "-o", "same", "--load", "square:0,0,-90@tip", "--quick",
                "--time", "0.3", "--error", "100%", "--ranks", "0", "--dts", dt, "--tolerances",
                tolerance, "--integrators",
                cJSON_GetObjectItem(recommended, "integrator")->valuestring, "--json", "-q", NULL);

  cJSON *same = json_line(run.out);
  const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItem(same, "runs"), 0);
  assert_true(json_value(cJSON_GetObjectItem(item, "cubature"), "points") ==
              json_value(cJSON_GetObjectItem(recommended, "cubature"), "points"));
  const double error = json_value(item, "error");
  cJSON_Delete(same);
  program_result_free(&run);
  return error;
}

/* Judged by the worse of both errors a pick has both within the bound; and what it is worth under a
 * load of another kind is told without being asked for. */
static void a_pick_is_judged_by_its_velocity_too(void **state) {
  (void)state;
  const cJSON *item;
  program_result run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "judged", "--load",
                                 "square:0,0,-20@tip,until=0.05", "--quick", "--time", "0.2",
                                 "--judge-by", "worse", "--error", "30%", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  const cJSON *recommended = cJSON_GetObjectItem(object, "recommended");
  const cJSON *errors = cJSON_GetObjectItem(recommended, "errors");
  assert_true(json_value(errors, "displacement") <= 0.3 && json_value(errors, "velocity") <= 0.3);

  // the cheapest by displacement alone was passed over
  int passed_over = 0;
  cJSON_ArrayForEach(item, cJSON_GetObjectItem(object, "runs")) {
    passed_over += json_value(item, "error") <= 0.3 &&
                   json_value(cJSON_GetObjectItem(item, "errors"), "velocity") > 0.3;
  }
  assert_true(passed_over > 0);
  item = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "tests"), 0);
  assert_non_null(strstr(cJSON_GetObjectItem(item, "load")->valuestring, "gravity:"));
  assert_true(json_value(item, "error") > 0 && json_value(item, "velocity_error") > 0);
  cJSON_Delete(object);
  program_result_free(&run);
}

static void the_printed_commands_make_models_of_points_of_every_law(void **state) {
  (void)state;
  static const char *const cases[][6] = {
      {"--cubature", "only", "--rank-max", "30", "--cubature-refine", "2000"},
      {"--law", "neo-hookean", "--rank-max", "30", "--cubature-refine", "2000"},
      {"--law", "corotational", "--rank-max", "0"}};

  // under the sanitizers one law stands for the others, whose points they see elsewhere
  for (int n = LENGTH_OF_RUN(0, 1); n < LENGTH_OF_RUN(3, 2); n++) {
    // bases of a polynomial are tried with none of these, as no polynomial holds another law
    setenv("THRUM_COMMAND", "'" THRUM_PROGRAM "'", 1);
    program_result run = thrum_run(
        folder, "tradeoff", "beam.npz", "-o", "points", "--load", "square:0,0,-90@tip", "--quick",
        "--time", "0.3", "--error", n < 2 ? "0.5%" : "20%", "--ranks", "0,6", "--json", "-q",
        cases[n][0], cases[n][1], cases[n][2], cases[n][3], cases[n][4], cases[n][5], NULL);
    unsetenv("THRUM_COMMAND");
    if (run.exit_code != 0)
      fail_msg("%s", run.err);
    cJSON *object = json_line(run.out);
    const cJSON *recommended = cJSON_GetObjectItem(object, "recommended"), *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItem(object, "runs")) {
      const cJSON *cubature = cJSON_GetObjectItem(item, "cubature");
      assert_true(json_value(cubature, "points") > 0);
      assert_true(json_value(cubature, "refine") == (n < 2 ? 2000 : 0));
    }
    assert_string_equal(
        cJSON_GetObjectItem(cJSON_GetObjectItem(object, "full"), "law")->valuestring,
        n == 0 ? "stvk" : cases[n][1]);
    if (n < 2)
      assert_true(cJSON_IsTrue(cJSON_GetObjectItem(recommended, "trained")));
    program_result_free(&run);

    // the page says what they are
    char *page = text_file_read(in_folder("points/tradeoff.html"));
    assert_non_null(page);
    assert_true(strstr(page, " points</td>") && strstr(page, "cubature points"));
    assert_true(n == 0 || strstr(page, cases[n][1]));
    free(page);

    // as a shell takes the commands; the error of that model is the same
    char shell[] = "/bin/sh", option[] = "-e", script[] = "points/commands.sh";
    char *const words[] = {shell, option, script, NULL};
    run = program_execute(folder, words);
    if (run.exit_code != 0)
      fail_msg("%s", run.err);
    program_result_free(&run);
    const double error = json_value(recommended, "error");
    const double again = error_again(recommended, "points");
    print_message("case %d: error %.4g, again %.4g\n", n, error, again);

    // thousands of steps of learning make rounding of the training grow
    assert_true(fabs(again / error - 1) < (n < 2 ? 0.1 : 1e-6));
    cJSON_Delete(object);
  }
}

/* Points that miss the error of their force end precompute with 3. Their motion was judged by the
 * search, so that the commands go on; after any other failure they do not. */
static void the_printed_commands_go_on_with_points_that_miss_their_error(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("ends.sh"),
                              "'" THRUM_PROGRAM "' \"$@\" || exit 1\n"
                              "[ \"$1\" != precompute ] || exit \"$(cat code)\"\n"));
  setenv("THRUM_COMMAND", "sh ends.sh", 1);
  program_result run =
      thrum_run(folder, "tradeoff", "beam.npz", "-o", "missed", "--load", "square:0,0,-90@tip",
                "--quick", "--time", "0.1", "--error", "100%", "--ranks", "0", "--rank-max", "0",
                "--cubature", "only", "--integrators", "energy", "--dts", "0.01", "-q", NULL);
  unsetenv("THRUM_COMMAND");
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);

  // a model that was made but flagged, then one that was not made
  char shell[] = "/bin/sh", option[] = "-e", script[] = "missed/commands.sh";
  char *const words[] = {shell, option, script, NULL};
  static const int codes[] = {3, 1};
  for (int n = 0; n < 2; n++) {
    assert_true(text_file_write(in_folder("code"), codes[n] == 3 ? "3" : "1"));
    run = program_execute(folder, words);
    if (run.exit_code != (codes[n] == 3 ? 0 : 1))
      fail_msg("%d: %s", run.exit_code, run.err);
    assert_int_equal(file_exists(in_folder("missed/run/run.json")), codes[n] == 3);
    program_result_free(&run);
    remove(in_folder("missed/run/run.json"));
  }
}

static void what_polynomials_cannot_hold_is_not_asked_of_them(void **state) {
  (void)state;
  static const struct {
    int code;
    const char *says, *arguments[4];
  } cases[] = {
      {2, "--law neo-hookean needs cubature points", {"--law", "neo-hookean", "--cubature", "off"}},
      {2, "--law wants stvk", {"--law", "rubber"}},
      {2, "--cubature wants auto, off or only", {"--cubature", "on"}},
      {2,
       "--cubature-errors is of cubature points",
       {"--cubature", "off", "--cubature-errors=0.1"}},
      {2, "--cubature-refine is of cubature points", {"--cubature", "off", "--cubature-refine=9"}},
      {2, "--cubature-errors wants", {"--cubature-errors", "0"}},
      {2, "--cubature-errors", {"--cubature-errors", "1e-2,2e-2,3e-2,4e-2,5e-2"}},
  };

  // each is refused in one line that names the option
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    const char *const *a = cases[n].arguments;
    program_result run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "none", "--load",
                                   "square:0,0,-9@tip", a[0], a[1], a[2], a[3], NULL);
    assert_int_equal(run.exit_code, cases[n].code);
    if (!strstr(run.err, cases[n].says))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void single_precision_is_tried_beside_double(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "precise", "--load",
                                 "square:0,0,-20@tip", "--quick", "--time", "0.1", "--ranks",
                                 "0,10", "--precisions", "double,single", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);

  cJSON *object = json_line(run.out);
  const cJSON *runs = cJSON_GetObjectItem(object, "runs");
  // the model's own basis counts once, the other one in both precisions
  assert_int_equal(cJSON_GetArraySize(runs), 3 * 3 * 3);

  for (int n = 9; n < 18; n++) {
    const cJSON *fine = cJSON_GetArrayItem(runs, n), *coarse = cJSON_GetArrayItem(runs, n + 9);
    assert_string_equal(cJSON_GetObjectItem(fine, "precision")->valuestring, "double");
    assert_string_equal(cJSON_GetObjectItem(coarse, "precision")->valuestring, "single");
    const double error = json_value(fine, "error"), other = json_value(coarse, "error");
    // rounded coefficients are different, but close
    assert_true(error != other && fabs(error - other) < 1e-4 * error);
  }
  cJSON_Delete(object);
  program_result_free(&run);
}

static void a_mesh_is_traded_as_its_model_is(void **state) {
  (void)state;
  // the cache lies within the folder of the test
  char cache[96], *kept = getenv("XDG_CACHE_HOME");
  char before[256];
  snprintf(before, sizeof before, "%.255s", kept ? kept : "");
  assert_true(folder[0] == '/');
  snprintf(cache, sizeof cache, "%s/cache", folder);
  assert_int_equal(setenv("XDG_CACHE_HOME", cache, 1), 0);

  // the same beam, once as a model made before and once as a mesh
  double errors[2];
  for (int mesh = 0; mesh < 2; mesh++) {
    program_result run =
        mesh ? thrum_run(folder, "tradeoff", "beam:6x2x2@1x0.15x0.15", "--fix", "x<0.001",
                         "--young", "3e6", "-o", "m", "--load", "square:0,0,-20@tip", "--quick",
                         "--time", "0.1", "--ranks", "10", "--error", "90%", "--json", "-q", NULL)
             : thrum_run(folder, "precompute", "beam:6x2x2@1x0.15x0.15", "-o", "stiff.npz", "--fix",
                         "x<0.001", "--young", "3e6", "-q", NULL);
    assert_int_equal(run.exit_code, 0);
    if (!mesh) {
      program_result_free(&run);
      run = thrum_run(folder, "tradeoff", "stiff.npz", "-o", "m", "--load", "square:0,0,-20@tip",
                      "--quick", "--time", "0.1", "--ranks", "10", "--error", "90%", "--json", "-q",
                      NULL);
      assert_int_equal(run.exit_code, 0);
    }

    // the error of the first setting stands for the whole table
    cJSON *object = json_line(run.out);
    assert_non_null(object);
    errors[mesh] = json_value(cJSON_GetArrayItem(cJSON_GetObjectItem(object, "runs"), 0), "error");
    cJSON_Delete(object);
    program_result_free(&run);
  }

  // both give the same error; a mesh can be simulated at full order
  assert_true(errors[0] > 0 && errors[0] == errors[1]);
  program_result run =
      thrum_run(folder, "simulate", "beam:6x2x2@1x0.15x0.15", "--fix", "x<0.001", "--full", "-o",
                "whole", "--time", "0.01", "--load", "impulse:0,0,-2@tip", "--json", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // simulate takes a mesh only with --full, and a Poisson's ratio of 0.5 is refused
  run = thrum_run(folder, "simulate", "beam:6x2x2@1x0.15x0.15", "-o", "m2", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "--full"));
  program_result_free(&run);
  run =
      thrum_run(folder, "tradeoff", "beam:6x2x2@1x0.15x0.15", "-o", "m", "--poisson", "0.5", NULL);
  assert_int_equal(run.exit_code, 2);
  program_result_free(&run);

  // a model refuses the options that belong to a mesh
  run = thrum_run(folder, "tradeoff", "stiff.npz", "-o", "m", "--fix", "x<0.001", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "of a mesh"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "stiff.npz", "-o", "m2", "--young", "1e6", NULL);
  assert_int_equal(run.exit_code, 2);
  program_result_free(&run);

  // the environment is as it was before the test
  if (before[0] != 0)
    setenv("XDG_CACHE_HOME", before, 1);
  else
    unsetenv("XDG_CACHE_HOME");
}

static void an_error_out_of_reach_and_missing_loads_are_said(void **state) {
  (void)state;

  // an error that no setting reaches
  program_result run =
      thrum_run(folder, "tradeoff", "beam.npz", "-o", "none", "--load", "square:0,0,-20@tip",
                "--quick", "--time", "0.1", "--ranks", "0", "--error", "0.000001%", "-q", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out, "no setting that was tried"));
  program_result_free(&run);

  // a run without a load has no reference
  run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "none", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "--load"));
  program_result_free(&run);

  // wrong arguments are named in one line
  static const char *const wrong[][2] = {
      {"--error", "a lot"}, {"--error", "200%"},  {"--budget", "-3ms"},      {"--budget", "3"},
      {"--ranks", "2.5"},   {"--dts", "0.003,,"}, {"--integrators", "euler"}};
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    run = thrum_run(folder, "tradeoff", "beam.npz", "-o", "none", wrong[n][0], wrong[n][1], NULL);
    assert_int_equal(run.exit_code, 2);
    assert_non_null(strstr(run.err, wrong[n][0]));
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(samples_between_steps_are_exact_for_cubics),
      cmocka_unit_test(errors_fall_with_the_basis_and_with_the_time_step),
      cmocka_unit_test(a_basis_of_everything_leaves_the_error_in_time_alone),
      cmocka_unit_test(bases_that_the_mesh_does_not_have_are_dropped),
      cmocka_unit_test(the_choice_is_the_cheapest_or_the_most_accurate),
      cmocka_unit_test(the_search_ends_at_the_first_basis_that_does_it),
      cmocka_unit_test(points_are_tried_from_the_rank_on_where_they_may_be_cheaper),
      cmocka_unit_test(points_are_tried_before_polynomials_that_are_far_dearer),
      cmocka_unit_test(points_err_by_little_more_than_the_polynomial_of_their_basis),
      cmocka_unit_test(condensed_bases_are_tried_with_their_linear_modes),
      cmocka_unit_test(the_command_recommends_what_simulate_takes),
      cmocka_unit_test(the_printed_commands_make_what_was_recommended),
      cmocka_unit_test(a_pick_is_judged_by_its_velocity_too),
      cmocka_unit_test(the_printed_commands_make_models_of_points_of_every_law),
      cmocka_unit_test(the_printed_commands_go_on_with_points_that_miss_their_error),
      cmocka_unit_test(what_polynomials_cannot_hold_is_not_asked_of_them),
      cmocka_unit_test(single_precision_is_tried_beside_double),
      cmocka_unit_test(a_mesh_is_traded_as_its_model_is),
      cmocka_unit_test(an_error_out_of_reach_and_missing_loads_are_said),
  };

  // one model serves all tests
  return cmocka_run_group_tests(tests, make_model, remove_folder);
}
