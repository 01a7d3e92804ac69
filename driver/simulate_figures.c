/* The figures of a run: extremes of the energy and its drift.
 *
 * Drift is the relative change of the mean total energy from the first to the last tenth of the
 * rows after the last load has ended, in a run without damping: only there should it be zero.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "driver/simulate_report.h"

#define WINDOW_ROWS_MIN 10 /* a mean over fewer is no mean */
#define GROWTH_FLAG 0.1    /* a drift beyond this flags the run */

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
  for (int64_t n = 0; n < request->base_motion_count; n++)
    steps = later(steps, cli_base_motion_end(&request->base_motions[n]), request->def.dt);
  if (steps > request->steps)
    return INT64_MAX;
  return (steps + request->record_every - 1) / request->record_every;
}

void simulate_figures_begin(simulate_figures *figures) {
  const simulate_request *request = figures->request;
  const int64_t rows = request->steps / request->record_every + 1;
  const int64_t free_row = first_free_row(request);
  figures->energy_min = INFINITY;
  figures->energy_max = -INFINITY;
  figures->windows = (simulate_drift){0};
  const bool damped = request->def.damping_alpha > 0 || request->def.damping_beta > 0;
  if (damped || free_row >= rows)
    return;
  const int64_t width = (rows - free_row) / 10;
  if (width < WINDOW_ROWS_MIN)
    return;
  figures->windows.first_begin = free_row;
  figures->windows.first_end = free_row + width;
  figures->windows.last_begin = rows - width;
  figures->windows.last_end = rows;
}

void simulate_figures_add(simulate_figures *figures, int64_t row, const thrum_energies *energies) {
  simulate_drift *windows = &figures->windows;
  if (row == 0)
    figures->first = *energies;
  figures->last = *energies;
  figures->energy_min = fmin(figures->energy_min, energies->total);
  figures->energy_max = fmax(figures->energy_max, energies->total);
  if (row < 0)
    return;
  if (row >= windows->first_begin && row < windows->first_end) {
    windows->first_sum += energies->total;
    windows->first_count++;
  }
  if (row >= windows->last_begin && row < windows->last_end) {
    windows->last_sum += energies->total;
    windows->last_count++;
  }
}

void simulate_figures_end(simulate_figures *figures) {
  const thrum_state_def *def = &figures->request->def;
  const bool damped = def->damping_alpha > 0 || def->damping_beta > 0;
  // what the full order loses is not counted
  if ((def->damping_form == THRUM_DAMPING_TANGENT && def->damping_beta > 0) ||
      (figures->request->full && damped))
    figures->dissipated = NAN;
  const simulate_drift *windows = &figures->windows;
  const int64_t width = windows->last_end - windows->last_begin;
  figures->drift = NAN;
  // a run that ended early has no last tenth, a body at rest no energy to compare with
  if (width > 0 && windows->last_count == width && windows->first_sum > 0)
    figures->drift = (windows->last_sum - windows->first_sum) / windows->first_sum;
  figures->energy_grew = figures->drift > GROWTH_FLAG;
}
