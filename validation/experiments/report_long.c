/* The report of the long runs: the change of the mean energies, and all windows.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/experiments/report.h"

static void add_table(experiment_text *text, const experiment_long_case *cases,
                      const experiment_long_result *results, int64_t count) {
  experiment_text_add(text,
                      "<table>\n<tr><th>model<th>amplitude<th class=l>integrator<th>steps<th>µs a "
                      "step<th>total energy, last against first 35 s<th>worst 35 s<th>high modes, "
                      "last against first<th>slope of the high modes [1/s]<th>± standard error"
                      "<th>of windows that follow each other<th>within two of these");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, "<th>%s", experiment_level_headings[n]);
  for (int64_t n = 0; n < count; n++) {
    const experiment_long_result *result = &results[n];
    experiment_text_add(
        text, "\n<tr><td>%s<td>%.1f %%<td class=l style='color:%s'>%s<td>%lld", cases[n].body->name,
        100 * cases[n].reached, experiment_colors[cases[n].integrator],
        experiment_integrator_names[cases[n].integrator], (long long)result->report.steps);
    if (result->status != THRUM_OK || result->lost)
      experiment_text_add(text, " <span class=bad>%s</span>", experiment_long_status(result));
    experiment_cell(text, "%.2f", result->us_per_step);
    experiment_cell(text, "%.1e", result->total_change);
    experiment_cell(text, "%.1e", result->total_worst);
    experiment_cell(text, "%.1e", result->high_change);
    experiment_cell(text, "%.1e", result->high_slope);
    experiment_cell(text, "%.1e", result->high_slope_error);
    experiment_cell(text, "%.1e", result->high_slope_error_correlated);
    experiment_text_add(text, "<td>%s",
                        !isfinite(result->high_slope_error_correlated) ? "–"
                        : experiment_long_steady(result)               ? "yes"
                                                                       : "no");
    for (int k = 0; k < EXPERIMENT_LEVEL_COUNT; k++)
      experiment_text_add(text, "<td>%lld", (long long)experiment_level(&result->report, k));
  }
  experiment_text_add(text, "\n</table>\n");
}

/* Window means of `count` cases of one body and amplitude, each over the first of its own. */
static void add_panel(experiment_text *text, const experiment_long_case *cases,
                      const experiment_long_result *results, int64_t count, bool high) {
  char title[96];
  double *columns[EXPERIMENT_INTEGRATOR_COUNT] = {NULL};
  experiment_plot plot = {.title = title,
                          .x_label = "time [s]",
                          .y_label = "mean over 35 s, relative to the first",
                          .width = 560,
                          .height = 250};
  snprintf(title, sizeof title, "%s, %.0f %%: %s", cases->body->name, 100 * cases->amplitude,
           high ? "high modes" : "total energy");
  for (int64_t n = 0; n < count; n++) {
    const int64_t windows = results[n].window_count;
    const double *means = high ? results[n].high : results[n].total;
    double *data = columns[n] = malloc((size_t)(2 * windows + 1) * sizeof *data);
    if (data == NULL) {
      text->failed = true;
      break;
    }
    for (int64_t k = 0; k < windows; k++) {
      data[k] = ((double)k + 0.5) * EXPERIMENT_WINDOW_SECONDS;
      data[windows + k] = means[k] / means[0];
    }
    plot.series[plot.series_count++] =
        (experiment_series){experiment_integrator_names[cases[n].integrator],
                            experiment_colors[cases[n].integrator],
                            data,
                            data + windows,
                            windows,
                            false};
  }
  experiment_plot_add(text, &plot);
  for (int64_t n = 0; n < count; n++)
    free(columns[n]);
}

void experiment_long_report(experiment_text *text, const experiment_long_case *cases,
                            const experiment_long_result *results, int64_t count,
                            const experiment_place *place) {
  experiment_page_begin(text, "The long run", place);
  experiment_text_add(
      text, "<p>Undamped, after an impulse of 0.003 s that makes the loaded part swing to "
            "the given share of the body's length. The thesis, on its horse over 10,000 "
            "s: total energy +2 %%, high modes −28 %%.</p>\n");
  add_table(text, cases, results, count);
  for (int64_t n = 0; n < count;) {
    int64_t next = n;
    while (next < count && cases[next].body == cases[n].body &&
           cases[next].amplitude == cases[n].amplitude)
      next++;
    experiment_text_add(text, "<div>");
    add_panel(text, &cases[n], &results[n], next - n, false);
    add_panel(text, &cases[n], &results[n], next - n, true);
    experiment_text_add(text, "</div>\n");
    n = next;
  }
  experiment_page_end(text);
}
