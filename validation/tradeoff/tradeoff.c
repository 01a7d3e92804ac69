/* The reference, the bases asked for, their tight runs, all settings over the pool, and what is
 * chosen of them. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "platform/thread_pool.h"
#include "platform/threads.h"
#include "validation/tradeoff/tradeoff_private.h"

#define TIGHT_TOLERANCE 1e-12

static void mark_front(tradeoff_result *result) {
  for (int64_t n = 0; n < result->run_count; n++) {
    tradeoff_run *run = &result->runs[n];
    run->front = run->stable;
    for (int64_t m = 0; m < result->run_count && run->front; m++) {
      const tradeoff_run *other = &result->runs[m];
      run->front = !(other->stable && other->cost <= run->cost &&
                     other->error.displacement < run->error.displacement);
    }
  }
}

/* How far the full order itself is from exact in time: the basis of least error, stepped as the
 * full order is, against its tight run. */
static thrum_status judge_reference(tradeoff_solution *s, thrum_error *error) {
  int64_t best = -1;
  for (int64_t b = 0; b < s->result.basis_count; b++) {
    const tradeoff_basis *basis = &s->result.bases[b];
    if (basis->recipe.masters == 0 &&
        (best < 0 || basis->error.displacement < s->result.bases[best].error.displacement))
      best = b;
  }
  s->result.full_error = s->problem->take != NULL ? s->full_error : NAN;
  if (best < 0 || s->problem->take != NULL)
    return THRUM_OK;

  // its tight run has no error in time to speak of
  const tradeoff_space *space = &s->spaces[best];
  thrum_state_def def =
      tradeoff_def(s->problem, EXPERIMENT_SCHEME_ENERGY, s->problem->full_dt, TIGHT_TOLERANCE);
  def.frequency_matched = 0;
  tradeoff_samples samples = {0};
  tradeoff_pass pass = {0};
  thrum_status status = tradeoff_samples_make(space->shape->rank, &samples, error);
  THRUM_THEN(status, tradeoff_step(space, &space->view, &def, &samples, &pass, error));
  if (status >= 0 && pass.whole)
    s->result.full_error =
        tradeoff_against(space->shape->rank, &samples, &space->tight).displacement;
  free(samples.q);
  return status;
}

/* --- tests ------------------------------------------------------------------------------------ */

/* The errors of one setting under another script. */
static thrum_status test_error(const tradeoff_solution *s, int64_t b, const thrum_state_def *def,
                               const full_motion_script *script,
                               const tradeoff_reference *reference, double *found, double *velocity,
                               thrum_error *error) {
  const tradeoff_space *space = &s->spaces[b];
  const int64_t rank = space->shape->rank;
  tradeoff_view view = {0};
  tradeoff_samples samples = {0};
  tradeoff_pass pass = {0};
  thrum_status status = tradeoff_view_make(space->shape, script, reference, &view, error);
  THRUM_THEN(status, tradeoff_samples_make(rank, &samples, error));
  THRUM_THEN(status, tradeoff_step(space, &view, def, &samples, &pass, error));
  if (status >= 0 && pass.whole) {
    const tradeoff_errors errors = tradeoff_against_full(&view, rank, &samples);
    *found = errors.displacement;
    *velocity = errors.velocity;
  }
  free(samples.q);
  tradeoff_view_free(&view);
  return status;
}

/* The chosen setting, and the model's own basis at its time step, under the tests. */
static thrum_status run_tests(tradeoff_solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  thrum_status status = THRUM_OK;

  // the model's own basis, if it was tried
  int64_t own = -1;
  for (int64_t b = s->result.basis_count - 1; b >= 0; b--)
    if (s->result.bases[b].recipe.modes == 0 && s->result.bases[b].recipe.masters == 0)
      own = b;

  // `chosen` steps with its own integrator, and the model's own basis with `energy`
  for (int64_t n = 0; n < problem->test_count && s->result.chosen >= 0 && status >= 0; n++) {
    const tradeoff_run *run = &s->result.runs[s->result.chosen];
    const thrum_state_def def = tradeoff_def(problem, run->integrator, run->dt, run->tolerance);
    const thrum_state_def plain =
        tradeoff_def(problem, EXPERIMENT_SCHEME_ENERGY, run->dt, run->tolerance);
    const full_motion_script *script = &problem->tests[n];

    // both against the full order under this test
    tradeoff_reference reference = {0};
    s->result.test_error[n] = s->result.test_own_error[n] = NAN;
    s->result.test_velocity[n] = s->result.test_own_velocity[n] = NAN;
    if (problem->take != NULL && !problem->is_kept(problem->take_context, n))
      continue;
    THRUM_THEN(status, tradeoff_space_again(s, run->basis, error));
    if (own >= 0)
      THRUM_THEN(status, tradeoff_space_again(s, own, error));
    THRUM_THEN(status, tradeoff_reference_make(problem, script, "full order of a test", false,
                                               &reference, error));
    THRUM_THEN(status, test_error(s, run->basis, &def, script, &reference, &s->result.test_error[n],
                                  &s->result.test_velocity[n], error));
    if (own >= 0)
      THRUM_THEN(status,
                 test_error(s, own, &plain, script, &reference, &s->result.test_own_error[n],
                            &s->result.test_own_velocity[n], error));
    tradeoff_reference_free(&reference);
  }
  return status;
}

