/* The matrix of experiments: the forces that are called for, then the runs, both over threads.
 *
 * The runs of one body, load and damping follow each other on one thread, so that their times can
 * be set against each other. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/matrix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driver/run/drift.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/external_load.h"
#include "validation/experiments/run_outcome.h"

#define DRIFT_PARTS 10
#define FORCE_TRIES 16
#define FORCE_OVERSHOOT                                                                            \
  1.5                    /* a force may bend the body further than asked for, but not by more      \
                          */
#define FORCE_MARGIN 1.1 /* another scheme may swing a little less */
#define CALIBRATE_SECONDS                                                                          \
  6.0 /* a load that ends has its peak by then; a sine takes the whole run */

const char *const experiment_load_names[EXPERIMENT_LOAD_COUNT] = {
#define X(name, shape, until, frequency, amplitude) #name,
    EXPERIMENT_LOAD_LIST(X)
#undef X
};

static const thrum_load courses[EXPERIMENT_LOAD_COUNT] = {
#define X(name, kind, end, rate, amplitude) {.shape = kind, .until = end, .frequency = rate},
    EXPERIMENT_LOAD_LIST(X)
#undef X
};

static const double amplitudes[EXPERIMENT_LOAD_COUNT] = {
#define X(name, shape, until, frequency, amplitude) amplitude,
    EXPERIMENT_LOAD_LIST(X)
#undef X
};

const double experiment_dampings[EXPERIMENT_DAMPING_COUNT] = {0, 0.3};

/* Shared by the tasks. forces, and the most energy under each: body_count x EXPERIMENT_LOAD_COUNT.
 */
typedef struct matrix_work {
  const experiment_matrix *matrix;
  double *forces, *energies;
  experiment_run *runs;
  double progress_begin, progress_share; /* of the present stage */
} matrix_work;

/* Index of the n-th flag that is set. */
static int nth_true(const bool *flags, int64_t n) {
  int index = 0;
  while (!flags[index] || n-- > 0)
    index++;
  return index;
}

int64_t experiment_matrix_count(const experiment_matrix *matrix) {
  return matrix->body_count * experiment_flag_count(matrix->loads, EXPERIMENT_LOAD_COUNT) *
         matrix->damping_count * matrix->dt_count *
         experiment_flag_count(matrix->schemes, EXPERIMENT_SCHEME_COUNT);
}

/* A row of the present moment. */
static thrum_status record(experiment_run *run, thrum_state *state, double time,
                           experiment_row *row, thrum_error *error) {
  double q[THRUM_RANK_MAX];
  thrum_energies energies;
  THRUM_TRY(thrum_state_get(run->body->model, state, q, NULL, error));
  THRUM_TRY(thrum_state_energies(run->body->model, state, &energies, error));

  // a row without state is what the tables and curves are made from
  *row = (experiment_row){
      .time = time,
      .total = energies.total,
      .high = energies.high,
      .explicit_modes = (double)thrum_state_report_get(state).explicit_modes,
      .amplitude = experiment_body_amplitude(run->body, q),
  };

  // a run with ten times the energy it should have ends; its peaks mean nothing
  run->lost = energies.total > EXPERIMENT_LOST * run->energy_known;
  if (run->lost)
    return THRUM_OK;
  run->energy_peak = fmax(run->energy_peak, energies.total);
  run->peak_amplitude = fmax(run->peak_amplitude, row->amplitude);
  return THRUM_OK;
}

/* Steps `step` to `until`; *seconds grows by what they took. */
static thrum_status advance(experiment_run *run, thrum_state *state, int64_t step, int64_t until,
                            double *seconds, thrum_error *error) {
  const thrum_model *model = run->body->model;
  double force[THRUM_RANK_MAX];
  thrum_status status = THRUM_OK;
  const double began = clock_thread_seconds();
  for (; step < until && status >= 0; step++) {
    const double strength = run->force * thrum_load_mean(&courses[run->load], step, run->dt);
    for (int64_t i = 0; i < model->rank; i++)
      force[i] = strength * run->body->push[i];
    status = thrum_state_set_force(model, state, force, error);
    THRUM_THEN(status, thrum_step(model, state, error));
  }
  *seconds += clock_thread_seconds() - began;
  return status;
}

