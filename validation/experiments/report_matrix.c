/* The report of the matrix: what ran, how fast, and the curves.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "validation/experiments/report.h"
#include "validation/experiments/thesis.h"

/* Of the runs of the same body, load and damping, the one with this integrator; NULL: none. */
static const experiment_run *find(const experiment_run *runs, int64_t count,
                                  const experiment_run *like, experiment_integrator integrator) {
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].body == like->body && runs[n].load == like->load && runs[n].alpha == like->alpha &&
        runs[n].integrator == integrator)
      return &runs[n];
  }
  return NULL;
}

static void add_summary(experiment_text *text, const experiment_run *runs, int64_t count,
                        double dt) {
  int64_t done[EXPERIMENT_INTEGRATOR_COUNT] = {0}, all[EXPERIMENT_INTEGRATOR_COUNT] = {0};
  for (int64_t n = 0; n < count; n++) {
    all[runs[n].integrator]++;
    done[runs[n].integrator] += runs[n].status == THRUM_OK;
  }
  experiment_text_add(
      text,
      "<p>Each body is held at its fixed set and pushed at one place, by an impulse "
      "(0.003 s), a constant force (0.3 s) or a sine of 1 Hz, with damping α = 0 or 0.3 "
      "s<sup>−1</sup>, at h = %g s. The forces were found so that, without damping, the "
      "sine displaces the loaded part by a tenth of the body's length or more, the other "
      "loads by a twentieth or more. Runs that came to their end:",
      dt);
  for (int i = 0; i < EXPERIMENT_INTEGRATOR_COUNT; i++) {
    if (all[i] > 0)
      experiment_text_add(text, " <b style='color:%s'>%s</b> %lld of %lld;", experiment_colors[i],
                          experiment_integrator_names[i], (long long)done[i], (long long)all[i]);
  }
  experiment_text_add(text, " the thesis' IMEXv 33 of 36.</p>\n");
}

/* Rows are bodies, columns loads and damping: time of Newmark over time of IMEXv. */
static void add_speed(experiment_text *text, const experiment_run *runs, int64_t count) {
  const experiment_body *body = NULL;
  experiment_text_add(text,
                      "<h2>Speed: time of Newmark over time of IMEXv</h2>\n<p>Processor time of "
                      "the same steps, beside the ratio of the thesis (other meshes, forces and "
                      "machine).</p>\n<table>\n");
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].body != runs[0].body)
      break;
    if (n == 0)
      experiment_text_add(text, "<tr><th>model");
    if (runs[n].integrator == runs[0].integrator)
      experiment_text_add(text, "<th>%s, α = %g<th class=dim>thesis",
                          experiment_load_names[runs[n].load], runs[n].alpha);
  }
  for (int64_t n = 0; n < count; n++) {
    if (runs[n].integrator != runs[0].integrator)
      continue;
    if (runs[n].body != body) {
      body = runs[n].body;
      experiment_text_add(text, "\n<tr><td>%s", body->name);
    }
    const experiment_run *imexv = find(runs, count, &runs[n], EXPERIMENT_imexv);
    const experiment_run *newmark = find(runs, count, &runs[n], EXPERIMENT_newmark);
    experiment_cell(text, "%.2f",
                    imexv != NULL && newmark != NULL ? newmark->us_per_step / imexv->us_per_step
                                                     : NAN);
    experiment_cell(text, "<span class=dim>%.2f</span>",
                    experiment_thesis_speedup(body->name, runs[n].load, runs[n].alpha));
  }
  experiment_text_add(text, "\n</table>\n");
}

static void add_splits(experiment_text *text, const experiment_run *runs, int64_t count) {
  const experiment_body *body = NULL;
  experiment_text_add(text,
                      "<h2>Bodies</h2>\n<table>\n<tr><th>model<th>rank<th>explicit/implicit at "
                      "rest<th>thesis<th>length [m]");
  for (int64_t n = 0; n < count; n++) {
    int thesis_explicit = 0, thesis_implicit = 0;
    const experiment_run *run = &runs[n];
    if (run->integrator != EXPERIMENT_imexv || run->body == body || run->row_count == 0)
      continue;
    body = run->body;
    const int explicit_modes = (int)run->rows[0].explicit_modes;
    experiment_text_add(text, "\n<tr><td>%s<td>%lld<td>%d/%d", body->name,
                        (long long)body->model->rank, explicit_modes,
                        (int)body->model->rank - explicit_modes);
    if (experiment_thesis_split(body->name, &thesis_explicit, &thesis_implicit)) {
      experiment_text_add(text, "<td class=dim>%d/%d", thesis_explicit, thesis_implicit);
    } else {
      experiment_text_add(text, "<td>–");
    }
    experiment_text_add(text, "<td>%.4g", body->length);
  }
  experiment_text_add(text, "\n</table>\n");
}

