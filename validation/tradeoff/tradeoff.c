/* The reference, the bases asked for, their tight runs, all settings over the pool, and what is
 * chosen of them. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "driver/drift.h"
#include "driver/split_at.h"
#include "platform/allocate.h"
#include "platform/thread_pool.h"
#include "platform/threads.h"
#include "validation/tradeoff/tradeoff_private.h"

#define TIGHT_STEPS 8 /* of a tight run in the shortest time step asked for */
#define TIGHT_TOLERANCE 1e-12
#define LOST 10.0 /* times the largest energy of the tight run */
#define BAND_SHARE                                                                                 \
  0.01 /* of the kinetic energy of the tight run, for a mode to be in the load's band */

static thrum_state_def def_of(const tradeoff_problem *problem, experiment_scheme scheme, double dt,
                              double tolerance) {
  thrum_state_def def = experiment_scheme_def(scheme, dt);
  def.tolerance = tolerance;
  def.damping_alpha = problem->script.damping_alpha;
  def.damping_beta = problem->script.damping_beta;
  return def;
}

/* All recipes; those that the mesh is too small for are left out. */
static thrum_status make_spaces(tradeoff_solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  for (int64_t n = 0; n < problem->recipe_count; n++) {
    thrum_error detail = {0};
    const thrum_status status = tradeoff_space_make(s, &problem->recipes[n], &detail);
    if (status == THRUM_OUT_OF_MEMORY || status == THRUM_INTERRUPTED) {
      *error = detail;
      return status;
    }

    // a basis that the mesh is too small for is dropped and counted
    if (status < 0) {
      s->result.dropped++;
      s->result.dropped_reason = detail;
    }
    if (!tradeoff_show(&(tradeoff_stage){problem, "bases"},
                       (double)(n + 1) / (double)problem->recipe_count))
      return thrum_error_set(error, THRUM_INTERRUPTED, "interrupted");
  }

  // with no basis left there is nothing to compare
  if (s->result.basis_count > 0)
    return THRUM_OK;
  *error = s->result.dropped_reason;
  return error->status;
}

/* The linear modes of the bases alone, the other coordinates following. */
static thrum_status condense_spaces(tradeoff_solution *s, thrum_error *error) {
  for (int64_t b = 0, count = s->result.basis_count; b < count && s->problem->condense; b++) {
    const tradeoff_recipe whole = s->result.bases[b].recipe;
    int64_t masters[2];
    const int64_t found = tradeoff_masters(s, b, masters);
    for (int64_t n = 0; n < found && whole.masters == 0; n++) {
      tradeoff_recipe recipe = whole;
      recipe.masters = masters[n];
      THRUM_TRY(tradeoff_space_make(s, &recipe, error));
    }
  }
  return THRUM_OK;
}

/* The tasks of a pool: bases or runs from the first on. */
typedef struct batch {
  tradeoff_solution *solution;
  int64_t first;
} batch;

/* The tight run of a basis, task of the pool. */
static thrum_status run_tight(void *context, int64_t index, thrum_error *error) {
  const batch *work = context;
  tradeoff_solution *s = work->solution;
  const int64_t b = work->first + index;
  const tradeoff_problem *problem = s->problem;
  tradeoff_basis *basis = &s->result.bases[b];
  tradeoff_space *space = &s->spaces[b];
  double shortest = problem->full_dt;
  tradeoff_pass pass = {0};
  for (int64_t n = 0; n < problem->dt_count; n++)
    shortest = fmin(shortest, problem->dts[n]);

  // short enough that its error in time is far below that of every setting
  basis->tight_dt = shortest / TIGHT_STEPS;
  const thrum_state_def def =
      def_of(problem, EXPERIMENT_SCHEME_ENERGY, basis->tight_dt, TIGHT_TOLERANCE);
  THRUM_TRY(tradeoff_step(space, &space->view, &def, &space->tight, &pass, error));

  // a condensed basis may have no motion of this load, and then has no error either
  basis->error = (tradeoff_errors){NAN, NAN, NAN};
  if (!pass.whole && basis->recipe.masters == 0)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "the load is more than a model of rank %lld can be stepped through: "
                           "lower it",
                           (long long)basis->rank);
  if (pass.whole)
    basis->error = tradeoff_against_full(&space->view, space->shape->rank, &space->tight);
  return THRUM_OK;
}

