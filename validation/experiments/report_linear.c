/* The report of linear against nonlinear. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "validation/experiments/report.h"

static void add_panel(experiment_text *text, const experiment_body *body,
                      const experiment_linear_result *result) {
  const experiment_linear_curve *curves[2] = {&result->statics, &result->dynamics};
  static const char *const labels[2] = {"at rest", "a period after an impulse"};
  double x[2][EXPERIMENT_LINEAR_POINTS], y[2][EXPERIMENT_LINEAR_POINTS];
  experiment_plot plot = {.title = body->name,
                          .x_label = "deflection, % of the length",
                          .y_label = "error of linear, %",
                          .width = 380,
                          .height = 260,
                          .log_x = true,
                          .log_y = true};
  for (int c = 0; c < 2; c++) {
    int64_t count = 0;
    for (int64_t n = 0; n < curves[c]->count; n++) {
      // a swing may come no further although the impulse grows
      const double amplitude = 100 * curves[c]->points[n].amplitude;
      if (count > 0 && !(amplitude > x[c][count - 1]))
        continue;
      x[c][count] = amplitude;
      y[c][count++] = 100 * curves[c]->points[n].error;
    }
    plot.series[plot.series_count++] =
        (experiment_series){labels[c], experiment_colors[c], x[c], y[c], count, true};
  }
  experiment_plot_add(text, &plot);
}

void experiment_linear_report(experiment_text *text, const experiment_body *bodies,
                              const experiment_linear_result *results, int64_t count,
                              const experiment_place *place) {
  experiment_page_begin(text, "Linear against nonlinear", place);
  experiment_text_add(
      text,
      "<p>Error of linear modal analysis: |q<sub>lin</sub> − q|/|q|, the displacement of the whole "
      "body in the norm of the mass, against the same reduced model with its cubic and quartic "
      "terms; so the basis is the same in both. Deflection: of the loaded group, as a share of the "
      "body's length, in the nonlinear answer; after an impulse its peak.</p>\n<div>");
  for (int64_t n = 0; n < count; n++)
    add_panel(text, &bodies[n], &results[n]);
  experiment_text_add(
      text, "</div>\n<table>\n<tr><th>model<th>r<th>5 %% at rest<th>20 %% at rest<th>5 %% in "
            "motion<th>20 %% in motion<th>R(q) [µs]<th>imexv step [µs]<th>linear step [µs]<th>"
            "nonlinearity costs [µs]");
  for (int64_t n = 0; n < count; n++) {
    const experiment_linear_result *r = &results[n];
    experiment_text_add(text, "\n<tr><td>%s<td>%lld", bodies[n].name,
                        (long long)bodies[n].model->rank);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      experiment_cell(text, "%.2f %%", 100 * r->statics.at[level].amplitude);
    for (int level = 0; level < EXPERIMENT_LINEAR_LEVELS; level++)
      experiment_cell(text, "%.2f %%", 100 * r->dynamics.at[level].amplitude);
    experiment_cell(text, "%.2f", r->force_us);
    experiment_cell(text, "%.2f", r->step_us);
    experiment_cell(text, "%.3f", r->linear_us);
    experiment_cell(text, "%.2f", r->step_us - r->linear_us);
  }
  experiment_text_add(text, "\n</table>\n");
  experiment_page_end(text);
}
