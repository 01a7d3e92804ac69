/* The report of the sweep over time steps. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/experiments/report.h"

typedef enum sweep_figure { ENERGY_ERROR, ITERATIONS, FIGURE_COUNT } sweep_figure;

static double figure_of(const experiment_sweep_result *result, sweep_figure figure) {
  if (figure == ENERGY_ERROR)
    return result->status == THRUM_OK && !result->lost ? result->energy_error : NAN;
  return (double)result->report.iterations / (double)result->report.steps;
}

/* One figure over the time steps, for the `count` cases of one body. */
static void add_panel(experiment_text *text, const experiment_sweep_case *cases,
                      const experiment_sweep_result *results, int64_t count, sweep_figure figure) {
  static const char *const labels[FIGURE_COUNT] = {"largest relative error of the energy",
                                                   "iterations a step"};
  char title[96];
  double *data = malloc((size_t)(2 * count * EXPERIMENT_INTEGRATOR_COUNT) * sizeof *data);
  experiment_plot plot = {.title = title,
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
  for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
    double *x = data + 2 * count * i, *y = x + count;
    int64_t points = 0;
    for (int64_t n = 0; n < count; n++) {
      if (cases[n].integrator != (experiment_integrator)i)
        continue;
      x[points] = cases[n].dt;
      y[points++] = figure_of(&results[n], figure);
    }
    if (points > 0)
      plot.series[plot.series_count++] = (experiment_series){
          experiment_integrator_names[i], experiment_colors[i], x, y, points, true};
  }
  experiment_plot_add(text, &plot);
  free(data);
}

static void add_table(experiment_text *text, const experiment_sweep_case *cases,
                      const experiment_sweep_result *results, int64_t count) {
  experiment_text_add(text, "<table>\n<tr><th>model<th>h [s]<th class=l>integrator<th>time [s]<th "
                            "class=l>completes<th>µs a "
                            "step<th>iterations<th>energy error<th>change<th>amplitude");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, "<th>%s", experiment_level_headings[n]);
  for (int64_t n = 0; n < count; n++) {
    const experiment_sweep_result *result = &results[n];
    experiment_text_add(text, "\n<tr><td>%s<td>%g<td class=l style='color:%s'>%s",
                        cases[n].body->name, cases[n].dt, experiment_colors[cases[n].integrator],
                        experiment_integrator_names[cases[n].integrator]);
    experiment_cell(text, "%.4g", result->simulated);
    if (result->status != THRUM_OK || result->lost)
      experiment_text_add(text, "<td class='l bad'>%s", experiment_sweep_status(result));
    else
      experiment_text_add(text, "<td class=l>%s", experiment_sweep_status(result));
    experiment_cell(text, "%.2f", result->us_per_step);
    experiment_cell(text, "%.2f", figure_of(result, ITERATIONS));
    // of a lost run the size of its error says nothing
    experiment_cell(text, "%.1e", result->lost ? NAN : result->energy_error);
    experiment_cell(text, "%.1e", result->lost ? NAN : result->energy_change);
    experiment_cell(text, "%.1f %%", 100 * result->peak_amplitude);
    for (int k = 0; k < EXPERIMENT_LEVEL_COUNT; k++)
      experiment_text_add(text, "<td>%lld", (long long)experiment_level(&result->report, k));
  }
  experiment_text_add(text, "\n</table>\n");
}

void experiment_sweep_report(experiment_text *text, const experiment_sweep_case *cases,
                             const experiment_sweep_result *results, int64_t count,
                             const experiment_place *place) {
  experiment_page_begin(text, "Time steps", place);
  experiment_text_add(
      text, "<p>Undamped, from the momentum that an impulse leaves, so that the energy is "
            "known: ½|p|². Error: the largest deviation from it; change: of the mean over "
            "the last tenth of the time. Lost: by then the energy has more than doubled. The "
            "thesis calls 0.01 s its limit.</p>\n");
  for (int64_t n = 0; n < count;) {
    int64_t next = n;
    while (next < count && cases[next].body == cases[n].body)
      next++;
    experiment_text_add(text, "<div>");
    for (int figure = 0; figure < FIGURE_COUNT; figure++)
      add_panel(text, &cases[n], &results[n], next - n, (sweep_figure)figure);
    experiment_text_add(text, "</div>\n");
    n = next;
  }
  add_table(text, cases, results, count);
  experiment_page_end(text);
}
