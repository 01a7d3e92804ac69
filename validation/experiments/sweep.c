/* The sweep over time steps: the same impulse, the same time, another step.
 *
 * The energy of an undamped body is what the impulse gave it, 1/2 |p|^2, whatever the step: so its
 * error needs no reference run. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/sweep.h"

#include <math.h>
#include <stdlib.h>

#include "validation/experiments/tables.h"

#define LOOKS 1000
#define LOST 1.0 /* of the energy: gained by then, nothing of the motion is left */

/* What is seen at one moment. */
static thrum_status look(const experiment_sweep_case *run, thrum_state *state, bool late,
                         experiment_sweep_result *result, double *late_sum, thrum_error *error) {
  double q[THRUM_RANK_MAX];
  thrum_energies energies;
  thrum_status status = thrum_state_get(run->body->model, state, q, NULL, error);
  if (status >= 0)
    status = thrum_state_energies(run->body->model, state, &energies, error);
  if (status < 0)
    return status;
  const double difference = (energies.total - result->energy) / result->energy;
  result->energy_error = fmax(result->energy_error, fabs(difference));
  result->peak_amplitude = fmax(result->peak_amplitude, experiment_body_amplitude(run->body, q));
  if (late)
    *late_sum += difference;
  return THRUM_OK;
}

thrum_status experiment_sweep_run(const experiment_sweep_case *run, experiment_sweep_result *result,
                                  thrum_error *error) {
  const thrum_model *model = run->body->model;
  const int64_t stride = run->steps > LOOKS ? run->steps / LOOKS : 1;
  experiment_sweep_result made = {0};
  thrum_state *state = NULL;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = experiment_integrators[run->integrator];
  def.dt = run->dt;
  thrum_status status = thrum_state_create(model, &def, &state, error);
  if (status < 0)
    return status;
  double seconds = 0, late_sum = 0;
  int64_t late_count = 0;
  status = experiment_kick(run->body, run->impulse, state, &made.energy, &made.stop);
  for (int64_t step = 0; step < run->steps && status >= 0;) {
    const int64_t until = step + stride < run->steps ? step + stride : run->steps;
    const double began = experiment_seconds();
    for (; step < until && status >= 0; step++)
      status = thrum_step(model, state, &made.stop);
    seconds += experiment_seconds() - began;
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

const char *experiment_sweep_status(const experiment_sweep_result *result) {
  return result->lost ? "lost" : experiment_status_name(result->status);
}
