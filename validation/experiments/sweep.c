/* The sweep over time steps: the same start, the same time, another step.
 *
 * The energy of an undamped body is what the start gave it, 1/2 |p|^2, whatever the step: so its
 * error needs no reference run. The error of q does, and is taken over the first second or so,
 * since later the phases of any two runs have parted. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/sweep.h"

#include <math.h>

#include "platform/clock.h"
#include "validation/experiments/run_outcome.h"

#define LOOKS 1000
#define TIMED_LOOKS 20   /* of a run that is timed in several rounds */
#define IMPULSE_DT 0.003 /* time step at which the impulse is found [s] */
#define DOUBLED 1.0      /* of the energy: gained by then, nothing of the motion is left */

const char *const experiment_start_names[EXPERIMENT_START_COUNT] = {
#define X(name) #name,
    EXPERIMENT_START_LIST(X)
#undef X
};

const experiment_dt experiment_sweep_dts[] = {{1, 1},     {2, 2},    {5, 5},   {10, 10},
                                              {20, 20},   {30, 30},  {50, 50}, {100, 100},
                                              {200, 200}, {500, 500}};
const int64_t experiment_sweep_dt_count =
    sizeof experiment_sweep_dts / sizeof experiment_sweep_dts[0];

// as a game has them: on average 1/60 s, and from a third of the longest up
const experiment_dt experiment_variable_dts[] = {{20, 20}, {30, 10},  {40, 40},   {60, 20},
                                                 {80, 80}, {120, 40}, {166, 166}, {249, 83}};
const int64_t experiment_variable_dt_count =
    sizeof experiment_variable_dts / sizeof experiment_variable_dts[0];

/* A run under way: where it is, and the numbers that its steps are drawn with. */
typedef struct sweep_course {
  thrum_state *state;
  int64_t ticks; /* since the start */
  uint64_t drawn;
} sweep_course;

/* A generator after Knuth, the same numbers for every scheme; the high bits are used. */
static int64_t draw(uint64_t *state, const experiment_dt *dt) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return dt->shortest + (int64_t)((*state >> 33) % (uint64_t)(dt->longest - dt->shortest + 1));
}

/* On failure no state is left. */
static thrum_status begin(const experiment_sweep_case *run, sweep_course *at, double *energy,
                          thrum_error *error) {
  const thrum_state_def def =
      experiment_scheme_def(run->scheme, (double)run->dt.longest * EXPERIMENT_SWEEP_TICK);
  *at = (sweep_course){.drawn = 1};
  thrum_status status = thrum_state_create(run->body->model, &def, &at->state, error);
  THRUM_THEN(status, experiment_kick(run->body, run->impulse, at->state, energy, error));
  if (status < 0)
    thrum_state_destroy(at->state);
  return status;
}

static thrum_status step(const experiment_sweep_case *run, sweep_course *at, thrum_error *error) {
  const thrum_model *model = run->body->model;
  int64_t ticks = run->dt.longest;
  if (run->dt.shortest < run->dt.longest) {
    ticks = draw(&at->drawn, &run->dt);
    THRUM_TRY(thrum_state_set_dt(model, at->state, (double)ticks * EXPERIMENT_SWEEP_TICK, error));
  }
  at->ticks += ticks;
  return thrum_step(model, at->state, error);
}

/* Updates the energy error and the peak amplitude from the present state. */
static thrum_status look(const experiment_sweep_case *run, thrum_state *state, double *difference,
                         experiment_sweep_result *result, thrum_error *error) {
  double q[THRUM_RANK_MAX];
  thrum_energies energies;
  THRUM_TRY(thrum_state_get(run->body->model, state, q, NULL, error));
  THRUM_TRY(thrum_state_energies(run->body->model, state, &energies, error));

  // relative to the energy that the kick gave
  *difference = (energies.total - result->energy) / result->energy;
  result->lost = *difference > EXPERIMENT_LOST;
  if (result->lost)
    return THRUM_OK;
  result->energy_error = fmax(result->energy_error, fabs(*difference));
  result->peak_amplitude = fmax(result->peak_amplitude, experiment_body_amplitude(run->body, q));
  return THRUM_OK;
}

