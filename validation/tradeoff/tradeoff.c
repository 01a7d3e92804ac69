/* The bases, their tight runs, and all settings over the pool. SPDX-License-Identifier: Apache-2.0
 */
#include "validation/tradeoff/tradeoff.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/drift.h"
#include "driver/split_at.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/thread_pool.h"
#include "thrum/external_load.h"
#include "thrum/polynomial.h"

#define TIGHT_STEPS 8 /* of a tight run in the shortest time step asked for */
#define TIGHT_TOLERANCE 1e-12
#define LOST 10.0 /* times the largest energy of the tight run */
#define BAND_SHARE                                                                                 \
  0.01 /* of the kinetic energy of the tight run, for a mode to be in the load's band */

/* Everything while it is made. */
typedef struct solution {
  const tradeoff_problem *problem;
  tradeoff_reference reference;
  tradeoff_space *spaces; /* basis_count */
  tradeoff_result result;
} solution;

/* A pool with a stage's name on its progress. */
typedef struct staged {
  const tradeoff_problem *problem;
  const char *stage;
} staged;

static bool show(void *context, double fraction) {
  const staged *s = context;
  return s->problem->progress == NULL ||
         s->problem->progress(s->problem->progress_context, s->stage, fraction);
}

typedef struct taker {
  tradeoff_samples *samples;
  int64_t rank;
  double energy_from, energy_to;
} taker;

static void take(void *context, int64_t index, double share, const double *value) {
  const taker *t = context;
  const size_t bytes = (size_t)t->rank * sizeof *value;
  memcpy(t->samples->q + index * t->rank, value, bytes);
  memcpy(t->samples->p + index * t->rank, value + t->rank, bytes);
  t->samples->energy[index] = (1 - share) * t->energy_from + share * t->energy_to;
}

/* Steps the load script in one space; *seconds: processor time a step. THRUM_OK even where the run
 * ends early: *whole says whether it did not. */
static thrum_status step_script(const tradeoff_problem *problem, const tradeoff_space *space,
                                const thrum_state_def *def, tradeoff_samples *samples,
                                double *seconds, bool *whole, thrum_error *error) {
  const thrum_model *model = space->model;
  const int64_t rank = model->rank, steps = thrum_step_count(problem->time, def->dt);
  double from[2 * THRUM_RANK_MAX] = {0}, to[2 * THRUM_RANK_MAX], work[2 * THRUM_RANK_MAX];
  double force[THRUM_RANK_MAX];
  thrum_state *state = NULL;
  taker t = {samples, rank, 0, 0};
  THRUM_TRY(thrum_state_create(model, def, &state, error));
  double spent = 0;
  int64_t k = 0;

  // only the load and the step are timed, not the sampling
  for (; k < steps; k++) {
    thrum_energies energies;
    const double began = clock_thread_seconds();
    thrum_load_sum(problem->courses, space->directions, problem->load_count, rank, k, def->dt,
                   force);
    if (thrum_state_set_force(model, state, force, NULL) < 0 || thrum_step(model, state, NULL) < 0)
      break;
    spent += clock_thread_seconds() - began;
    if (thrum_state_get(model, state, to, to + rank, NULL) < 0 ||
        thrum_state_energies(model, state, &energies, NULL) < 0)
      break;

    t.energy_to = energies.total;
    tradeoff_sample(problem->time, (double)k * def->dt, def->dt, rank, from, to, take, &t, work);
    memcpy(from, to, sizeof from);
    t.energy_from = t.energy_to;
  }

  *seconds = spent / (double)(k > 0 ? k : 1);
  *whole = k == steps;
  thrum_state_destroy(state);
  return THRUM_OK;
}

static double squares(const double *x, int64_t count) {
  double sum = 0;
  for (int64_t i = 0; i < count; i++)
    sum += x[i] * x[i];
  return sum;
}

