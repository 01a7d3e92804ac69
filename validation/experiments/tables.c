/* Results as rows: the columns of the tables, of the JSON objects and of what is printed.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/tables.h"

#include "io/json.h"
#include "validation/experiments/run_outcome.h"

/* How a run ended. */
static void add_status(cJSON *row, thrum_status status, bool lost) {
  json_string(row, "status", experiment_status_name(status, lost));
  json_string(row, "reason", experiment_reason(status, lost));
}

/* The last columns, what stepped: all steps, those of the scheme itself, and the counters of the
 * rest. */
static void add_levels(cJSON *row, const thrum_state_report *report) {
  json_number(row, "steps", (double)report->steps);
  json_number(row, "own_steps", (double)experiment_own_steps(report));
  cJSON *levels = cJSON_AddObjectToObject(row, "fallback_levels");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    json_number(levels, experiment_level_names[n], (double)experiment_level(report, n));
}

static void add_split(cJSON *row, const thrum_state_report *report) {
  json_number(row, "explicit_modes", report->explicit_modes);
  json_number(row, "implicit_modes", report->implicit_modes);
}

static double mean_iterations(const thrum_state_report *report) {
  return (double)report->iterations / (double)report->steps;
}

cJSON *experiment_matrix_rows(const experiment_run *runs, int64_t count) {
  cJSON *rows = cJSON_CreateArray();
  for (const experiment_run *run = runs; run < runs + count; run++) {
    cJSON *row = json_add_row(rows);

    // which run
    json_string(row, "model", run->body->name);
    json_string(row, "load", experiment_load_names[run->load]);
    json_number(row, "force_n", run->force);
    json_number(row, "damping", run->alpha);
    json_number(row, "dt_s", run->dt);
    json_string(row, "scheme", experiment_scheme_names[run->scheme]);

    // how it went
    add_status(row, run->status, run->lost);
    json_number(row, "simulated_s", run->simulated);
    json_number(row, "us_per_step", run->us_per_step);
    json_number(row, "mean_iterations", run->mean_iterations);
    json_number(row, "energy_peak_j", run->energy_peak);
    json_number(row, "energy_end_j", run->energy_end);
    json_number(row, "high_end_j", run->high_end);
    json_number(row, "energy_change", run->energy_change);
    json_number(row, "peak_amplitude", run->peak_amplitude);
    add_split(row, &run->report);
    add_levels(row, &run->report);
  }
  return rows;
}

void experiment_curves_csv(FILE *stream, const experiment_run *runs, int64_t count) {
  fprintf(stream, "model,load,damping,dt_s,scheme,time_s,total_j,high_j,explicit_modes,"
                  "amplitude\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < runs[n].row_count; k++) {
      const experiment_row *row = &runs[n].rows[k];
      fprintf(stream, "%s,%s,%g,%g,%s,%.6g,%.7g,%.7g,%g,%.6g\n", runs[n].body->name,
              experiment_load_names[runs[n].load], runs[n].alpha, runs[n].dt,
              experiment_scheme_names[runs[n].scheme], row->time, row->total, row->high,
              row->explicit_modes, row->amplitude);
    }
  }
}

cJSON *experiment_long_rows(const experiment_long *runs) {
  cJSON *rows = cJSON_CreateArray();
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
    if (!atomic_load(&runs->done[n]))
      continue;

    // the columns that tables_read_long.c takes back
    cJSON *row = json_add_row(rows);
    json_string(row, "model", run->body->name);
    json_string(row, "scheme", experiment_scheme_names[run->scheme]);
    json_number(row, "amplitude", run->amplitude);
    json_number(row, "reached", run->reached);
    json_number(row, "impulse_ns", run->impulse);
    json_number(row, "dt_s", run->dt);
    add_status(row, result->status, result->lost);
    json_number(row, "us_per_step", result->us_per_step);
    json_number(row, "energy_j", result->energy);
    json_number(row, "windows", (double)result->window_count);
    json_number(row, "total_change", result->total_change);
    json_number(row, "total_worst", result->total_worst);
    json_number(row, "high_change", result->high_change);
    json_number(row, "high_slope_per_s", result->high_slope);
    json_number(row, "high_slope_error_per_s", result->high_slope_error);
    json_number(row, "high_slope_error_correlated_per_s", result->high_slope_error_correlated);
    add_levels(row, &result->report);
    cJSON_AddBoolToObject(row, "high_steady", experiment_long_steady(result));
  }
  return rows;
}

void experiment_windows_csv(FILE *stream, const experiment_long *runs) {
  fprintf(stream, "model,scheme,amplitude,window,begin_s,total_j,high_j\n");
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
    if (!atomic_load(&runs->done[n]))
      continue;

    for (int64_t k = 0; k < result->window_count; k++)
      fprintf(stream, "%s,%s,%g,%lld,%g,%.8g,%.6g\n", run->body->name,
              experiment_scheme_names[run->scheme], run->amplitude, (long long)k,
              (double)k * EXPERIMENT_WINDOW_SECONDS, result->total[k], result->high[k]);
  }
}

