/* The report of the sweep over time steps. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/experiments/report.h"

typedef enum sweep_figure { ENERGY_ERROR, ITERATIONS, FIGURE_COUNT } sweep_figure;

static double figure_of(const study_sweep_result *result, sweep_figure figure) {
  if (figure == ENERGY_ERROR)
    return result->status == THRUM_OK && !result->lost ? result->energy_error : NAN;
  return (double)result->report.iterations / (double)result->report.steps;
}

/* One figure over the time steps, for the `count` cases of one body. */
static void add_panel(study_text *text, const study_sweep_case *cases,
                      const study_sweep_result *results, int64_t count, sweep_figure figure) {
  static const char *const labels[FIGURE_COUNT] = {"largest relative error of the energy",
                                                   "iterations a step"};
  char title[96];
  double *data = malloc((size_t)(2 * count * STUDY_INTEGRATOR_COUNT) * sizeof *data);
  study_plot plot = {.title = title,
                     .x_label = "time step [s]",
                     .y_label = labels[figure],
                     .width = 560,
                     .height = 260,
                     .log_x = true,
                     .log_y = figure == ENERGY_ERROR,
                     .from_zero = true};
  snprintf(title, sizeof title, "%s", cases->body->name);
  if (data == NULL) {
    text->failed = true;
    return;
  }
  for (int i = 0; i < STUDY_INTEGRATOR_COUNT; i++) {
    double *x = data + 2 * count * i, *y = x + count;
    int64_t points = 0;
    for (int64_t n = 0; n < count; n++) {
      if (cases[n].integrator != (study_integrator)i)
        continue;
      x[points] = cases[n].dt;
      y[points++] = figure_of(&results[n], figure);
    }
    if (points > 0)
      plot.series[plot.series_count++] =
          (study_series){study_integrator_names[i], study_colors[i], x, y, points, true};
  }
  study_plot_add(text, &plot);
  free(data);
}

static void add_table(study_text *text, const study_sweep_case *cases,
                      const study_sweep_result *results, int64_t count) {
  study_text_add(text, "<table>\n<tr><th>model<th>h [s]<th class=l>integrator<th>time [s]<th "
                       "class=l>completes<th>µs a "
                       "step<th>iterations<th>energy error<th>change<th>amplitude");
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, "<th>%s", study_rung_headings[n]);
  for (int64_t n = 0; n < count; n++) {
    const study_sweep_result *result = &results[n];
    study_text_add(text, "\n<tr><td>%s<td>%g<td class=l style='color:%s'>%s", cases[n].body->name,
                   cases[n].dt, study_colors[cases[n].integrator],
                   study_integrator_names[cases[n].integrator]);
    study_cell(text, "%.4g", result->simulated);
    if (result->status != THRUM_OK || result->lost)
      study_text_add(text, "<td class='l bad'>%s", study_sweep_status(result));
    else
      study_text_add(text, "<td class=l>%s", study_sweep_status(result));
    study_cell(text, "%.2f", result->us_per_step);
    study_cell(text, "%.2f", figure_of(result, ITERATIONS));
    // of a lost run the size of its error says nothing
    study_cell(text, "%.1e", result->lost ? NAN : result->energy_error);
    study_cell(text, "%.1e", result->lost ? NAN : result->energy_change);
    study_cell(text, "%.1f %%", 100 * result->peak_amplitude);
    for (int k = 0; k < STUDY_RUNG_COUNT; k++)
      study_text_add(text, "<td>%lld", (long long)study_rung(&result->report, k));
  }
  study_text_add(text, "\n</table>\n");
}

void study_sweep_report(study_text *text, const study_sweep_case *cases,
                        const study_sweep_result *results, int64_t count,
                        const study_place *place) {
  study_page_begin(text, "Time steps", place);
  study_text_add(text,
                 "<p>Undamped, from the momentum that an impulse leaves, so that the energy is "
                 "known: ½|p|². Error: the largest deviation from it; change: of the mean over "
                 "the last tenth of the time. Lost: by then the energy has more than doubled. The "
                 "thesis calls 0.01 s its limit.</p>\n");
  for (int64_t n = 0; n < count;) {
    int64_t next = n;
    while (next < count && cases[next].body == cases[n].body)
      next++;
    study_text_add(text, "<div>");
    for (int figure = 0; figure < FIGURE_COUNT; figure++)
      add_panel(text, &cases[n], &results[n], next - n, (sweep_figure)figure);
    study_text_add(text, "</div>\n");
    n = next;
  }
  add_table(text, cases, results, count);
  study_page_end(text);
}