/* Drift over the rows that no load acts on, by tenths as `thrum simulate` has it. */
static double energy_change(const experiment_run *run) {
  int64_t first = 0;
  if (run->alpha > 0 || run->status < 0 || run->lost)
    return NAN;
  while (first < run->row_count && run->rows[first].time < courses[run->load].until)
    first++;
  driver_drift drift = driver_drift_plan(first, run->row_count, DRIFT_PARTS, 1);

  // the committed results sum the last tenth from its end
  for (int64_t n = drift.first_begin; n < drift.first_end; n++)
    driver_drift_add(&drift, n, run->rows[n].total);
  for (int64_t n = drift.last_end - 1; n >= drift.last_begin; n--)
    driver_drift_add(&drift, n, run->rows[n].total);
  return driver_drift_value(&drift);
}

/* The whole of one run, with its rows. */
static thrum_status perform(const experiment_matrix *matrix, experiment_run *run, double time,
                            thrum_error *error) {
  const int64_t steps = thrum_step_count(time, run->dt) > 1 ? thrum_step_count(time, run->dt) : 1;
  const int64_t sparse = steps > matrix->row_count ? steps / matrix->row_count : 1;
  const int64_t narrow = thrum_step_count(EXPERIMENT_DENSE_SECONDS, run->dt);
  const int64_t narrow_until = thrum_step_count(matrix->dense, run->dt);
  double seconds = 0;
  thrum_state *state = NULL;
  thrum_state_def def = experiment_scheme_def(run->scheme, run->dt);
  def.damping_alpha = run->alpha;

  THRUM_TRY(thrum_reserve(&run->rows, steps / sparse + narrow_until / narrow + 3, sizeof *run->rows,
                          "the rows of a run", error));
  THRUM_TRY(thrum_state_create(run->body->model, &def, &state, error));

  // the first row is the rest; a step that fails, or an energy far too large, ends the run
  thrum_status status = record(run, state, 0, &run->rows[run->row_count++], &run->stop);
  for (int64_t step = 0; step < steps && status >= 0 && !run->lost;) {
    const int64_t stride = step < narrow_until && narrow < sparse ? narrow : sparse;
    const int64_t until = step + stride < steps ? step + stride : steps;
    status = advance(run, state, step, until, &seconds, &run->stop);
    step = until;
    THRUM_THEN(status,
               record(run, state, (double)step * run->dt, &run->rows[run->row_count], &run->stop));
    run->row_count += status >= 0 && !run->lost;
  }

  run->status = status < 0 ? status : THRUM_OK;
  run->report = thrum_state_report_get(state);
  run->simulated = (double)run->report.steps * run->dt;
  run->us_per_step = 1e6 * seconds / (double)run->report.steps;
  run->mean_iterations = (double)run->report.iterations / (double)run->report.steps;
  run->energy_end = run->row_count > 0 ? run->rows[run->row_count - 1].total : NAN;
  run->high_end = run->row_count > 0 ? run->rows[run->row_count - 1].high : NAN;
  run->energy_change = energy_change(run);
  thrum_state_destroy(state);
  return THRUM_OK;
}

/* The next larger number of two digits. */
static double round_up(double value) {
  const double unit = pow(10, floor(log10(value)) - 1);
  return ceil(value / unit - 1e-9) * unit;
}

/* Runs a trial; its rows are not kept. */
static thrum_status bend(const experiment_matrix *matrix, experiment_run *trial,
                         thrum_error *error) {
  const bool ends = trial->load != EXPERIMENT_LOAD_sine;
  const thrum_status status =
      perform(matrix, trial, ends ? fmin(matrix->time, CALIBRATE_SECONDS) : matrix->time, error);
  free(trial->rows);
  trial->rows = NULL;
  return status;
}

/* One body, one load: the force. */
static thrum_status find_force(void *context, int64_t index, thrum_error *error) {
  matrix_work *work = context;
  const experiment_matrix *matrix = work->matrix;
  const experiment_load load = (experiment_load)(index % EXPERIMENT_LOAD_COUNT);
  const experiment_body *body = &matrix->bodies[index / EXPERIMENT_LOAD_COUNT];
  if (!matrix->loads[load])
    return THRUM_OK;

  const double wanted = FORCE_MARGIN * amplitudes[load];
  const double spring = 1 / body->compliance, rate = sqrt(body->model->omega2[0]);
  // as if the body were one spring: half of what bends it that far, at rest or by an impulse
  double force = round_up(0.5 * wanted * body->length * spring);
  if (load == EXPERIMENT_LOAD_impulse)
    force = round_up(force / (rate * courses[load].until));
  double low = 0, high = INFINITY;

  // each trial is a run with `energy`; the last force tried is kept
  for (int n = 0; n < FORCE_TRIES; n++) {
    experiment_run trial = {
        .body = body,
        .load = load,
        .force = force,
        .dt = matrix->dts[0],
        .scheme = EXPERIMENT_SCHEME_ENERGY,
        .energy_known = INFINITY,
    };
    THRUM_TRY(bend(matrix, &trial, error));
    const double amplitude = trial.peak_amplitude;
    work->forces[index] = force;
    work->energies[index] = trial.energy_peak;
    if (amplitude >= wanted && amplitude <= FORCE_OVERSHOOT * wanted)
      break;

    if (amplitude < wanted)
      low = force;
    else
      high = force;

    // resonance makes the way there uneven: bisect once both sides are known
    double factor = wanted / fmax(amplitude, 1e-3 * wanted);
    factor = fmin(fmax(factor * 1.1, 0.25), 4);
    force = isfinite(high) && low > 0 ? 0.5 * (low + high) : round_up(force * factor);
    if (!(force > low))
      force = round_up(1.1 * low);
  }
  return THRUM_OK;
}