/* Drift over the free samples by quarters, since there are few; NaN for a damped body. */
static double drift_of(const tradeoff_problem *problem, const tradeoff_samples *samples) {
  double end = 0;
  for (int64_t n = 0; n < problem->script.load_count; n++)
    end = fmax(end, problem->script.courses[n].until);
  const double first = ceil(end / problem->script.time * TRADEOFF_SAMPLES);
  if (problem->script.damping_alpha > 0 || problem->script.damping_beta > 0 ||
      !(first < TRADEOFF_SAMPLES - 8))
    return NAN;

  // the committed results sum the last quarter from its end
  driver_drift drift = driver_drift_plan((int64_t)first, TRADEOFF_SAMPLES, 4, 1);
  for (int64_t n = drift.first_begin; n < drift.first_end; n++)
    driver_drift_add(&drift, n, samples->energy[n]);
  for (int64_t n = drift.last_end - 1; n >= drift.last_begin; n--)
    driver_drift_add(&drift, n, samples->energy[n]);
  return driver_drift_value(&drift);
}

/* The largest relative error of frequency among the modes that the load moves: those with at least
 * BAND_SHARE of the kinetic energy of the tight run, as a mode that only follows the others has
 * little of it. A mode beyond the limit of stability counts as wrong by all of it. */
static thrum_status judge_frequencies(const tradeoff_space *space, const thrum_state_def *def,
                                      tradeoff_run *run, thrum_error *error) {
  const int64_t rank = space->stepped->rank;
  thrum_stepped_mode modes[THRUM_RANK_MAX];
  double energy[THRUM_RANK_MAX] = {0}, sum = 0;
  THRUM_TRY(stepped_modes_at(space->stepped, def, modes, error));

  // the kinetic energy of each mode over the samples says which ones the load moves
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
    for (int64_t i = 0; i < rank; i++) {
      const double p = space->tight.p[n * space->shape->rank + i];
      energy[i] += 0.5 * p * p;
      sum += 0.5 * p * p;
    }

  // the worst of them
  run->frequency_mode = -1;
  run->frequency_error = 0;
  for (int64_t i = 0; i < rank; i++) {
    const thrum_stepped_mode *mode = &modes[i];
    if (!(energy[i] >= BAND_SHARE * sum) || !(mode->hertz > 0))
      continue;
    const double off = isnan(mode->stepped_hertz) ? 1 : fabs(mode->stepped_hertz / mode->hertz - 1);
    if (run->frequency_mode >= 0 && off <= run->frequency_error)
      continue;
    run->frequency_mode = i;
    run->frequency_error = off;
    run->frequency = mode->hertz;
    run->stepped_frequency = mode->stepped_hertz;
  }
  return THRUM_OK;
}

/* One setting, task of the pool. */
static thrum_status run_setting(void *context, int64_t index, thrum_error *error) {
  const batch *work = context;
  tradeoff_solution *s = work->solution;
  const tradeoff_problem *problem = s->problem;
  tradeoff_run *run = &s->result.runs[work->first + index];
  const tradeoff_space *space = &s->spaces[run->basis];
  const tradeoff_basis *basis = &s->result.bases[run->basis];
  const int64_t rank = space->shape->rank;
  const thrum_state_def def = def_of(problem, run->integrator, run->dt, run->tolerance);
  tradeoff_samples samples = {0};
  tradeoff_pass pass = {0};
  double most = 0;

  thrum_status status = tradeoff_samples_make(rank, &samples, error);
  THRUM_THEN(status, tradeoff_step(space, &space->view, &def, &samples, &pass, error));
  THRUM_THEN(status, judge_frequencies(space, &def, run, error));

  // an energy far above that of the tight run is that of no motion under this load
  if (status >= 0) {
    run->stable = pass.whole && isfinite(basis->error.displacement);
    run->disproved = !pass.believed;
    run->fallback_steps = pass.fallback_steps;
    run->grew = pass.grew;
    for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
      most = fmax(most, space->tight.energy[n]);
    for (int64_t n = 0; n < TRADEOFF_SAMPLES && run->stable; n++)
      run->stable = samples.energy[n] < LOST * most;
    run->us_per_step = 1e6 * pass.seconds;
    run->cost = pass.seconds / run->dt;
    run->error = run->time_error = (tradeoff_errors){NAN, NAN, NAN};
    run->drift = NAN;

    if (run->stable) {
      run->error = tradeoff_against_full(&space->view, rank, &samples);
      run->time_error = tradeoff_against(rank, &samples, &space->tight);
      run->cancels = tradeoff_judged(&run->error, s->problem->by_worse) <
                     tradeoff_judged(&basis->error, s->problem->by_worse);
      run->drift = drift_of(problem, &samples);
    }
  }
  free(samples.q);
  return status;
}