/* The errors of samples in a space against the full order. */
static tradeoff_errors against_full(const tradeoff_reference *reference,
                                    const tradeoff_space *space, const tradeoff_samples *samples) {
  const int64_t rank = space->model->rank;
  double wrong[2] = {0}, whole[2] = {0}, energy = 0, most = 0;

  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++) {
    const double *values[2] = {samples->q + n * rank, samples->p + n * rank};
    const double *known[2] = {space->reference_q + n * rank, space->reference_p + n * rank};
    const double size[2] = {reference->u_square[n], reference->v_square[n]};
    for (int w = 0; w < 2; w++) {
      // what lies outside the basis, and the difference inside it
      wrong[w] += fmax(0, size[w] - squares(known[w], rank));
      for (int64_t i = 0; i < rank; i++)
        wrong[w] += (values[w][i] - known[w][i]) * (values[w][i] - known[w][i]);
      whole[w] += size[w];
    }

    energy = fmax(energy, fabs(samples->energy[n] - reference->energy[n]));
    most = fmax(most, fabs(reference->energy[n]));
  }
  return (tradeoff_errors){sqrt(wrong[0] / whole[0]), sqrt(wrong[1] / whole[1]), energy / most};
}

/* The errors of samples against others of the same space. */
static tradeoff_errors against(int64_t rank, const tradeoff_samples *samples,
                               const tradeoff_samples *other) {
  double wrong[2] = {0}, energy = 0, most = 0;
  for (int64_t i = 0; i < TRADEOFF_SAMPLES * rank; i++) {
    wrong[0] += (samples->q[i] - other->q[i]) * (samples->q[i] - other->q[i]);
    wrong[1] += (samples->p[i] - other->p[i]) * (samples->p[i] - other->p[i]);
  }
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++) {
    energy = fmax(energy, fabs(samples->energy[n] - other->energy[n]));
    most = fmax(most, fabs(other->energy[n]));
  }
  return (tradeoff_errors){sqrt(wrong[0] / squares(other->q, TRADEOFF_SAMPLES * rank)),
                           sqrt(wrong[1] / squares(other->p, TRADEOFF_SAMPLES * rank)),
                           energy / most};
}

static thrum_status samples_make(int64_t rank, tradeoff_samples *samples, thrum_error *error) {
  samples->q = thrum_allocate(2 * TRADEOFF_SAMPLES * rank, sizeof *samples->q, "samples", error);
  if (samples->q == NULL)
    return THRUM_OUT_OF_MEMORY;
  samples->p = samples->q + TRADEOFF_SAMPLES * rank;
  return THRUM_OK;
}

/* U^T of the reference's samples. */
static void project(const tradeoff_reference *reference, tradeoff_space *space) {
  const int64_t rank = space->model->rank;
  const double *from[2] = {reference->mass_u, reference->mass_v};
  double *to[2] = {space->reference_q, space->reference_p};
  for (int w = 0; w < 2; w++)
    for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
      for (int64_t f = 0; f < reference->n; f++) {
        const double *row = space->model->basis + reference->body.fem.component[f] * rank;
        const double value = from[w][n * reference->n + f];
        for (int64_t i = 0; i < rank; i++)
          to[w][n * rank + i] += row[i] * value;
      }
}

