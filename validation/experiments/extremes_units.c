/* One body in other units: nothing may depend on them but the last digits.
 *
 * Lengths are divided by the unit of length, E by mass/(length time^2), density by mass/length^3,
 * the time step by the unit of time. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "validation/experiments/extremes.h"

/* Where the pulled part is, over the body's length, step by step. */
typedef struct track {
  double *displacement; /* steps x 3 */
  thrum_state_report report;
} track;

static experiment_extreme in_units(const experiment_extreme *extreme,
                                   const experiment_units *units) {
  experiment_extreme other = *extreme;
  for (int axis = 0; axis < 3; axis++)
    other.size[axis] /= units->length;
  other.material.young *= units->length * units->time * units->time / units->mass;
  other.material.density *= units->length * units->length * units->length / units->mass;
  other.dt /= units->time;
  return other;
}

static thrum_status follow(const experiment_extreme *extreme, experiment_scheme scheme,
                           int64_t steps, track *seen, thrum_error *error) {
  experiment_extreme_body made = {0};
  thrum_state *state = NULL;
  double q[THRUM_RANK_MAX];
  thrum_status status = experiment_extreme_make(extreme, &made, error);
  if (status >= 0 && made.status < 0)
    status = thrum_error_set(error, made.status, "%s", made.refusal.message);

  // at rest under a load that is taken away half-way
  const thrum_state_def def = experiment_scheme_def(scheme, made.dt);
  THRUM_THEN(status, thrum_state_create(made.body.model, &def, &state, error));
  for (int64_t i = 0; status >= 0 && i < made.body.model->rank; i++)
    q[i] = made.force * made.body.push[i];
  THRUM_THEN(status, thrum_state_set_force(made.body.model, state, q, error));

  // the displacement as a share of the length has no unit, so that it can be compared
  for (int64_t n = 0; n < steps && status >= 0; n++) {
    const int64_t rank = made.body.model->rank;
    if (n == (steps + 1) / 2)
      status = thrum_state_set_force(made.body.model, state, NULL, error);
    THRUM_THEN(status, thrum_step(made.body.model, state, error));
    THRUM_THEN(status, thrum_state_get(made.body.model, state, q, NULL, error));
    for (int axis = 0; axis < 3 && status >= 0; axis++) {
      double sum = 0;
      for (int64_t i = 0; i < rank; i++)
        sum += made.body.tip[axis * rank + i] * q[i];
      seen->displacement[3 * n + axis] = sum / made.body.length;
    }
  }

  // the levels must be the same too
  if (status >= 0)
    seen->report = thrum_state_report_get(state);
  thrum_state_destroy(state);
  experiment_extreme_free(&made);
  return status;
}

static void compare(const track *si, const track *other, int64_t steps,
                    experiment_unit_result *result) {
  double largest = 0, difference = 0;
  for (int64_t n = 0; n < 3 * steps; n++) {
    largest = fmax(largest, fabs(si->displacement[n]));
    difference = fmax(difference, fabs(si->displacement[n] - other->displacement[n]));
  }

  // no decision of a step may depend on the units
  const thrum_state_report *a = &si->report, *b = &other->report;
  *result = (experiment_unit_result){
      .difference = difference / largest,
      .iterations = b->iterations,
      .iterations_si = a->iterations,
      .same_levels =
          a->newton_steps == b->newton_steps && a->energy_steps == b->energy_steps &&
          a->substep_steps == b->substep_steps && a->switched_steps == b->switched_steps &&
          a->split_changes == b->split_changes && a->scheme_switches == b->scheme_switches &&
          a->explicit_modes == b->explicit_modes,
  };
}

thrum_status experiment_units_run(const experiment_unit_case *run, experiment_unit_result *result,
                                  thrum_error *error) {
  const experiment_extreme other = in_units(run->extreme, run->units);
  track tracks[2] = {{0}};
  thrum_status status = THRUM_OK;

  // the same run twice, in SI and in the other units
  for (int n = 0; n < 2 && status >= 0; n++) {
    tracks[n].displacement = calloc((size_t)(3 * run->steps + 1), sizeof *tracks[n].displacement);
    status =
        tracks[n].displacement == NULL
            ? thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the steps")
            : follow(n == 0 ? run->extreme : &other, run->scheme, run->steps, &tracks[n], error);
  }

  // the largest difference counts, relative to the largest displacement
  if (status >= 0)
    compare(&tracks[0], &tracks[1], run->steps, result);
  for (int n = 0; n < 2; n++)
    free(tracks[n].displacement);
  return status;
}