static void add_run(experiment_text *text, const experiment_run *run) {
  experiment_text_add(
      text, "\n<tr><td>%s<td class=l>%s<td>%.3g<td>%g<td class=l style='color:%s'>%s",
      run->body->name, experiment_load_names[run->load], run->force, run->alpha,
      experiment_colors[run->integrator], experiment_integrator_names[run->integrator]);
  experiment_cell(text, "%.4g", run->simulated);
  if (run->status != THRUM_OK)
    experiment_text_add(text, " <span class=bad>%s</span>", experiment_status_name(run->status));
  const double lost = run->integrator == EXPERIMENT_imexv
                          ? experiment_thesis_lost(run->body->name, run->load, run->alpha)
                          : NAN;
  experiment_cell(text, "<span class=dim>%.4g</span>", lost);
  experiment_cell(text, "%.2f", run->us_per_step);
  experiment_cell(text, "%.2f", run->mean_iterations);
  experiment_cell(text, "%.1f %%", 100 * run->peak_amplitude);
  experiment_cell(text, "%.3g", run->energy_peak);
  experiment_cell(text, "%.3g", run->energy_end);
  experiment_cell(text, "%.1e", run->energy_change);
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, "<td>%lld", (long long)experiment_level(&run->report, n));
}

static void add_runs(experiment_text *text, const experiment_run *runs, int64_t count) {
  experiment_text_add(
      text, "<h2>All runs</h2>\n<p>Change: of the mean energy from the first to the last "
            "tenth of the time after the load, without damping. Fallback levels: steps that needed "
            "more than quasi-Newton, and what the watch of IMEXv did.</p>\n<table>\n"
            "<tr><th>model<th class=l>load<th>force [N]<th>α [1/s]<th class=l>integrator"
            "<th>time [s]<th>thesis lost at [s]<th>µs a step<th>iterations"
            "<th>amplitude<th>peak energy [J]<th>end [J]<th>change");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, "<th>%s", experiment_level_headings[n]);
  for (int64_t n = 0; n < count; n++)
    add_run(text, &runs[n]);
  experiment_text_add(text, "\n</table>\n");
}

/* The recorded rows as columns: time, total, explicit_modes; row_count each. */
static double *columns_of(const experiment_run *run) {
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
static void add_panel(experiment_text *text, const experiment_run *runs, int64_t count) {
  char title[96];
  double *columns[EXPERIMENT_INTEGRATOR_COUNT] = {NULL};
  experiment_plot energy = {.title = title,
                            .x_label = "time [s]",
                            .y_label = "energy [J]",
                            .width = 370,
                            .height = 210,
                            .from_zero = true};
  experiment_plot split = {.title = "explicit modes of imexv",
                           .x_label = "time [s]",
                           .y_label = "modes",
                           .width = 370,
                           .height = 110,
                           .from_zero = true};
  snprintf(title, sizeof title, "%s, α = %g", experiment_load_names[runs->load], runs->alpha);
  for (int64_t n = 0; n < count; n++) {
    const int64_t rows = runs[n].row_count;
    double *data = columns[n] = columns_of(&runs[n]);
    if (data == NULL) {
      text->failed = true;
      break;
    }
    energy.series[energy.series_count++] =
        (experiment_series){experiment_integrator_names[runs[n].integrator],
                            experiment_colors[runs[n].integrator],
                            data,
                            data + rows,
                            rows,
                            false};
    if (runs[n].integrator == EXPERIMENT_imexv)
      split.series[split.series_count++] = (experiment_series){
          NULL, experiment_colors[EXPERIMENT_imexv], data, data + 2 * rows, rows, false};
  }
  experiment_text_add(text, "<td style='border:0;padding:0'>");
  experiment_plot_add(text, &energy);
  if (split.series_count > 0) {
    experiment_text_add(text, "<br>");
    experiment_plot_add(text, &split);
  }
  for (int64_t n = 0; n < count; n++)
    free(columns[n]);
}

static void add_curves(experiment_text *text, const experiment_run *runs, int64_t count) {
  const experiment_body *body = NULL;
  experiment_text_add(text, "<h2>Energy over time</h2>\n");
  for (int64_t b = 0; b < count;) {
    int64_t end = b;
    body = runs[b].body;
    while (end < count && runs[end].body == body)
      end++;
    experiment_text_add(text, "<h3>%s</h3>\n<table>", body->name);
    for (int damping = 0; damping < EXPERIMENT_DAMPING_COUNT; damping++) {
      experiment_text_add(text, "<tr>");
      for (int64_t n = b; n < end;) {
        int64_t next = n;
        while (next < end && runs[next].load == runs[n].load && runs[next].alpha == runs[n].alpha)
          next++;
        if (runs[n].alpha == experiment_dampings[damping])
          add_panel(text, &runs[n], next - n);
        n = next;
      }
    }
    experiment_text_add(text, "</table>\n");
    b = end;
  }
}

void experiment_matrix_report(experiment_text *text, const experiment_run *runs, int64_t count,
                              double dt, const experiment_place *place) {
  experiment_page_begin(text, "The experiments of the thesis", place);
  add_summary(text, runs, count, dt);
  add_speed(text, runs, count);
  add_splits(text, runs, count);
  add_curves(text, runs, count);
  add_runs(text, runs, count);
  experiment_page_end(text);
}