/* --- all of it -------------------------------------------------------------------------------- */

static void release(tradeoff_solution *s) {
  for (int64_t b = 0; s->spaces != NULL && b < TRADEOFF_BASES_MAX; b++)
    tradeoff_space_free(&s->spaces[b]);
  free(s->spaces);
  tradeoff_reference_free(&s->reference);
}

static double squares_of(const tradeoff_reference *reference) {
  double sum = 0;
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
    sum += reference->u_square[n];
  return sum;
}

/* All settings of the recipes. */
static thrum_status try_recipes(tradeoff_solution *s, thrum_error *error) {
  if (s->problem->take != NULL)
    return tradeoff_take_recipes(s, error);
  THRUM_TRY(tradeoff_spaces_make(s, error));
  THRUM_TRY(tradeoff_spaces_condense(s, error));
  return tradeoff_try(s, 0, error);
}

/* The recipes, then what the search adds to them, then what the chosen setting is worth. */
static thrum_status solve(tradeoff_solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  THRUM_TRY(try_recipes(s, error));
  s->result.full_cost = 1e-6 * s->reference.us_per_step / problem->full_dt;
  s->result.chosen = tradeoff_choose(&s->result, problem->error, problem->cost);
  THRUM_TRY(tradeoff_search(s, error));
  THRUM_TRY(judge_reference(s, error));
  THRUM_TRY(tradeoff_mesh_error(&s->reference, &s->result.mesh_error, error));
  return run_tests(s, error);
}

/* The reference and room for the bases. The reference comes first: it is the dearest, and says
 * whether the load moves anything. `keep`: its displacements, which bases are trained on. */
static thrum_status begin(tradeoff_solution *s, bool keep, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  static const int64_t most = TRADEOFF_BASES_MAX;

  // what cannot be compared is refused before the dear part
  if (problem->model->rigid != NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "nothing of the model is held: a free body moves as a whole, which its "
                           "coordinates cannot");

  THRUM_TRY(
      tradeoff_reference_make(problem, &problem->script, "full order", keep, &s->reference, error));
  THRUM_TRY(thrum_reserve(&s->spaces, most, sizeof *s->spaces, "the bases", error));
  THRUM_TRY(thrum_reserve(&s->result.bases, most, sizeof(tradeoff_basis), "the bases", error));
  if (squares_of(&s->reference) > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "the load moves nothing in %g s: it is zero, acts on what is held, or "
                         "begins later",
                         problem->script.time);
}

/* Gives the result where all went well, and frees the rest. */
static thrum_status end(tradeoff_solution *s, thrum_status status, tradeoff_result *result) {
  if (status >= 0) {
    mark_front(&s->result);
    s->result.free_count = s->reference.n;
    s->result.lumped = s->reference.body.kind == THRUM_MASS_LUMPED;
    s->result.full_us_per_step = s->reference.us_per_step;
    *result = s->result;
  } else {
    tradeoff_free(&s->result);
  }
  release(s);
  return status;
}

thrum_status tradeoff_solve(const tradeoff_problem *problem, tradeoff_result *result,
                            thrum_error *error) {
  tradeoff_solution s = {.problem = problem,
                         .full_error = NAN,
                         .least_error = INFINITY,
                         .result = {.by_worse = problem->by_worse}};

  // the linear algebra has one thread, as times are those of a thread
  const thrum_threads before = thrum_threads_set(1);
  thrum_status status = begin(&s, problem->rank_max > 0, error);
  THRUM_THEN(status, solve(&s, error));
  status = end(&s, status, result);
  thrum_threads_restore(before);
  return status;
}

thrum_status tradeoff_solve_recipe(const tradeoff_problem *problem, const tradeoff_recipe *recipe,
                                   tradeoff_result *result, thrum_error *error) {
  tradeoff_solution s = {.problem = problem};
  const thrum_threads before = thrum_threads_set(1);
  thrum_status status = begin(&s, recipe->trained, error);
  THRUM_THEN(status, tradeoff_try_recipe(&s, recipe, error));
  THRUM_THEN(status, judge_reference(&s, error));
  s.result.chosen = -1;
  status = end(&s, status, result);
  thrum_threads_restore(before);
  return status;
}

thrum_status tradeoff_solve_test(const tradeoff_problem *problem, int64_t test,
                                 thrum_error *error) {
  tradeoff_reference reference = {0};
  const thrum_threads before = thrum_threads_set(1);
  const thrum_status status = tradeoff_reference_make(
      problem, &problem->tests[test], "full order of a test", false, &reference, error);
  tradeoff_reference_free(&reference);
  thrum_threads_restore(before);
  return status;
}

const char *tradeoff_precision(const tradeoff_basis *basis) {
  return basis->recipe.single || basis->points > 0 ? "single" : "double";
}
