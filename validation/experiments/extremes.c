/* Runs the extremes: how each of them comes out, and how well the energy balances.
 *
 * From rest under a constant load f the energy is the work f q; after the load it stays. So the
 * largest |E - f q| needs no reference run. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/extremes.h"

#include <math.h>
#include <stdlib.h>

#include "core/base/finite.h"
#include "platform/clock.h"
#include "validation/experiments/run_outcome.h"

#define LOST 1.0 /* of the work: whatever is left then is no energy balance */

/* The energy balance of a run so far. */
typedef struct balance {
  double force[THRUM_RANK_MAX];
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  double work;    /* of the load so far [J] */
  double largest; /* |work| [J] */
  double worst;   /* |E - work| [J] */
  double last;    /* the same now [J] */
} balance;

static thrum_status look(const experiment_body *body, thrum_state *state, bool loaded,
                         balance *seen, experiment_extreme_result *result, thrum_error *error) {
  const thrum_model *model = body->model;
  thrum_energies energies;
  THRUM_TRY(thrum_state_get(model, state, seen->q, seen->p, error));
  THRUM_TRY(thrum_state_energies(model, state, &energies, error));
  result->not_finite = result->not_finite || !thrum_all_finite(seen->q, model->rank) ||
                       !thrum_all_finite(seen->p, model->rank) || !isfinite(energies.total);

  // under a constant load the work is f q, whatever the way there
  if (loaded) {
    seen->work = 0;
    for (int64_t i = 0; i < model->rank; i++)
      seen->work += seen->force[i] * seen->q[i];
  }

  // what the energy differs from it by
  seen->largest = fmax(seen->largest, fabs(seen->work));
  seen->last = fabs(energies.total - seen->work);
  seen->worst = fmax(seen->worst, seen->last);
  result->peak_amplitude = fmax(result->peak_amplitude, experiment_body_amplitude(body, seen->q));
  return THRUM_OK;
}

/* One half of the run: with the load, or without. */
static thrum_status run_half(const experiment_extreme_case *run, thrum_state *state, bool loaded,
                             int64_t steps, balance *seen, experiment_extreme_result *result,
                             double *seconds) {
  const experiment_body *body = &run->body->body;
  thrum_status status =
      thrum_state_set_force(body->model, state, loaded ? seen->force : NULL, &result->stop);
  for (int64_t n = 0; n < steps && status >= 0; n++) {
    const double began = clock_thread_seconds();
    status = thrum_step(body->model, state, &result->stop);
    *seconds += clock_thread_seconds() - began;
    THRUM_THEN(status, look(body, state, loaded, seen, result, &result->stop));
  }
  return status;
}

thrum_status experiment_extreme_run(const experiment_extreme_case *run,
                                    experiment_extreme_result *result, thrum_error *error) {
  const experiment_extreme_body *of = run->body;
  experiment_extreme_result made = {
      .status = of->status, .stop = of->refusal, .energy_error = NAN, .energy_end = NAN};
  if (of->status < 0) {
    *result = made;
    return THRUM_OK;
  }

  // this scheme at the step of the body, with the margin of the split that the case asks for
  thrum_state_def def = experiment_scheme_def(run->scheme, of->dt);
  thrum_state *state = NULL;
  balance *seen = calloc(1, sizeof *seen);
  if (of->extreme->split_safety > 0)
    def.split_safety = of->extreme->split_safety;
  thrum_status status = seen == NULL
                            ? thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a run")
                            : thrum_state_create(of->body.model, &def, &state, error);
  if (status < 0) {
    free(seen);
    return status;
  }

  // half of the steps with the load, half without: both balances are looked at
  for (int64_t i = 0; i < of->body.model->rank; i++)
    seen->force[i] = of->force * of->body.push[i];
  double seconds = 0;
  const int64_t half = (run->steps + 1) / 2;
  status = run_half(run, state, true, half, seen, &made, &seconds);
  THRUM_THEN(status, run_half(run, state, false, run->steps - half, seen, &made, &seconds));

  // a run that stopped is a result as well
  made.status = status < 0 ? status : THRUM_OK;
  made.report = thrum_state_report_get(state);
  made.us_per_step = 1e6 * seconds / (double)made.report.steps;
  made.work = seen->largest;
  if (seen->largest > 0 || seen->worst > 0) {
    made.energy_error = seen->worst / seen->largest;
    made.energy_end = seen->last / seen->largest;
  }
  thrum_state_destroy(state);
  free(seen);
  *result = made;
  return THRUM_OK;
}

const char *experiment_extreme_outcome(const experiment_extreme_case *run,
                                       const experiment_extreme_result *result) {
  // from the last resort to the first
  static const int fallback_levels[] = {EXPERIMENT_LEVEL_substep, EXPERIMENT_LEVEL_energy,
                                        EXPERIMENT_LEVEL_switched, EXPERIMENT_LEVEL_newton};

  // what ended the run comes before how it was stepped
  if (run->body->status < 0)
    return "refused";
  if (result->not_finite)
    return "not_finite";
  if (result->status < 0)
    return "stopped";
  if (result->energy_end > LOST)
    return "lost";

  // the last resort that was needed
  for (size_t n = 0; n < sizeof fallback_levels / sizeof fallback_levels[0]; n++)
    if (experiment_level(&result->report, fallback_levels[n]) > 0)
      return experiment_level_names[fallback_levels[n]];
  return "runs";
}
