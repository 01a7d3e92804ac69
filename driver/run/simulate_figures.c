/* The figures of a run: extremes of the energy and its drift over the first and the last tenth of
 * the rows after the last load has ended. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/simulate_figures.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define DRIFT_PARTS 10
#define WINDOW_ROWS_MIN 10  /* a mean over fewer is no mean */
#define GROWTH_FLAG 0.1     /* growth of the mean energy in free motion that flags the run */
#define SLIGHT 1e-3         /* work over energy up to which motion is free beside a load */
#define GAIN_FLAG 0.5       /* share of the largest energy that came from nowhere: the same */
#define INERTIA_FLAG 0.005  /* share of the kinetic energy left out by condensing: the same */
#define DEFECT_FLAG 0.02    /* share of the strain energy that condensing has wrong: the same */
#define IMPACT_FLAG 0.05    /* share of the motion that impacts on what follows set off: the same */
#define VIBRATION_FLAG 0.03 /* share of the motion that is vibration left out by it: the same */

/* The larger of `steps` and the number of steps in `time`. */
static int64_t later(int64_t steps, double time, double dt) {
  const int64_t other = thrum_step_count(time, dt);
  return other > steps ? other : steps;
}

/* The first row that no load acts on or after; INT64_MAX: none. */
static int64_t first_free_row(const simulate_request *request) {
  int64_t steps = 0;
  for (int64_t n = 0; n < request->load_count; n++)
    steps = later(steps, request->loads[n].course.until, request->def.dt);
  for (int64_t n = 0; n < request->actuate_count; n++)
    steps = later(steps, request->actuates[n].course.until, request->def.dt);
  for (int64_t n = 0; n < request->base_motion_count; n++)
    steps = later(steps, base_motion_end(&request->base_motions[n]), request->def.dt);
  if (steps > request->steps)
    return INT64_MAX;
  return (steps + request->record_every - 1) / request->record_every;
}

void simulate_figures_begin(simulate_figures *figures) {
  const simulate_request *request = figures->request;
  figures->energy_min = INFINITY;
  figures->energy_max = -INFINITY;
  const int64_t rows = request->steps / request->record_every + 1;
  figures->windows = driver_drift_plan(first_free_row(request), rows, DRIFT_PARTS, WINDOW_ROWS_MIN);
  figures->whole = driver_drift_plan(0, rows, DRIFT_PARTS, WINDOW_ROWS_MIN);
}

void simulate_figures_add(simulate_figures *figures, int64_t row, const thrum_energies *energies) {
  if (row == 0)
    figures->first = *energies;
  figures->last = *energies;
  figures->energy_min = fmin(figures->energy_min, energies->total);
  figures->energy_max = fmax(figures->energy_max, energies->total);
  if (row < 0)
    return;
  driver_drift_add(&figures->windows, row, energies->total);
  driver_drift_add(&figures->whole, row, energies->total);
}

/* Growth of the mean energy of a motion that loads have hardly touched; NaN where they have. */
static double growth_beside_loads(const simulate_figures *figures) {
  const driver_drift *whole = &figures->whole;
  const double energy = whole->first_sum / (double)(whole->last_end - whole->last_begin);
  return !figures->uncounted && figures->work_moved < SLIGHT * energy ? driver_drift_value(whole)
                                                                      : NAN;
}

double simulate_figures_balance(const simulate_figures *figures) {
  const double gained = figures->last.total - figures->first.total;
  return gained - figures->work_load - figures->work_base - figures->work_actuators +
         figures->dissipated;
}

bool simulate_condensed_believed(double inertia_share, double energy_defect, double vibration_share,
                                 double impact_share) {
  return !(inertia_share > INERTIA_FLAG || energy_defect > DEFECT_FLAG ||
           vibration_share > VIBRATION_FLAG || impact_share > IMPACT_FLAG);
}

void simulate_figures_end(simulate_figures *figures) {
  const thrum_state_def *def = &figures->request->def;
  const bool damped = def->damping_alpha > 0 || def->damping_beta > 0 ||
                      figures->plastic_work > 0 || damping_spec_given(&figures->request->modal);

  // damping and plastic flow lower the energy of free motion, so its change is no drift; growth it
  // is all the more
  figures->growth = driver_drift_value(&figures->windows);
  figures->drift = damped ? NAN : figures->growth;
  const double beside = isnan(figures->growth) ? growth_beside_loads(figures) : NAN;
  figures->grew_beside_loads = beside > GROWTH_FLAG;
  if (figures->grew_beside_loads) {
    figures->growth = beside;
    figures->windows = figures->whole;
  }
  figures->grew_freely = figures->growth > GROWTH_FLAG;
  figures->gained =
      !figures->uncounted && simulate_figures_balance(figures) > GAIN_FLAG * figures->energy_max;
  figures->energy_grew = figures->grew_freely || figures->gained || figures->report.grown_steps > 0;

  // the integrator manifold steps the inertia of what follows, and leaves none out
  const double left_out = def->integrator == THRUM_INTEGRATOR_MANIFOLD ? 0 : figures->inertia_share;
  figures->condensed_wrong =
      figures->masters > 0 && figures->request->monitor &&
      !simulate_condensed_believed(left_out, figures->energy_defect, figures->vibration_share,
                                   figures->impact_share);
}

void simulate_figures_stepped_by(const simulate_figures *figures, char text[128]) {
  const thrum_state_report *report = &figures->report;
  const char *name = thrum_integrator_name(figures->request->def.integrator);
  if (report->switched_steps == 0)
    snprintf(text, 128, "%s", name);
  else if (report->first_switch + report->switched_steps == report->steps)
    snprintf(text, 128, "%s, switched to energy after %" PRId64 " step%s", name,
             report->first_switch, report->first_switch == 1 ? "" : "s");
  else
    snprintf(text, 128, "%s, %" PRId64 " of %" PRId64 " steps by energy, the first after %" PRId64,
             name, report->switched_steps, report->steps, report->first_switch);
}

const char *run_outcome_word(run_outcome outcome) {
  static const char *const words[] = {
#define X(name, word) word,
      RUN_OUTCOMES(X)
#undef X
  };
  return words[outcome];
}

run_outcome simulate_outcome(const simulate_figures *figures) {
  if (figures->status >= 0 && figures->energy_grew)
    return RUN_ENERGY_GREW;
  if (figures->status == THRUM_OK && figures->condensed_wrong)
    return RUN_CONDENSED_WRONG;
  if (figures->status == THRUM_OK && figures->basis_wrong)
    return RUN_BASIS_WRONG;

  // otherwise the last status of the stepper says why the run ended
  switch (figures->status) {
  case THRUM_OK:
    return RUN_DONE;
  case THRUM_FELL_BACK:
    return RUN_FELL_BACK;
  case THRUM_NOT_CONVERGED:
    return RUN_NOT_CONVERGED;
  case THRUM_NOT_FINITE:
    return RUN_NOT_FINITE;
  case THRUM_INTERRUPTED:
    return RUN_INTERRUPTED;
  default:
    return RUN_FAILED;
  }
}