/* One case from its start to the end of its time, timed and looked at now and then. */
static thrum_status run_energy(const experiment_sweep_case *run, int64_t ticks, int64_t looks,
                               experiment_sweep_result *made, thrum_error *error) {
  const int64_t all = ticks / run->dt.longest, stride = all > looks ? all / looks : 1;
  sweep_course at;
  thrum_status status = THRUM_OK;
  THRUM_TRY(begin(run, &at, &made->energy, error));

  // only the steps are timed, not the looks between them
  double seconds = 0, late_sum = 0;
  int64_t late_count = 0;
  while (at.ticks < ticks && status >= 0 && !made->lost) {
    const double began = clock_thread_seconds();
    for (int64_t n = 0; n < stride && at.ticks < ticks && status >= 0; n++)
      status = step(run, &at, &made->stop);
    seconds += clock_thread_seconds() - began;

    // the last tenth gives the change of the mean energy
    double difference = 0;
    THRUM_THEN(status, look(run, at.state, &difference, made, &made->stop));
    if (status >= 0 && 10 * at.ticks >= 9 * ticks) {
      late_sum += difference;
      late_count++;
    }
  }

  made->status = status < 0 ? status : THRUM_OK;
  made->report = thrum_state_report_get(at.state);
  made->us_per_step = 1e6 * seconds / (double)made->report.steps;
  made->cost = seconds / made->report.time;
  made->energy_change = late_count > 0 && status >= 0 ? late_sum / (double)late_count : NAN;
  made->lost = made->lost || made->energy_change > DOUBLED;
  thrum_state_destroy(at.state);
  return THRUM_OK;
}

/* The error of q: every step up to the end of the reference is compared. */
static thrum_status run_error(const experiment_sweep_case *run, experiment_sweep_result *made,
                              thrum_error *error) {
  const experiment_reference *reference = run->reference;
  experiment_deviation sums = {0, 0};
  double q[THRUM_RANK_MAX];
  sweep_course at;
  thrum_status status = THRUM_OK;
  THRUM_TRY(begin(run, &at, &made->energy, error));

  // the last step may lead past the end
  while (status >= 0 && at.ticks < reference->count) {
    status = thrum_state_get(run->body->model, at.state, q, NULL, &made->stop);
    if (status < 0)
      break;
    experiment_deviation_add(&sums, reference, run->body->model->rank, at.ticks, q);
    status = step(run, &at, &made->stop);
  }
  // beyond that its size says nothing
  const double error_of_q = experiment_deviation_value(&sums);
  if (status >= 0 && error_of_q <= EXPERIMENT_LOST)
    made->error = error_of_q;
  thrum_state_destroy(at.state);
  return THRUM_OK;
}

/* One case; the first round fills its result, the others only time the beginning. */
static thrum_status run_index(void *context, int64_t index, thrum_error *error) {
  experiment_sweep *sweep = context;
  const experiment_sweep_case *run = &sweep->cases[index];
  experiment_sweep_result *result = &sweep->results[index];
  experiment_sweep_result made = {.energy_error = NAN, .error = NAN}; // until there is one
  const double time = sweep->round == 0 ? sweep->time : sweep->reference_time;
  const int64_t looks = sweep->round == 0 ? LOOKS : TIMED_LOOKS;
  THRUM_TRY(run_energy(run, thrum_step_count(time, EXPERIMENT_SWEEP_TICK), looks, &made, error));
  if (sweep->round == 0) {
    THRUM_TRY(run_error(run, &made, error));
    *result = made;
    return THRUM_OK;
  }

  // the first timed round takes the place of the time that the looks disturbed
  result->us_per_step =
      sweep->round == 1 ? made.us_per_step : fmin(result->us_per_step, made.us_per_step);
  result->cost = sweep->round == 1 ? made.cost : fmin(result->cost, made.cost);
  return THRUM_OK;
}

/* Body and start with this index among the starts asked for. */
static const experiment_body *find_start(const experiment_sweep *sweep, int64_t index,
                                         experiment_start *start) {
  const int64_t each = sweep->start_count / sweep->body_count;
  int n = 0;
  for (int64_t skip = index % each; !sweep->starts[n] || skip-- > 0;)
    n++;
  *start = (experiment_start)n;
  return n == EXPERIMENT_START_smooth ? &sweep->smooth[index / each] : &sweep->bodies[index / each];
}

