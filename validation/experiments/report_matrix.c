/* The report of the matrix: what ran, how fast, and the curves.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/experiments/report.h"
#include "validation/experiments/thesis.h"

/* Of the runs of the same body, load and damping, the one with this integrator; NULL: none. */
static const study_run *find(const study_run *runs, int64_t count, const study_run *like,
                             study_integrator integrator) {
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].body == like->body && runs[n].load == like->load && runs[n].alpha == like->alpha &&
        runs[n].integrator == integrator)
      return &runs[n];
  }
  return NULL;
}

static void add_summary(study_text *text, const study_run *runs, int64_t count, double dt) {
  int64_t done[STUDY_INTEGRATOR_COUNT] = {0}, all[STUDY_INTEGRATOR_COUNT] = {0};
  for (int64_t n = 0; n < count; n++) {
    all[runs[n].integrator]++;
    done[runs[n].integrator] += runs[n].status == THRUM_OK;
  }
  study_text_add(
      text,
      "<p>Each body is held at its fixed set and pushed at one place, by an impulse "
      "(0.003 s), a constant force (0.3 s) or a sine of 1 Hz, with damping α = 0 or 0.3 "
      "s<sup>−1</sup>, at h = %g s. The forces were found so that, without damping, the "
      "sine displaces the loaded part by a tenth of the body's length or more, the other "
      "loads by a twentieth or more. Runs that came to their end:",
      dt);
  for (int i = 0; i < STUDY_INTEGRATOR_COUNT; i++) {
    if (all[i] > 0)
      study_text_add(text, " <b style='color:%s'>%s</b> %lld of %lld;", study_colors[i],
                     study_integrator_names[i], (long long)done[i], (long long)all[i]);
  }
  study_text_add(text, " the thesis' IMEXv 33 of 36.</p>\n");
}

/* Rows are bodies, columns loads and damping: time of Newmark over time of IMEXv. */
static void add_speed(study_text *text, const study_run *runs, int64_t count) {
  const study_body *body = NULL;
  study_text_add(text, "<h2>Speed: time of Newmark over time of IMEXv</h2>\n<p>Processor time of "
                       "the same steps, beside the ratio of the thesis (other meshes, forces and "
                       "machine).</p>\n<table>\n");
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].body != runs[0].body)
      break;
    if (n == 0)
      study_text_add(text, "<tr><th>model");
    if (runs[n].integrator == runs[0].integrator)
      study_text_add(text, "<th>%s, α = %g<th class=dim>thesis", study_load_names[runs[n].load],
                     runs[n].alpha);
  }
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].integrator != runs[0].integrator)
      continue;
    if (runs[n].body != body) {
      body = runs[n].body;
      study_text_add(text, "\n<tr><td>%s", body->name);
    }
    const study_run *imexv = find(runs, count, &runs[n], STUDY_imexv);
    const study_run *newmark = find(runs, count, &runs[n], STUDY_newmark);
    study_cell(text, "%.2f",
               imexv != NULL && newmark != NULL ? newmark->us_per_step / imexv->us_per_step : NAN);
    study_cell(text, "<span class=dim>%.2f</span>",
               study_thesis_speedup(body->name, runs[n].load, runs[n].alpha));
  }
  study_text_add(text, "\n</table>\n");
}

static void add_splits(study_text *text, const study_run *runs, int64_t count) {
  const study_body *body = NULL;
  study_text_add(text, "<h2>Bodies</h2>\n<table>\n<tr><th>model<th>rank<th>explicit/implicit at "
                       "rest<th>thesis<th>length [m]");
  for (int64_t n = 0; n < count; n++) {
    int thesis_explicit = 0, thesis_implicit = 0;
    const study_run *run = &runs[n];
    if (run->integrator != STUDY_imexv || run->body == body || run->row_count == 0)
      continue;
    body = run->body;
    const int explicit_modes = (int)run->rows[0].explicit_modes;
    study_text_add(text, "\n<tr><td>%s<td>%lld<td>%d/%d", body->name, (long long)body->model->rank,
                   explicit_modes, (int)body->model->rank - explicit_modes);
    if (study_thesis_split(body->name, &thesis_explicit, &thesis_implicit)) {
      study_text_add(text, "<td class=dim>%d/%d", thesis_explicit, thesis_implicit);
    } else {
      study_text_add(text, "<td>–");
    }
    study_text_add(text, "<td>%.4g", body->length);
  }
  study_text_add(text, "\n</table>\n");
}

