/* The sweep over time steps: the same impulse, the same time, another step.
 *
 * The energy of an undamped body is what the impulse gave it, 1/2 |p|^2, whatever the step: so its
 * error needs no reference run. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/sweep.h"

#include <math.h>
#include <stdlib.h>

#include "platform/clock.h"
#include "validation/experiments/run_outcome.h"

#define LOOKS 1000
#define IMPULSE_DT 0.003 /* time step at which the impulse is found [s] */
#define LOST 1.0         /* of the energy: gained by then, nothing of the motion is left */

static const double dts[] = {
    EXPERIMENT_SWEEP_SHORTEST, 3e-4, 1e-3, 3e-3, 5e-3, 0.01, 0.02, 0.05}; /* [s] */
enum { DT_COUNT = sizeof dts / sizeof dts[0] };

/* Updates the energy error and the peak amplitude from the present state. */
static thrum_status look(const experiment_sweep_case *run, thrum_state *state, bool late,
                         experiment_sweep_result *result, double *late_sum, thrum_error *error) {
  double q[THRUM_RANK_MAX];
  thrum_energies energies;
  THRUM_TRY(thrum_state_get(run->body->model, state, q, NULL, error));
  THRUM_TRY(thrum_state_energies(run->body->model, state, &energies, error));

  // relative to the energy that the kick gave
  const double difference = (energies.total - result->energy) / result->energy;
  result->energy_error = fmax(result->energy_error, fabs(difference));
  result->peak_amplitude = fmax(result->peak_amplitude, experiment_body_amplitude(run->body, q));
  if (late)
    *late_sum += difference;
  return THRUM_OK;
}

/* One case, from the kick to the end of its time. A step that fails ends it and is in its result.
 */
static thrum_status run_case(const experiment_sweep_case *run, experiment_sweep_result *result,
                             thrum_error *error) {
  const thrum_model *model = run->body->model;
  const int64_t stride = run->steps > LOOKS ? run->steps / LOOKS : 1;
  experiment_sweep_result made = {0};
  thrum_state *state = NULL;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = experiment_integrators[run->integrator];
  def.dt = run->dt;
  THRUM_TRY(thrum_state_create(model, &def, &state, error));

  // only the steps are timed, not the looks between them
  double seconds = 0, late_sum = 0;
  int64_t late_count = 0;
  thrum_status status = experiment_kick(run->body, run->impulse, state, &made.energy, &made.stop);
  for (int64_t step = 0; step < run->steps && status >= 0;) {
    const int64_t until = step + stride < run->steps ? step + stride : run->steps;
    const double began = clock_thread_seconds();
    for (; step < until && status >= 0; step++)
      status = thrum_step(model, state, &made.stop);
    seconds += clock_thread_seconds() - began;

    // the last tenth gives the change of the mean energy
    const bool late = 10 * step >= 9 * run->steps;
    if (status >= 0)
      status = look(run, state, late, &made, &late_sum, &made.stop);
    late_count += late && status >= 0;
  }

  made.status = status < 0 ? status : THRUM_OK;
  made.report = thrum_state_report_get(state);
  made.simulated = (double)made.report.steps * run->dt;
  made.us_per_step = 1e6 * seconds / (double)made.report.steps;
  made.energy_change = made.status == THRUM_OK ? late_sum / (double)late_count : NAN;
  made.lost = made.energy_change > LOST;
  thrum_state_destroy(state);
  *result = made;
  return THRUM_OK;
}

static thrum_status run_index(void *context, int64_t index, thrum_error *error) {
  experiment_sweep *sweep = context;
  return run_case(&sweep->cases[index], &sweep->results[index], error);
}

/* The cases, with the impulse of each body. */
static thrum_status plan(experiment_sweep *sweep, thrum_error *error) {
  for (int64_t b = 0; b < sweep->body_count; b++) {
    const experiment_body *body = &sweep->bodies[b];
    double impulse = 0, reached = 0;
    THRUM_TRY(experiment_impulse(body, sweep->amplitude, IMPULSE_DT, &impulse, &reached, error));

    // the same impulse for all time steps, so that the energy is the same
    for (int k = 0; k < DT_COUNT; k++) {
      const int64_t steps = thrum_step_count(sweep->time, dts[k]);
      for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
        if (!sweep->integrators[i])
          continue;
        sweep->cases[sweep->count++] = (experiment_sweep_case){
            .body = body,
            .integrator = (experiment_integrator)i,
            .impulse = impulse,
            .dt = dts[k],
            .steps = steps < 1 ? 1 : steps,
        };
      }
    }
  }
  return THRUM_OK;
}

thrum_status experiment_sweep_run(experiment_sweep *sweep, thrum_error *error) {
  const size_t room = (size_t)sweep->body_count * DT_COUNT * EXPERIMENT_INTEGRATOR_COUNT + 1;
  sweep->count = 0;
  sweep->cases = calloc(room, sizeof *sweep->cases);
  sweep->results = calloc(room, sizeof *sweep->results);
  if (sweep->cases == NULL || sweep->results == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");

  // the number of cases is known only once they are planned
  THRUM_TRY(plan(sweep, error));
  const thrum_thread_pool pool = {
      .threads = sweep->threads,
      .count = sweep->count,
      .task = run_index,
      .progress = sweep->progress,
      .context = sweep,
      .progress_context = sweep->progress_context,
  };
  return thrum_thread_pool_run(&pool, error);
}

void experiment_sweep_free(experiment_sweep *sweep) {
  free(sweep->cases);
  free(sweep->results);
  sweep->cases = NULL;
  sweep->results = NULL;
  sweep->count = 0;
}

bool experiment_sweep_flagged(const experiment_sweep *sweep) {
  bool flagged = false;
  for (int64_t n = 0; n < sweep->count; n++)
    flagged = flagged || sweep->results[n].status < 0 ||
              (sweep->results[n].lost && sweep->cases[n].integrator != EXPERIMENT_newmark);
  return flagged;
}

const char *experiment_sweep_status(const experiment_sweep_result *result) {
  return result->lost ? "lost" : experiment_status_name(result->status);
}