/* Basis n of the problem at place b: the model's own, or one made from its mesh. */
static thrum_status make_space(solution *s, int64_t n, int64_t b, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  tradeoff_space *space = &s->spaces[b];
  tradeoff_basis *basis = &s->result.bases[b];
  *basis = (tradeoff_basis){
      .modes = problem->modes[n], .rank = problem->ranks[n], .precompute_seconds = NAN};

  space->model = problem->model;
  basis->single =
      problem->modes[n] > 0 ? problem->single[n] : problem->model->packed_single != NULL;

  // a basis of its own is made from the mesh
  if (problem->modes[n] > 0) {
    thrum_precompute_options options = thrum_default_precompute_options();
    options.modes = problem->modes[n];
    options.rank = problem->ranks[n];
    options.single = problem->single[n];
    options.mass = s->reference.body.kind;
    const double began = clock_thread_seconds();
    const thrum_status status = thrum_precompute(&s->reference.body.mesh, problem->model->fixed,
                                                 &options, &space->made, error);
    if (status < 0)
      return status;
    basis->precompute_seconds = clock_thread_seconds() - began;
    // its steps are timed, so it is packed as a model from a file is
    const size_t size = thrum_model_pack_size(&space->made.model);
    space->packed = thrum_allocate_aligned(size, "a basis", error);
    if (space->packed == NULL)
      return THRUM_OUT_OF_MEMORY;
    THRUM_TRY(thrum_model_pack(&space->made.model, space->packed, size, error));
    space->model = &space->made.model;
  }

  // the reference and the loads in this space
  const int64_t rank = space->model->rank, components = 3 * problem->model->vertex_count;
  basis->rank = rank;
  space->directions = thrum_allocate((problem->load_count + 2 * TRADEOFF_SAMPLES) * rank,
                                     sizeof *space->directions, "a basis", error);
  if (space->directions == NULL)
    return THRUM_OUT_OF_MEMORY;
  memset(space->directions, 0,
         (size_t)((problem->load_count + 2 * TRADEOFF_SAMPLES) * rank) * sizeof(double));
  space->reference_q = space->directions + problem->load_count * rank;
  space->reference_p = space->reference_q + TRADEOFF_SAMPLES * rank;

  project(&s->reference, space);
  thrum_status status = samples_make(rank, &space->tight, error);
  for (int64_t l = 0; l < problem->load_count && status >= 0; l++)
    status = thrum_load_add_field(space->model, problem->forces + l * components,
                                  space->directions + l * rank, error);
  return status;
}

static thrum_state_def def_of(const tradeoff_problem *problem, experiment_scheme scheme, double dt,
                              double tolerance) {
  thrum_state_def def = experiment_scheme_def(scheme, dt);
  def.tolerance = tolerance;
  def.damping_alpha = problem->damping_alpha;
  def.damping_beta = problem->damping_beta;
  return def;
}

static void space_free(tradeoff_space *space) {
  thrum_precomputed_free(&space->made);
  free(space->packed);
  free(space->directions);
  free(space->tight.q);
  *space = (tradeoff_space){0};
}

/* All bases; those that the mesh is too small for are left out. */
static thrum_status make_spaces(solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  int64_t made = 0;
  for (int64_t n = 0; n < problem->rank_count; n++) {
    thrum_error detail = {0};
    const thrum_status status = make_space(s, n, made, &detail);
    if (status == THRUM_OUT_OF_MEMORY || status == THRUM_INTERRUPTED) {
      *error = detail;
      return status;
    }

    // a basis that the mesh is too small for is dropped and counted
    if (status < 0) {
      space_free(&s->spaces[made]);
      s->result.dropped++;
      s->result.dropped_reason = detail;
    } else {
      made++;
    }

    if (!show(&(staged){problem, "bases"}, (double)(n + 1) / (double)problem->rank_count))
      return thrum_error_set(error, THRUM_INTERRUPTED, "interrupted");
  }

  // with no basis left there is nothing to compare
  s->result.basis_count = made;
  if (made > 0)
    return THRUM_OK;
  *error = s->result.dropped_reason;
  return error->status;
}

/* The tight run of a basis, task of the pool. */
static thrum_status run_tight(void *context, int64_t b, thrum_error *error) {
  solution *s = context;
  const tradeoff_problem *problem = s->problem;
  tradeoff_basis *basis = &s->result.bases[b];
  double shortest = problem->full_dt, seconds;
  bool whole;
  for (int64_t n = 0; n < problem->dt_count; n++)
    shortest = fmin(shortest, problem->dts[n]);

  // short enough that its error in time is far below that of every setting
  basis->tight_dt = shortest / TIGHT_STEPS;
  const thrum_state_def def =
      def_of(problem, EXPERIMENT_SCHEME_ENERGY, basis->tight_dt, TIGHT_TOLERANCE);

  THRUM_TRY(
      step_script(problem, &s->spaces[b], &def, &s->spaces[b].tight, &seconds, &whole, error));

  if (!whole)
    return thrum_error_set(error, THRUM_NOT_CONVERGED,
                           "the load is more than a model of rank %lld can be stepped through: "
                           "lower it",
                           (long long)basis->rank);
  basis->error = against_full(&s->reference, &s->spaces[b], &s->spaces[b].tight);
  return THRUM_OK;
}

