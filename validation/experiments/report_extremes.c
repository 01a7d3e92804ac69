/* The report of the extremes. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "validation/experiments/report.h"

/* How a run came out, for people. */
static void add_outcome(experiment_text *text, const experiment_extreme_case *run,
                        const experiment_extreme_result *result) {
  static const char *const bad[] = {"stopped", "lost", "not_finite"};
  const char *outcome = experiment_extreme_outcome(run, result);
  bool marked = false;
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++)
    marked = marked || strcmp(outcome, bad[n]) == 0;
  experiment_text_add(text, "<td class='l%s'>%s", marked ? " bad" : "", outcome);
}

static void add_row(experiment_text *text, const experiment_extreme_case *run,
                    const experiment_extreme_result *result) {
  const experiment_extreme_body *body = run->body;
  experiment_text_add(text, "<td class=l style='color:%s'>%s", experiment_colors[run->integrator],
                      experiment_integrator_names[run->integrator]);
  add_outcome(text, run, result);
  if (body->status < 0) {
    experiment_text_add(text, "<td class=l colspan=%d>", 5 + EXPERIMENT_LEVEL_COUNT);
    experiment_text_escape(text, result->stop.message);
    return;
  }
  experiment_cell(text, "%.1e", result->energy_error);
  experiment_cell(text, "%.1f %%", 100 * result->peak_amplitude);
  experiment_text_add(text, "<td>%lld", (long long)result->report.steps);
  experiment_cell(text, "%.2f", (double)result->report.iterations / (double)result->report.steps);
  experiment_text_add(text, "<td>%d/%d", (int)result->report.explicit_modes,
                      (int)result->report.implicit_modes);
  for (int k = 0; k < EXPERIMENT_LEVEL_COUNT; k++)
    experiment_text_add(text, "<td>%lld", (long long)experiment_level(&result->report, k));
  if (result->status < 0) {
    experiment_text_add(text, "<td class=l>");
    experiment_text_escape(text, result->stop.message);
  }
}

static void add_cases(experiment_text *text, const experiment_extreme_case *cases,
                      const experiment_extreme_result *results, int64_t count) {
  experiment_text_add(text,
                      "<table>\n<tr><th>case<th>h ω<th class=l>integrator<th class=l>outcome"
                      "<th>energy error<th>amplitude<th>steps<th>iterations<th>E/I at the end");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, "<th>%s", experiment_level_headings[n]);
  for (int64_t n = 0; n < count; n++) {
    const experiment_extreme_body *body = cases[n].body;
    const bool first = n == 0 || cases[n - 1].body != body;
    if (n == 0 || cases[n - 1].body->extreme->subject != body->extreme->subject)
      experiment_text_add(text, "\n<tr><th class=l colspan=%d>%s", 9 + EXPERIMENT_LEVEL_COUNT,
                          experiment_subject_texts[body->extreme->subject]);
    experiment_text_add(text, "\n<tr><td>");
    if (first)
      experiment_text_escape(text, body->extreme->name);
    if (first && body->status >= 0) {
      experiment_text_add(text, "<td>%.2g – %.2g", body->dt * body->omega[0],
                          body->dt * body->omega[1]);
    } else {
      experiment_text_add(text, "<td>");
    }
    add_row(text, &cases[n], &results[n]);
  }
  experiment_text_add(text, "\n</table>\n");
}

static void add_units(experiment_text *text, const experiment_unit_case *cases,
                      const experiment_unit_result *results, int64_t count) {
  experiment_text_add(
      text, "<h2>Units</h2>\n<p>The same body in other units, step by step beside "
            "itself in SI: the largest difference of where the loaded part is, as a "
            "share of its largest displacement; iterations, and in SI; whether the "
            "same fallback levels were used.</p>\n<table>\n<tr><th>case<th class=l>units<th "
            "class=l>integrator<th>difference<th>iterations<th>in SI<th>fallback levels");
  for (int64_t n = 0; n < count; n++) {
    experiment_text_add(text, "\n<tr><td>");
    experiment_text_escape(text, cases[n].extreme->name);
    experiment_text_add(text, "<td class=l>%s<td class=l style='color:%s'>%s", cases[n].units->name,
                        experiment_colors[cases[n].integrator],
                        experiment_integrator_names[cases[n].integrator]);
    experiment_cell(text, "%.1e", results[n].difference);
    experiment_text_add(text, "<td>%lld<td>%lld<td>%s", (long long)results[n].iterations,
                        (long long)results[n].iterations_si,
                        results[n].same_levels ? "same" : "others");
  }
  experiment_text_add(text, "\n</table>\n");
}

void experiment_extremes_report(experiment_text *text, const experiment_extreme_case *cases,
                                const experiment_extreme_result *results, int64_t count,
                                const experiment_unit_case *units,
                                const experiment_unit_result *unit_results, int64_t unit_count,
                                const experiment_place *place) {
  experiment_page_begin(text, "Extremes", place);
  experiment_text_add(
      text, "<p>From rest under a constant load, by default a tenth of what would bend the body by "
            "its length if it were linear, for half of the steps; then without. Energy error: the "
            "largest |E − work| in any step over the most work that was done. Outcome: runs "
            "(quasi-Newton solved every step), the last fallback level of the fallback chain that "
            "was needed, lost "
            "(at the end the error is above all work), stopped (a step said that it could not be "
            "solved), or refused.</p>\n");
  add_cases(text, cases, results, count);
  add_units(text, units, unit_results, unit_count);
  experiment_page_end(text);
}