static thrum_status run_pool(tradeoff_solution *s, const char *stage, int64_t first, int64_t count,
                             thrum_status (*task)(void *, int64_t, thrum_error *),
                             thrum_error *error) {
  tradeoff_stage stage_of = {s->problem, stage};
  batch work = {s, first};
  const thrum_thread_pool pool = {.threads = s->problem->threads,
                                  .count = count,
                                  .task = task,
                                  .progress = tradeoff_show,
                                  .context = &work,
                                  .progress_context = &stage_of};
  return thrum_thread_pool_run(&pool, error);
}

/* Whether the integrator is tried with a basis: `verlet` pays where the stiff coordinates are gone.
 */
static bool is_tried(const tradeoff_solution *s, int64_t b, int scheme) {
  return s->problem->integrators[scheme] ||
         (scheme == EXPERIMENT_SCHEME_VERLET && s->result.bases[b].recipe.masters > 0);
}

/* Every setting of the bases from `first` on. */
static thrum_status plan_runs(tradeoff_solution *s, int64_t first, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  const int64_t more = (s->result.basis_count - first) * problem->dt_count *
                       problem->tolerance_count * EXPERIMENT_SCHEME_COUNT;
  tradeoff_run *runs = realloc(s->result.runs, (size_t)(s->result.run_count + more) * sizeof *runs);
  if (runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the runs");
  s->result.runs = runs;

  // by basis, integrator, time step, tolerance, the last fastest; an explicit step solves nothing
  for (int64_t b = first; b < s->result.basis_count; b++)
    for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++)
      for (int64_t d = 0; d < problem->dt_count && is_tried(s, b, i); d++)
        for (int64_t t = 0; t < (i == EXPERIMENT_SCHEME_VERLET ? 1 : problem->tolerance_count); t++)
          runs[s->result.run_count++] = (tradeoff_run){.basis = b,
                                                       .integrator = (experiment_scheme)i,
                                                       .dt = problem->dts[d],
                                                       .tolerance = problem->tolerances[t]};
  return THRUM_OK;
}

thrum_status tradeoff_try(tradeoff_solution *s, int64_t first, thrum_error *error) {
  const int64_t runs = s->result.run_count;
  THRUM_TRY(run_pool(s, "tight runs", first, s->result.basis_count - first, run_tight, error));
  THRUM_TRY(plan_runs(s, first, error));
  return run_pool(s, "settings", runs, s->result.run_count - runs, run_setting, error);
}

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
      def_of(s->problem, EXPERIMENT_SCHEME_ENERGY, s->problem->full_dt, TIGHT_TOLERANCE);
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
    const thrum_state_def def = def_of(problem, run->integrator, run->dt, run->tolerance);
    const thrum_state_def plain =
        def_of(problem, EXPERIMENT_SCHEME_ENERGY, run->dt, run->tolerance);
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
  THRUM_TRY(make_spaces(s, error));
  THRUM_TRY(condense_spaces(s, error));
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

void tradeoff_free(tradeoff_result *result) {
  free(result->bases);
  free(result->runs);
  *result = (tradeoff_result){0};
}

const char *tradeoff_precision(const tradeoff_basis *basis) {
  return basis->recipe.single || basis->points > 0 ? "single" : "double";
}

const char *tradeoff_flag(const tradeoff_run *run) {
  if (run->grew)
    return "energy_grew";
  return run->fallback_steps > 0 ? "fell_back" : NULL;
}

/* Whether a run goes before another: an error asks for the cheapest, a budget alone for the most
 * accurate; what owes its error to a cancellation comes last, and before that what is flagged. */
static bool is_better(const tradeoff_result *result, const tradeoff_run *run,
                      const tradeoff_run *chosen, double error) {
  const bool worse = result->by_worse;
  if (chosen == NULL)
    return true;
  const bool flagged = tradeoff_flag(run) != NULL, other_flagged = tradeoff_flag(chosen) != NULL;
  if (isnan(error))
    return flagged != other_flagged
               ? other_flagged
               : tradeoff_judged(&run->error, worse) < tradeoff_judged(&chosen->error, worse);
  const bool lucky =
      run->cancels && !(tradeoff_judged(&result->bases[run->basis].error, worse) <= error);
  const bool other =
      chosen->cancels && !(tradeoff_judged(&result->bases[chosen->basis].error, worse) <= error);
  if (lucky != other)
    return other;
  return flagged != other_flagged ? other_flagged : run->cost < chosen->cost;
}

int64_t tradeoff_choose(const tradeoff_result *result, double error, double cost) {
  int64_t best = -1;
  for (int64_t n = 0; n < result->run_count; n++) {
    const tradeoff_run *run = &result->runs[n];
    if (!run->stable || run->disproved || tradeoff_judged(&run->error, result->by_worse) > error ||
        run->cost > cost)
      continue;
    if (is_better(result, run, best >= 0 ? &result->runs[best] : NULL, error))
      best = n;
  }
  return best;
}