/* Drift over the free samples by quarters, since there are few; NaN for a damped body. */
static double drift_of(const tradeoff_problem *problem, const tradeoff_samples *samples) {
  double end = 0;
  for (int64_t n = 0; n < problem->load_count; n++)
    end = fmax(end, problem->courses[n].until);
  const double first = ceil(end / problem->time * TRADEOFF_SAMPLES);
  if (problem->damping_alpha > 0 || problem->damping_beta > 0 || !(first < TRADEOFF_SAMPLES - 8))
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
  const int64_t rank = space->model->rank;
  thrum_stepped_mode modes[THRUM_RANK_MAX];
  double energy[THRUM_RANK_MAX] = {0}, sum = 0;
  THRUM_TRY(stepped_modes_at(space->model, def, modes, error));

  // the kinetic energy of each mode over the samples says which ones the load moves
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
    for (int64_t i = 0; i < rank; i++) {
      const double p = space->tight.p[n * rank + i];
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
  solution *s = context;
  const tradeoff_problem *problem = s->problem;
  tradeoff_run *run = &s->result.runs[index];
  const tradeoff_space *space = &s->spaces[run->basis];
  const thrum_state_def def = def_of(problem, run->integrator, run->dt, run->tolerance);
  tradeoff_samples samples = {0};
  double seconds = 0, most = 0;
  bool whole = false;

  thrum_status status = samples_make(space->model->rank, &samples, error);
  THRUM_THEN(status, step_script(problem, space, &def, &samples, &seconds, &whole, error));

  THRUM_THEN(status, judge_frequencies(space, &def, run, error));

  // an energy far above that of the tight run is that of no motion under this load
  if (status >= 0) {
    run->stable = whole;
    for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
      most = fmax(most, space->tight.energy[n]);
    for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
      run->stable = run->stable && samples.energy[n] < LOST * most;
    run->us_per_step = 1e6 * seconds;
    run->cost = seconds / run->dt;
    run->error = run->time_error = (tradeoff_errors){NAN, NAN, NAN};
    run->drift = NAN;

    if (run->stable) {
      run->error = against_full(&s->reference, space, &samples);
      run->time_error = against(space->model->rank, &samples, &space->tight);
      run->drift = drift_of(problem, &samples);
    }
  }
  free(samples.q);
  return status;
}

static thrum_status run_pool(solution *s, const char *stage, int64_t count,
                             thrum_status (*task)(void *, int64_t, thrum_error *),
                             thrum_error *error) {
  staged stage_of = {s->problem, stage};
  const thrum_thread_pool pool = {.threads = s->problem->threads,
                                  .count = count,
                                  .task = task,
                                  .progress = show,
                                  .context = s,
                                  .progress_context = &stage_of};
  return thrum_thread_pool_run(&pool, error);
}

/* Every setting of every basis. */
static thrum_status plan_runs(solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  const int64_t room =
      problem->rank_count * problem->dt_count * problem->tolerance_count * EXPERIMENT_SCHEME_COUNT;
  s->result.runs = thrum_allocate(room, sizeof *s->result.runs, "the runs", error);
  if (s->result.runs == NULL)
    return THRUM_OUT_OF_MEMORY;

  // by basis, integrator, time step, tolerance, the last fastest
  for (int64_t b = 0; b < s->result.basis_count; b++)
    for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++)
      for (int64_t d = 0; d < problem->dt_count && problem->integrators[i]; d++)
        for (int64_t t = 0; t < problem->tolerance_count; t++)
          s->result.runs[s->result.run_count++] =
              (tradeoff_run){.basis = b,
                             .integrator = (experiment_scheme)i,
                             .dt = problem->dts[d],
                             .tolerance = problem->tolerances[t]};
  return THRUM_OK;
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
static thrum_status judge_reference(solution *s, thrum_error *error) {
  int64_t best = 0;
  for (int64_t b = 1; b < s->result.basis_count; b++)
    if (s->result.bases[b].error.displacement < s->result.bases[best].error.displacement)
      best = b;

  // its tight run has no error in time to speak of
  const tradeoff_space *space = &s->spaces[best];
  thrum_state_def def =
      def_of(s->problem, EXPERIMENT_SCHEME_ENERGY, s->problem->full_dt, TIGHT_TOLERANCE);
  def.frequency_matched = 0;
  tradeoff_samples samples = {0};
  double seconds;
  bool whole = false;
  thrum_status status = samples_make(space->model->rank, &samples, error);
  THRUM_THEN(status, step_script(s->problem, space, &def, &samples, &seconds, &whole, error));
  s->result.full_error = status >= 0 && whole
                             ? against(space->model->rank, &samples, &space->tight).displacement
                             : NAN;
  free(samples.q);
  return status;
}

static void release(solution *s) {
  for (int64_t b = 0; s->spaces != NULL && b < s->problem->rank_count; b++)
    space_free(&s->spaces[b]);
  free(s->spaces);
  tradeoff_reference_free(&s->reference);
}

static double squares_of(const tradeoff_reference *reference) {
  double sum = 0;
  for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
    sum += reference->u_square[n];
  return sum;
}

thrum_status tradeoff_solve(const tradeoff_problem *problem, tradeoff_result *result,
                            thrum_error *error) {
  solution s = {.problem = problem};
  if (problem->model->rigid != NULL)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "nothing of the model is held: a free body moves as a whole, which its "
                           "coordinates cannot");

  // the reference comes first: it is the dearest, and says whether the load moves anything
  thrum_status status = tradeoff_reference_make(problem, &s.reference, error);
  s.spaces = calloc((size_t)problem->rank_count, sizeof *s.spaces);
  s.result.bases = calloc((size_t)problem->rank_count, sizeof *s.result.bases);
  if (status >= 0 && (s.spaces == NULL || s.result.bases == NULL))
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  if (status >= 0 && !(squares_of(&s.reference) > 0))
    status = thrum_error_set(error, THRUM_BAD_VALUE,
                             "the load moves nothing in %g s: it is zero, acts on what is held, or "
                             "begins later",
                             problem->time);

  // each stage needs the one before it
  THRUM_THEN(status, make_spaces(&s, error));
  THRUM_THEN(status, run_pool(&s, "tight runs", s.result.basis_count, run_tight, error));
  THRUM_THEN(status, judge_reference(&s, error));
  THRUM_THEN(status, plan_runs(&s, error));
  THRUM_THEN(status, run_pool(&s, "settings", s.result.run_count, run_setting, error));

  if (status >= 0) {
    mark_front(&s.result);
    s.result.free_count = s.reference.n;
    s.result.full_us_per_step = s.reference.us_per_step;
    s.result.full_cost = 1e-6 * s.reference.us_per_step / problem->full_dt;
  }
  release(&s);
  if (status < 0)
    tradeoff_free(&s.result);
  else
    *result = s.result;
  return status;
}

void tradeoff_free(tradeoff_result *result) {
  free(result->bases);
  free(result->runs);
  *result = (tradeoff_result){0};
}

int64_t tradeoff_choose(const tradeoff_result *result, double error, double cost) {
  int64_t best = -1;
  for (int64_t n = 0; n < result->run_count; n++) {
    const tradeoff_run *run = &result->runs[n];
    if (!run->stable || run->error.displacement > error || run->cost > cost)
      continue;
    const tradeoff_run *chosen = best >= 0 ? &result->runs[best] : NULL;
    // an error asks for the cheapest, a budget alone for the most accurate
    const bool better =
        chosen == NULL || (!isnan(error) ? run->cost < chosen->cost
                                         : run->error.displacement < chosen->error.displacement);
    if (better)
      best = n;
  }
  return best;
}
