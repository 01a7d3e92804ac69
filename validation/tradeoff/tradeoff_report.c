/* Table and page of the trade. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "validation/tradeoff/tradeoff.h"

static void add_number(experiment_text *text, double value) {
  if (isfinite(value))
    experiment_text_add(text, ",%.10g", value);
  else
    experiment_text_add(text, ",");
}

void tradeoff_csv(experiment_text *text, const tradeoff_result *result) {
  experiment_text_add(
      text, "modes,rank,precision,integrator,dt_s,tolerance,stable,us_per_step,cost_s_per_s,"
            "error_displacement,error_velocity,error_energy,basis_error,time_error,drift,"
            "speedup,front\n");
  for (int64_t n = 0; n < result->run_count; n++) {
    const tradeoff_run *run = &result->runs[n];
    const tradeoff_basis *basis = &result->bases[run->basis];
    experiment_text_add(text, "%lld,%lld,%s,%s,%g,%g,%d", (long long)basis->modes,
                        (long long)basis->rank, basis->single ? "single" : "double",
                        experiment_integrator_names[run->integrator], run->dt, run->tolerance,
                        run->stable);
    const double numbers[] = {run->us_per_step,
                              run->cost,
                              run->error.displacement,
                              run->error.velocity,
                              run->error.energy,
                              basis->error.displacement,
                              run->time_error.displacement,
                              run->drift,
                              result->full_cost / run->cost};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    experiment_text_add(text, ",%d\n", run->front);
  }
}

/* Runs in the order of their cost, the cheap ones first. */
static int by_cost(const void *a, const void *b) {
  const tradeoff_run *const *x = a, *const *y = b;
  return ((*x)->cost > (*y)->cost) - ((*x)->cost < (*y)->cost);
}

/* The front as a line, the runs of each integrator as dots. */
static void add_plot(experiment_text *text, const tradeoff_result *result,
                     const tradeoff_run **sorted) {
  const int64_t count = result->run_count;
  double *data = calloc((size_t)count * 2 * (EXPERIMENT_INTEGRATOR_COUNT + 1) + 1, sizeof *data);
  experiment_plot plot = {.title = "error against cost",
                          .x_label = "processor time for a second [s]",
                          .y_label = "displacement error",
                          .width = 760,
                          .height = 420,
                          .log_x = true,
                          .log_y = true};
  if (data == NULL) {
    text->failed = true;
    return;
  }
  for (int group = 0; group <= EXPERIMENT_INTEGRATOR_COUNT; group++) {
    double *x = data + 2 * count * group, *y = x + count;
    const bool front = group == 0;
    int64_t points = 0;
    for (int64_t n = 0; n < count; n++) {
      const tradeoff_run *run = sorted[n];
      if (!run->stable ||
          (front ? !run->front : run->integrator != (experiment_integrator)(group - 1)))
        continue;
      x[points] = run->cost;
      y[points++] = run->error.displacement;
    }
    if (points > 0)
      plot.series[plot.series_count++] =
          (experiment_series){.label = front ? "front" : experiment_integrator_names[group - 1],
                              .color = front ? "#111" : experiment_colors[group - 1],
                              .x = x,
                              .y = y,
                              .count = points,
                              .marks = front ? 0 : 2};
  }
  experiment_plot_add(text, &plot);
  free(data);
}

static void add_percent(experiment_text *text, double share) {
  experiment_cell(text, "%.3g %%", 100 * share);
}

static void add_row(experiment_text *text, const tradeoff_result *result, const tradeoff_run *run) {
  const tradeoff_basis *basis = &result->bases[run->basis];
  experiment_text_add(text, "\n<tr><td class=l style='color:%s'>%s<td>",
                      experiment_colors[run->integrator],
                      experiment_integrator_names[run->integrator]);
  if (basis->modes > 0)
    experiment_text_add(text, "%lld", (long long)basis->modes);
  else
    experiment_text_add(text, "own");
  experiment_text_add(text, "<td>%lld<td>%s<td>%g<td>%g", (long long)basis->rank,
                      basis->single ? "single" : "double", run->dt, run->tolerance);
  experiment_cell(text, "%.2f", run->us_per_step);
  experiment_cell(text, "%.2e", run->cost);
  experiment_cell(text, "%.0f", result->full_cost / run->cost);
  if (!run->stable)
    experiment_text_add(text, "<td><span class=bad>lost</span>");
  else
    add_percent(text, run->error.displacement);
  add_percent(text, run->error.velocity);
  add_percent(text, run->error.energy);
  add_percent(text, basis->error.displacement);
  add_percent(text, run->time_error.displacement);
  experiment_cell(text, "%.1e", run->drift);
}

static void add_table(experiment_text *text, const tradeoff_result *result,
                      const tradeoff_run *const *sorted, bool front) {
  experiment_text_add(
      text,
      "<table>\n<tr><th class=l>integrator<th>modes<th>rank<th>precision<th>h [s]<th>tolerance"
      "<th>µs a step<th>cost [s/s]<th>times faster than full<th>displacement<th>"
      "velocity<th>energy<th>of the basis<th>in time<th>drift");
  for (int64_t n = 0; n < result->run_count; n++)
    if (!front || sorted[n]->front)
      add_row(text, result, sorted[n]);
  experiment_text_add(text, "\n</table>\n");
}

void tradeoff_report(experiment_text *text, const tradeoff_problem *problem,
                     const tradeoff_result *result, int64_t chosen, const char *wanted,
                     const experiment_place *place) {
  const tradeoff_run **sorted = calloc((size_t)result->run_count + 1, sizeof *sorted);
  if (sorted == NULL) {
    text->failed = true;
    return;
  }
  for (int64_t n = 0; n < result->run_count; n++)
    sorted[n] = &result->runs[n];
  qsort(sorted, (size_t)result->run_count, sizeof *sorted, by_cost);
  experiment_page_begin(text, "The trade: speed against accuracy", place);
  experiment_text_add(
      text,
      "<p>%g s of the load, %lld runs. Reference: the full order of the same mesh, "
      "%lld components, stepped by the energy-conserving method at %g s; it takes "
      "%.3g ms a step, %.3g s for a second. Its own error in time is about %.2g %%, "
      "below which no error here means anything. Errors are relative, root mean square over the "
      "time in the norm of the mass; of the energy the largest. Cost: processor time "
      "for a simulated second.</p>\n",
      problem->time, (long long)result->run_count, (long long)result->free_count, problem->full_dt,
      1e-3 * result->full_us_per_step, result->full_cost, 100 * result->full_error);
  if (wanted != NULL) {
    experiment_text_add(text, "<h2>Recommended for ");
    experiment_text_escape(text, wanted);
    experiment_text_add(text, "</h2>\n");
    if (chosen < 0) {
      experiment_text_add(text, "<p>No setting that was tried.</p>\n");
    } else {
      const tradeoff_run *run = &result->runs[chosen];
      add_table(text,
                &(tradeoff_result){.runs = result->runs,
                                   .run_count = 1,
                                   .bases = result->bases,
                                   .full_cost = result->full_cost},
                &run, false);
    }
  }
  add_plot(text, result, sorted);
  experiment_text_add(text, "<h2>The front</h2>\n");
  add_table(text, result, sorted, true);
  experiment_text_add(text, "<h2>All runs</h2>\n");
  add_table(text, result, sorted, false);
  experiment_page_end(text);
  free(sorted);
}