static void add_run(study_text *text, const study_run *run) {
  study_text_add(text, "\n<tr><td>%s<td class=l>%s<td>%.3g<td>%g<td class=l style='color:%s'>%s",
                 run->body->name, study_load_names[run->load], run->force, run->alpha,
                 study_colors[run->integrator], study_integrator_names[run->integrator]);
  study_cell(text, "%.4g", run->simulated);
  if (run->status != THRUM_OK)
    study_text_add(text, " <span class=bad>%s</span>", study_status_name(run->status));
  const double lost = run->integrator == STUDY_imexv
                          ? study_thesis_lost(run->body->name, run->load, run->alpha)
                          : NAN;
  study_cell(text, "<span class=dim>%.4g</span>", lost);
  study_cell(text, "%.2f", run->us_per_step);
  study_cell(text, "%.2f", run->mean_iterations);
  study_cell(text, "%.1f %%", 100 * run->peak_amplitude);
  study_cell(text, "%.3g", run->energy_peak);
  study_cell(text, "%.3g", run->energy_end);
  study_cell(text, "%.1e", run->energy_change);
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, "<td>%lld", (long long)study_rung(&run->report, n));
}

static void add_runs(study_text *text, const study_run *runs, int64_t count) {
  study_text_add(text,
                 "<h2>All runs</h2>\n<p>Change: of the mean energy from the first to the last "
                 "tenth of the time after the load, without damping. Rungs: steps that needed "
                 "more than quasi-Newton, and what the watch of IMEXv did.</p>\n<table>\n"
                 "<tr><th>model<th class=l>load<th>force [N]<th>α [1/s]<th class=l>integrator"
                 "<th>time [s]<th>thesis lost at [s]<th>µs a step<th>iterations"
                 "<th>amplitude<th>peak energy [J]<th>end [J]<th>change");
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, "<th>%s", study_rung_headings[n]);
  for (int64_t n = 0; n < count; n++)
    add_run(text, &runs[n]);
  study_text_add(text, "\n</table>\n");
}

/* The recorded rows as columns: time, total, explicit_modes; row_count each. */
static double *columns_of(const study_run *run) {
  const int64_t count = run->row_count;
  double *columns = malloc((size_t)(3 * count + 1) * sizeof *columns);
  for (int64_t k = 0; columns != NULL && k < count; k++) {
    columns[k] = run->rows[k].time;
    columns[count + k] = run->rows[k].total;
    columns[2 * count + k] = run->rows[k].explicit_modes;
  }
  return columns;
}

/* The curves of one body, load and damping: `count` runs from `runs`. */
static void add_panel(study_text *text, const study_run *runs, int64_t count) {
  char title[96];
  double *columns[STUDY_INTEGRATOR_COUNT] = {NULL};
  study_plot energy = {.title = title,
                       .x_label = "time [s]",
                       .y_label = "energy [J]",
                       .width = 370,
                       .height = 210,
                       .from_zero = true};
  study_plot split = {.title = "explicit modes of imexv",
                      .x_label = "time [s]",
                      .y_label = "modes",
                      .width = 370,
                      .height = 110,
                      .from_zero = true};
  snprintf(title, sizeof title, "%s, α = %g", study_load_names[runs->load], runs->alpha);
  for (int64_t n = 0; n < count; n++) {
    const int64_t rows = runs[n].row_count;
    double *data = columns[n] = columns_of(&runs[n]);
    if (data == NULL) {
      text->failed = true;
      break;
    }
    energy.series[energy.series_count++] =
        (study_series){study_integrator_names[runs[n].integrator],
                       study_colors[runs[n].integrator],
                       data,
                       data + rows,
                       rows,
                       false};
    if (runs[n].integrator == STUDY_imexv)
      split.series[split.series_count++] =
          (study_series){NULL, study_colors[STUDY_imexv], data, data + 2 * rows, rows, false};
  }
  study_text_add(text, "<td style='border:0;padding:0'>");
  study_plot_add(text, &energy);
  if (split.series_count > 0) {
    study_text_add(text, "<br>");
    study_plot_add(text, &split);
  }
  for (int64_t n = 0; n < count; n++)
    free(columns[n]);
}

static void add_curves(study_text *text, const study_run *runs, int64_t count) {
  const study_body *body = NULL;
  study_text_add(text, "<h2>Energy over time</h2>\n");
  for (int64_t b = 0; b < count;) {
    int64_t end = b;
    body = runs[b].body;
    while (end < count && runs[end].body == body)
      end++;
    study_text_add(text, "<h3>%s</h3>\n<table>", body->name);
    for (int damping = 0; damping < STUDY_DAMPING_COUNT; damping++) {
      study_text_add(text, "<tr>");
      for (int64_t n = b; n < end;) {
        int64_t next = n;
        while (next < end && runs[next].load == runs[n].load && runs[next].alpha == runs[n].alpha)
          next++;
        if (runs[n].alpha == study_dampings[damping])
          add_panel(text, &runs[n], next - n);
        n = next;
      }
    }
    study_text_add(text, "</table>\n");
    b = end;
  }
}

void study_matrix_report(study_text *text, const study_run *runs, int64_t count, double dt,
                         const study_place *place) {
  study_page_begin(text, "The experiments of the thesis", place);
  add_summary(text, runs, count, dt);
  add_speed(text, runs, count);
  add_splits(text, runs, count);
  add_curves(text, runs, count);
  add_runs(text, runs, count);
  study_page_end(text);
}