cJSON *experiment_sweep_rows(const experiment_sweep *sweep) {
  cJSON *rows = cJSON_CreateArray();
  for (int64_t n = 0; n < sweep->count; n++) {
    const experiment_sweep_case *run = &sweep->cases[n];
    const experiment_sweep_result *result = &sweep->results[n];
    cJSON *row = json_add_row(rows);

    // which run
    json_string(row, "model", run->body->name);
    json_string(row, "start", experiment_start_names[run->start]);
    json_string(row, "scheme", experiment_scheme_names[run->scheme]);
    json_number(row, "dt_s", (double)run->dt.longest * EXPERIMENT_SWEEP_TICK);
    json_number(row, "shortest_dt_s", (double)run->dt.shortest * EXPERIMENT_SWEEP_TICK);

    // how it went, what it cost, and how far off it is
    add_status(row, result->status, result->lost);
    json_number(row, "simulated_s", result->report.time);
    json_number(row, "us_per_step", result->us_per_step);
    json_number(row, "cost_s_per_s", result->cost);
    json_number(row, "mean_iterations", mean_iterations(&result->report));
    json_number(row, "energy_j", result->energy);
    json_number(row, "energy_error", result->energy_error);
    json_number(row, "energy_change", result->energy_change);
    json_number(row, "error", result->error);
    json_number(row, "reference_error", run->reference->error);
    json_number(row, "peak_amplitude", result->peak_amplitude);
    add_levels(row, &result->report);
  }
  return rows;
}

cJSON *experiment_extremes_rows(const experiment_extremes *extremes) {
  cJSON *rows = cJSON_CreateArray();
  for (int64_t n = 0; n < extremes->count; n++) {
    const experiment_extreme_case *run = &extremes->cases[n];
    const experiment_extreme_body *body = run->body;
    const experiment_extreme_result *result = &extremes->results[n];
    cJSON *row = json_add_row(rows);
    json_string(row, "subject", experiment_subject_names[body->extreme->subject]);
    json_string(row, "case", body->extreme->name);
    json_string(row, "scheme", experiment_scheme_names[run->scheme]);
    json_string(row, "outcome", experiment_extreme_outcome(run, result));
    json_string(row, "reason", result->status < 0 ? result->stop.message : "");

    // these are zero where a body was refused
    json_number(row, "dt_s", body->dt);
    json_number(row, "h_omega_first", body->dt * body->omega[0]);
    json_number(row, "h_omega_last", body->dt * body->omega[1]);
    json_number(row, "us_per_step", result->us_per_step);
    json_number(row, "mean_iterations", mean_iterations(&result->report));
    json_number(row, "work_j", result->work);
    json_number(row, "energy_error", result->energy_error);
    json_number(row, "energy_end", result->energy_end);
    json_number(row, "peak_amplitude", result->peak_amplitude);
    add_split(row, &result->report);
    add_levels(row, &result->report);
  }
  return rows;
}

cJSON *experiment_units_rows(const experiment_extremes *extremes) {
  cJSON *rows = cJSON_CreateArray();
  for (int64_t n = 0; n < extremes->unit_count; n++) {
    const experiment_unit_case *run = &extremes->units[n];
    const experiment_unit_result *result = &extremes->unit_results[n];
    cJSON *row = json_add_row(rows);

    // which run
    json_string(row, "units", run->units->name);
    json_string(row, "case", run->extreme->name);
    json_string(row, "scheme", experiment_scheme_names[run->scheme]);
    json_number(row, "steps", (double)run->steps);

    // what other units changed: nothing, if all is well
    json_number(row, "difference", result->difference);
    json_number(row, "iterations", (double)result->iterations);
    json_number(row, "iterations_si", (double)result->iterations_si);
    cJSON_AddBoolToObject(row, "same_levels", result->same_levels);
  }
  return rows;
}

cJSON *experiment_linear_rows(const experiment_linear *linear) {
  cJSON *rows = cJSON_CreateArray();
  for (int64_t n = 0; n < linear->body_count; n++) {
    const experiment_linear_result *result = &linear->results[n];
    const experiment_linear_point *rest = result->statics.at, *motion = result->dynamics.at;
    cJSON *row = json_add_row(rows);
    json_string(row, "model", linear->bodies[n].name);
    json_number(row, "rank", (double)linear->bodies[n].model->rank);

    // deflections as shares of the length, then the loads [N] and impulses [N s]
    json_number(row, "static_5", rest[0].amplitude);
    json_number(row, "static_20", rest[1].amplitude);
    json_number(row, "dynamic_5", motion[0].amplitude);
    json_number(row, "dynamic_20", motion[1].amplitude);
    json_number(row, "static_5_n", rest[0].load);
    json_number(row, "static_20_n", rest[1].load);
    json_number(row, "dynamic_5_ns", motion[0].load);
    json_number(row, "dynamic_20_ns", motion[1].load);

    json_number(row, "force_us", result->force_us);
    json_number(row, "step_us", result->step_us);
    json_number(row, "linear_step_us", result->linear_us);
    json_number(row, "nonlinear_us", result->step_us - result->linear_us);
  }
  return rows;
}

void experiment_linear_curves_csv(FILE *stream, const experiment_linear *linear) {
  fprintf(stream, "model,kind,load,deflection,error\n");
  for (int64_t n = 0; n < linear->body_count; n++) {
    const experiment_linear_curve *curves[2] = {&linear->results[n].statics,
                                                &linear->results[n].dynamics};
    for (int c = 0; c < 2; c++)
      for (int64_t k = 0; k < curves[c]->count; k++) {
        const experiment_linear_point *point = &curves[c]->points[k];
        fprintf(stream, "%s,%s,%.10g,%.10g,%.10g\n", linear->bodies[n].name,
                c == 0 ? "static" : "dynamic", point->load, point->amplitude, point->error);
      }
  }
}