/* One body, load and damping: its runs, one after the other. */
static thrum_status run_group(void *context, int64_t index, thrum_error *error) {
  matrix_work *work = context;
  const experiment_matrix *matrix = work->matrix;
  const int64_t loads = experiment_flag_count(matrix->loads, EXPERIMENT_LOAD_COUNT);
  const int64_t schemes = experiment_flag_count(matrix->schemes, EXPERIMENT_SCHEME_COUNT);
  const int64_t width = matrix->dt_count * schemes;
  const int64_t body = index / matrix->damping_count / loads;
  const int load = nth_true(matrix->loads, index / matrix->damping_count % loads);

  // the index counts by body, load and damping, the last fastest
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < width && status >= 0; n++) {
    experiment_run *run = &work->runs[index * width + n];
    run->body = &matrix->bodies[body];
    run->load = (experiment_load)load;
    run->force = work->forces[body * EXPERIMENT_LOAD_COUNT + load];
    run->energy_known = work->energies[body * EXPERIMENT_LOAD_COUNT + load];
    run->alpha = experiment_dampings[index % matrix->damping_count];
    run->dt = matrix->dts[n / schemes];
    run->scheme = (experiment_scheme)nth_true(matrix->schemes, n % schemes);
    status = perform(matrix, run, matrix->time, error);
  }
  return status;
}

static bool pass_progress(void *context, double fraction) {
  const matrix_work *work = context;
  const experiment_matrix *matrix = work->matrix;
  return matrix->progress == NULL ||
         matrix->progress(matrix->progress_context,
                          work->progress_begin + fraction * work->progress_share);
}

thrum_status experiment_matrix_run(const experiment_matrix *matrix, experiment_run *runs,
                                   thrum_error *error) {
  const int64_t count = experiment_matrix_count(matrix);
  const int64_t schemes = experiment_flag_count(matrix->schemes, EXPERIMENT_SCHEME_COUNT);
  memset(runs, 0, (size_t)count * sizeof *runs);
  matrix_work work = {.matrix = matrix, .runs = runs, .progress_share = 0.5};

  // forces and energies, one for each body and load
  const size_t forces = (size_t)(matrix->body_count * EXPERIMENT_LOAD_COUNT + 1);
  THRUM_TRY(thrum_reserve(&work.forces, 2 * forces, sizeof *work.forces, "the forces", error));
  work.energies = work.forces + forces;

  // first the forces, which the runs take
  thrum_thread_pool pool = {
      .threads = matrix->threads,
      .count = matrix->body_count * EXPERIMENT_LOAD_COUNT,
      .task = find_force,
      .progress = pass_progress,
      .context = &work,
      .progress_context = &work,
  };
  thrum_status status = thrum_thread_pool_run(&pool, error);

  // then the runs, a body, load and damping at a time, so that these share a thread
  work.progress_begin = 0.5;
  pool.count = count > 0 ? count / matrix->dt_count / schemes : 0;
  pool.task = run_group;
  THRUM_THEN(status, thrum_thread_pool_run(&pool, error));
  free(work.forces);
  return status;
}

void experiment_runs_free(experiment_run *runs, int64_t count) {
  for (int64_t n = 0; n < count; n++)
    free(runs[n].rows);
  free(runs);
}

bool experiment_runs_flagged(const experiment_run *runs, int64_t count) {
  bool flagged = false;
  for (int64_t n = 0; n < count; n++)
    flagged = flagged ||
              ((runs[n].status < 0 || runs[n].lost) && experiment_scheme_keeps(runs[n].scheme));
  return flagged;
}
