/* The report of the extremes. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "validation/experiments/report.h"

/* How a run came out, for people. */
static void add_outcome(study_text *text, const study_extreme_case *run,
                        const study_extreme_result *result) {
  static const char *const bad[] = {"stopped", "lost", "not_finite"};
  const char *outcome = study_extreme_outcome(run, result);
  bool marked = false;
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++)
    marked = marked || strcmp(outcome, bad[n]) == 0;
  study_text_add(text, "<td class='l%s'>%s", marked ? " bad" : "", outcome);
}

static void add_row(study_text *text, const study_extreme_case *run,
                    const study_extreme_result *result) {
  const study_extreme_body *body = run->body;
  study_text_add(text, "<td class=l style='color:%s'>%s", study_colors[run->integrator],
                 study_integrator_names[run->integrator]);
  add_outcome(text, run, result);
  if (body->status < 0) {
    study_text_add(text, "<td class=l colspan=%d>", 5 + STUDY_RUNG_COUNT);
    study_text_escape(text, result->stop.message);
    return;
  }
  study_cell(text, "%.1e", result->energy_error);
  study_cell(text, "%.1f %%", 100 * result->peak_amplitude);
  study_text_add(text, "<td>%lld", (long long)result->report.steps);
  study_cell(text, "%.2f", (double)result->report.iterations / (double)result->report.steps);
  study_text_add(text, "<td>%d/%d", (int)result->report.explicit_modes,
                 (int)result->report.implicit_modes);
  for (int k = 0; k < STUDY_RUNG_COUNT; k++)
    study_text_add(text, "<td>%lld", (long long)study_rung(&result->report, k));
  if (result->status < 0) {
    study_text_add(text, "<td class=l>");
    study_text_escape(text, result->stop.message);
  }
}

static void add_cases(study_text *text, const study_extreme_case *cases,
                      const study_extreme_result *results, int64_t count) {
  study_text_add(text, "<table>\n<tr><th>case<th>h ω<th class=l>integrator<th class=l>outcome"
                       "<th>energy error<th>amplitude<th>steps<th>iterations<th>E/I at the end");
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, "<th>%s", study_rung_headings[n]);
  for (int64_t n = 0; n < count; n++) {
    const study_extreme_body *body = cases[n].body;
    const bool first = n == 0 || cases[n - 1].body != body;
    if (n == 0 || cases[n - 1].body->extreme->subject != body->extreme->subject)
      study_text_add(text, "\n<tr><th class=l colspan=%d>%s", 9 + STUDY_RUNG_COUNT,
                     study_subject_texts[body->extreme->subject]);
    study_text_add(text, "\n<tr><td>");
    if (first)
      study_text_escape(text, body->extreme->name);
    if (first && body->status >= 0) {
      study_text_add(text, "<td>%.2g – %.2g", body->dt * body->omega[0], body->dt * body->omega[1]);
    } else {
      study_text_add(text, "<td>");
    }
    add_row(text, &cases[n], &results[n]);
  }
  study_text_add(text, "\n</table>\n");
}

static void add_units(study_text *text, const study_unit_case *cases,
                      const study_unit_result *results, int64_t count) {
  study_text_add(text, "<h2>Units</h2>\n<p>The same body in other units, step by step beside "
                       "itself in SI: the largest difference of where the loaded part is, as a "
                       "share of its largest displacement; iterations, and in SI; whether the "
                       "same rungs were used.</p>\n<table>\n<tr><th>case<th class=l>units<th "
                       "class=l>integrator<th>difference<th>iterations<th>in SI<th>rungs");
  for (int64_t n = 0; n < count; n++) {
    study_text_add(text, "\n<tr><td>");
    study_text_escape(text, cases[n].extreme->name);
    study_text_add(text, "<td class=l>%s<td class=l style='color:%s'>%s", cases[n].units->name,
                   study_colors[cases[n].integrator], study_integrator_names[cases[n].integrator]);
    study_cell(text, "%.1e", results[n].difference);
    study_text_add(text, "<td>%lld<td>%lld<td>%s", (long long)results[n].iterations,
                   (long long)results[n].iterations_si, results[n].same_rungs ? "same" : "others");
  }
  study_text_add(text, "\n</table>\n");
}

void study_extremes_report(study_text *text, const study_extreme_case *cases,
                           const study_extreme_result *results, int64_t count,
                           const study_unit_case *units, const study_unit_result *unit_results,
                           int64_t unit_count, const study_place *place) {
  study_page_begin(text, "Extremes", place);
  study_text_add(
      text, "<p>From rest under a constant load, by default a tenth of what would bend the body by "
            "its length if it were linear, for half of the steps; then without. Energy error: the "
            "largest |E − work| in any step over the most work that was done. Outcome: runs "
            "(quasi-Newton solved every step), the last rung of the ladder that was needed, lost "
            "(at the end the error is above all work), stopped (a step said that it could not be "
            "solved), or refused.</p>\n");
  add_cases(text, cases, results, count);
  add_units(text, units, unit_results, unit_count);
  study_page_end(text);
}
