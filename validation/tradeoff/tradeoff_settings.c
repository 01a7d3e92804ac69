/* The bases of a trade-off, their tight runs, all settings over the pool, and which of them is
 * chosen. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/model/split_at.h"
#include "driver/run/drift.h"
#include "platform/allocate.h"
#include "platform/thread_pool.h"
#include "platform/threads.h"
#include "validation/tradeoff/tradeoff_private.h"

#define TIGHT_STEPS 8 /* of a tight run in the shortest time step asked for */
#define TIGHT_TOLERANCE 1e-12
#define LOST 10.0 /* times the largest energy of the tight run */
#define BAND_SHARE                                                                                 \
  0.01 /* of the kinetic energy of the tight run, for a mode to be in the load's band */

thrum_state_def tradeoff_def(const tradeoff_problem *problem, experiment_scheme scheme, double dt,
                             double tolerance) {
  thrum_state_def def = experiment_scheme_def(scheme, dt);
  def.tolerance = tolerance;
  def.damping_alpha = problem->script.damping_alpha;
  def.damping_beta = problem->script.damping_beta;
  return def;
}

thrum_status tradeoff_spaces_make(tradeoff_solution *s, thrum_error *error) {
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

thrum_status tradeoff_spaces_condense(tradeoff_solution *s, thrum_error *error) {
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
      tradeoff_def(problem, EXPERIMENT_SCHEME_ENERGY, basis->tight_dt, TIGHT_TOLERANCE);
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
  const thrum_state_def def = tradeoff_def(problem, run->integrator, run->dt, run->tolerance);
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

const char *tradeoff_flag(const tradeoff_run *run) {
  if (run->grew)
    return "energy_grew";
  return run->fallback_steps > 0 ? "fell_back" : NULL;
}

/* Whether a run is as near as was asked by a cancellation of what is too far by itself. */
static bool is_lucky(const tradeoff_result *result, const tradeoff_run *run, double error) {
  return run->cancels &&
         !(tradeoff_judged(&result->bases[run->basis].error, result->by_worse) <= error);
}

const char *tradeoff_barred(const tradeoff_result *result, const tradeoff_run *run, double error,
                            double cost) {
  if (!run->stable)
    return "lost";
  if (run->disproved)
    return "condensed too far";
  if (tradeoff_judged(&run->error, result->by_worse) > error)
    return "error too large";
  if (run->cost > cost)
    return "too dear";
  if (!isnan(error) && is_lucky(result, run, error))
    return "errors cancel";
  return tradeoff_flag(run);
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
  const bool other = is_lucky(result, chosen, error);
  if (is_lucky(result, run, error) != other)
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

void tradeoff_free(tradeoff_result *result) {
  free(result->bases);
  free(result->runs);
  *result = (tradeoff_result){0};
}

/* --- what was run elsewhere ------------------------------------------------------------------- */

/* Appends one basis of a part with its runs. */
static thrum_status append(tradeoff_solution *s, const tradeoff_result *part, int64_t b,
                           thrum_error *error) {
  tradeoff_result *result = &s->result;
  const size_t room = (size_t)(result->run_count + part->run_count + 1);
  if (result->basis_count == TRADEOFF_BASES_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "more than %d bases at a time",
                           TRADEOFF_BASES_MAX);
  tradeoff_run *runs = realloc(result->runs, room * sizeof *runs);
  if (runs == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the runs");
  result->runs = runs;

  // runs count bases as the whole does
  for (int64_t n = 0; n < part->run_count; n++) {
    if (part->runs[n].basis != b)
      continue;
    runs[result->run_count] = part->runs[n];
    runs[result->run_count++].basis = result->basis_count;
  }
  result->bases[result->basis_count++] = part->bases[b];
  return THRUM_OK;
}

/* Counts what a part says beside its bases: a recipe that could not be made, and how far the
 * full order is from exact by this basis, which counts where it is the best. */
static void count_part(tradeoff_solution *s, const tradeoff_result *part) {
  if (part->dropped > 0) {
    s->result.dropped += part->dropped;
    s->result.dropped_reason = part->dropped_reason;
  }
  if (part->basis_count > 0 && part->bases[0].error.displacement < s->least_error) {
    s->least_error = part->bases[0].error.displacement;
    s->full_error = part->full_error;
  }
}

static thrum_status take(const tradeoff_solution *s, const tradeoff_recipe *recipe,
                         tradeoff_result *part, thrum_error *error) {
  return s->problem->take(s->problem->take_context, recipe, part, error);
}

/* The whole bases of all recipes come before the condensed ones. */
static thrum_status append_recipes(tradeoff_solution *s, bool condensed, thrum_error *error) {
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < s->problem->recipe_count && status >= 0; n++) {
    tradeoff_result part = {0};
    status = take(s, &s->problem->recipes[n], &part, error);
    if (status >= 0 && !condensed)
      count_part(s, &part);
    for (int64_t b = 0; b < part.basis_count && status >= 0; b++)
      if ((b > 0) == condensed)
        status = append(s, &part, b, error);
    tradeoff_free(&part);
  }
  return status;
}

thrum_status tradeoff_take_recipes(tradeoff_solution *s, thrum_error *error) {
  THRUM_TRY(append_recipes(s, false, error));
  THRUM_TRY(append_recipes(s, true, error));
  if (s->result.basis_count > 0)
    return THRUM_OK;

  // with no basis left there is nothing to compare
  return s->result.dropped > 0 ? thrum_error_set(error, s->result.dropped_reason.status, "%s",
                                                 s->result.dropped_reason.message)
                               : thrum_error_set(error, THRUM_MISSING, "no basis was tried yet");
}

thrum_status tradeoff_take_recipe(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                  thrum_error *error) {
  tradeoff_result part = {0};
  thrum_status status = take(s, recipe, &part, error);
  if (status >= 0)
    count_part(s, &part);
  for (int64_t b = 0; b < part.basis_count && status >= 0; b++)
    status = append(s, &part, b, error);
  tradeoff_free(&part);
  return status;
}