/* The impulse of one body and start, and the reference after it. */
static thrum_status make_reference(void *context, int64_t index, thrum_error *error) {
  experiment_sweep *sweep = context;
  experiment_start start;
  const experiment_body *body = find_start(sweep, index, &start);
  double reached = 0;
  THRUM_TRY(experiment_impulse(body, sweep->amplitude, IMPULSE_DT, &sweep->impulses[index],
                               &reached, error));
  return experiment_reference_make(body, sweep->impulses[index], EXPERIMENT_SWEEP_TICK,
                                   thrum_step_count(sweep->reference_time, EXPERIMENT_SWEEP_TICK) +
                                       1,
                                   &sweep->references[index], error);
}

static thrum_status allocate(experiment_sweep *sweep, thrum_error *error) {
  sweep->start_count =
      sweep->body_count * experiment_flag_count(sweep->starts, EXPERIMENT_START_COUNT);
  sweep->count = 0;

  // room for all schemes, whether asked for or not
  thrum_scope *memory = &sweep->memory;
  const int64_t all = sweep->start_count;
  const int64_t room = all * sweep->dt_count * EXPERIMENT_SCHEME_COUNT;
  *memory = thrum_scope_begin("the runs", error);
  sweep->cases = thrum_scope_allocate(memory, room, sizeof *sweep->cases);
  sweep->results = thrum_scope_allocate(memory, room, sizeof *sweep->results);
  sweep->smooth = thrum_scope_allocate(memory, sweep->body_count, sizeof *sweep->smooth);
  sweep->references = thrum_scope_allocate(memory, all, sizeof *sweep->references);
  sweep->impulses = thrum_scope_allocate(memory, all, sizeof *sweep->impulses);
  THRUM_TRY(memory->status);

  // the smooth start pushes the same body in another way
  for (int64_t b = 0; b < sweep->body_count; b++)
    THRUM_TRY(experiment_body_smooth(&sweep->bodies[b], &sweep->smooth[b], error));
  return THRUM_OK;
}

/* The same impulse for all time steps, so that the energy is the same. */
static void plan(experiment_sweep *sweep) {
  for (int64_t s = 0; s < sweep->start_count; s++) {
    experiment_start start;
    const experiment_body *body = find_start(sweep, s, &start);

    // cases by time step, then scheme, in the order of the tables
    for (int64_t k = 0; k < sweep->dt_count; k++) {
      for (int i = 0; i < EXPERIMENT_SCHEME_COUNT; i++) {
        if (!sweep->schemes[i])
          continue;
        sweep->cases[sweep->count++] = (experiment_sweep_case){
            .body = body,
            .reference = &sweep->references[s],
            .start = start,
            .scheme = (experiment_scheme)i,
            .impulse = sweep->impulses[s],
            .dt = sweep->dts[k],
        };
      }
    }
  }
}

static bool pass_progress(void *context, double fraction) {
  const experiment_sweep *sweep = context;
  return sweep->progress == NULL ||
         sweep->progress(sweep->progress_context,
                         ((double)sweep->round + fraction) / (double)sweep->rounds);
}

thrum_status experiment_sweep_run(experiment_sweep *sweep, thrum_error *error) {
  THRUM_TRY(allocate(sweep, error));
  thrum_thread_pool pool = {
      .threads = sweep->threads,
      .count = sweep->start_count,
      .task = make_reference,
      .context = sweep,
  };
  THRUM_TRY(thrum_thread_pool_run(&pool, error));
  plan(sweep);

  // in rounds, so that a time when the machine is busy falls on one run of each case
  pool.count = sweep->count;
  pool.task = run_index;
  pool.progress = pass_progress;
  pool.progress_context = sweep;
  for (sweep->round = 0; sweep->round < sweep->rounds; sweep->round++)
    THRUM_TRY(thrum_thread_pool_run(&pool, error));
  return THRUM_OK;
}

void experiment_sweep_free(experiment_sweep *sweep) {
  for (int64_t s = 0; sweep->references != NULL && s < sweep->start_count; s++)
    experiment_reference_free(&sweep->references[s]);
  for (int64_t b = 0; sweep->smooth != NULL && b < sweep->body_count; b++)
    experiment_body_free(&sweep->smooth[b]);
  thrum_scope_free(&sweep->memory);
}

bool experiment_sweep_flagged(const experiment_sweep *sweep) {
  bool flagged = false;
  for (int64_t n = 0; n < sweep->count; n++)
    flagged = flagged || ((sweep->results[n].status < 0 || sweep->results[n].lost) &&
                          experiment_scheme_keeps(sweep->cases[n].scheme));
  return flagged;
}
