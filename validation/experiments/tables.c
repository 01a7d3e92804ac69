/* Results as comma-separated tables; a number that is not there is left empty.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/tables.h"

#include <math.h>

#include "validation/experiments/run_outcome.h"

static void add_number(FILE *stream, double value) {
  if (isfinite(value)) {
    fprintf(stream, ",%.10g", value);
  } else {
    fprintf(stream, ",");
  }
}

static void add_level_names(FILE *stream) {
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    fprintf(stream, ",%s", experiment_level_names[n]);
  fprintf(stream, "\n");
}

static void add_levels(FILE *stream, const thrum_state_report *report) {
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    fprintf(stream, ",%lld", (long long)experiment_level(report, n));
  fprintf(stream, "\n");
}

void experiment_matrix_csv(FILE *stream, const experiment_run *runs, int64_t count) {
  fprintf(stream, "model,load,force_n,damping,integrator,status,simulated_s,us_per_step,"
                  "mean_iterations,energy_peak_j,energy_end_j,high_end_j,energy_change,"
                  "peak_amplitude,explicit_modes,implicit_modes");
  add_level_names(stream);

  // names, figures, the split at the end, the fallback levels
  for (int64_t n = 0; n < count; n++) {
    const experiment_run *run = &runs[n];
    fprintf(stream, "%s,%s,%.6g,%g,%s,%s", run->body->name, experiment_load_names[run->load],
            run->force, run->alpha, experiment_integrator_names[run->integrator],
            experiment_status_name(run->status));
    const double numbers[] = {run->simulated,     run->us_per_step,   run->mean_iterations,
                              run->energy_peak,   run->energy_end,    run->high_end,
                              run->energy_change, run->peak_amplitude};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(stream, numbers[k]);
    fprintf(stream, ",%d,%d", (int)run->report.explicit_modes, (int)run->report.implicit_modes);
    add_levels(stream, &run->report);
  }
}

void experiment_curves_csv(FILE *stream, const experiment_run *runs, int64_t count) {
  fprintf(stream, "model,load,damping,integrator,time_s,total_j,high_j,explicit_modes,"
                  "amplitude\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < runs[n].row_count; k++) {
      const experiment_row *row = &runs[n].rows[k];
      fprintf(stream, "%s,%s,%g,%s,%.6g,%.10g,%.10g,%g,%.6g\n", runs[n].body->name,
              experiment_load_names[runs[n].load], runs[n].alpha,
              experiment_integrator_names[runs[n].integrator], row->time, row->total, row->high,
              row->explicit_modes, row->amplitude);
    }
  }
}

void experiment_long_csv(FILE *stream, const experiment_long *runs) {
  fprintf(stream, "model,integrator,amplitude,reached,impulse_ns,dt_s,status,steps,"
                  "us_per_step,energy_j,windows,total_change,total_worst,high_change,"
                  "high_slope_per_s,high_slope_error_per_s,"
                  "high_slope_error_correlated_per_s");
  add_level_names(stream);
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
    if (!atomic_load(&runs->done[n]))
      continue;

    // the columns that tables_read_long.c takes back
    fprintf(stream, "%s,%s,%g,%.6g,%.10g,%g,%s,%lld", run->body->name,
            experiment_integrator_names[run->integrator], run->amplitude, run->reached,
            run->impulse, run->dt, experiment_long_status(result), (long long)result->report.steps);
    add_number(stream, result->us_per_step);
    add_number(stream, result->energy);
    fprintf(stream, ",%lld", (long long)result->window_count);
    add_number(stream, result->total_change);
    add_number(stream, result->total_worst);
    add_number(stream, result->high_change);
    add_number(stream, result->high_slope);
    add_number(stream, result->high_slope_error);
    add_number(stream, result->high_slope_error_correlated);
    add_levels(stream, &result->report);
  }
}

void experiment_windows_csv(FILE *stream, const experiment_long *runs) {
  fprintf(stream, "model,integrator,amplitude,window,begin_s,total_j,high_j\n");
  for (int64_t n = 0; n < runs->count; n++) {
    const experiment_long_case *run = &runs->cases[n];
    const experiment_long_result *result = &runs->results[n];
    if (!atomic_load(&runs->done[n]))
      continue;

    for (int64_t k = 0; k < result->window_count; k++)
      fprintf(stream, "%s,%s,%g,%lld,%g,%.13g,%.10g\n", run->body->name,
              experiment_integrator_names[run->integrator], run->amplitude, (long long)k,
              (double)k * EXPERIMENT_WINDOW_SECONDS, result->total[k], result->high[k]);
  }
}

void experiment_sweep_csv(FILE *stream, const experiment_sweep *sweep) {
  fprintf(stream, "model,integrator,dt_s,status,simulated_s,us_per_step,mean_iterations,"
                  "energy_j,energy_error,energy_change,peak_amplitude");
  add_level_names(stream);
  for (int64_t n = 0; n < sweep->count; n++) {
    const experiment_sweep_result *result = &sweep->results[n];
    fprintf(stream, "%s,%s,%g,%s,%.6g", sweep->cases[n].body->name,
            experiment_integrator_names[sweep->cases[n].integrator], sweep->cases[n].dt,
            experiment_sweep_status(result), result->simulated);

    // means over the steps, then the energy
    add_number(stream, result->us_per_step);
    add_number(stream, (double)result->report.iterations / (double)result->report.steps);
    add_number(stream, result->energy);
    add_number(stream, result->energy_error);
    add_number(stream, result->energy_change);
    add_number(stream, result->peak_amplitude);
    add_levels(stream, &result->report);
  }
}

/* A text in quotes, as it may hold a comma. */
static void add_quoted(FILE *stream, const char *plain) {
  fprintf(stream, ",\"");
  for (const char *at = plain; *at != 0; at++)
    fprintf(stream, *at == '"' ? "\"\"" : "%c", *at);
  fprintf(stream, "\"");
}

void experiment_extremes_csv(FILE *stream, const experiment_extremes *extremes) {
  fprintf(stream, "subject,case,integrator,outcome,reason,dt_s,h_omega_first,h_omega_last,"
                  "steps,us_per_step,mean_iterations,work_j,energy_error,energy_end,"
                  "peak_amplitude,explicit_modes,implicit_modes");
  add_level_names(stream);
  for (int64_t n = 0; n < extremes->count; n++) {
    const experiment_extreme_body *body = extremes->cases[n].body;
    const experiment_extreme_result *result = &extremes->results[n];
    fprintf(stream, "%s", experiment_subject_names[body->extreme->subject]);
    add_quoted(stream, body->extreme->name);
    fprintf(stream, ",%s,%s", experiment_integrator_names[extremes->cases[n].integrator],
            experiment_extreme_outcome(&extremes->cases[n], result));
    add_quoted(stream, result->status < 0 ? result->stop.message : "");

    // numbers of the body, which a refused one does not have
    const double numbers[] = {body->dt, body->dt * body->omega[0], body->dt * body->omega[1]};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(stream, numbers[k]);
    fprintf(stream, ",%lld", (long long)result->report.steps);

    const double figures[] = {
        result->us_per_step, (double)result->report.iterations / (double)result->report.steps,
        result->work,        result->energy_error,
        result->energy_end,  result->peak_amplitude};
    for (size_t k = 0; k < sizeof figures / sizeof figures[0]; k++)
      add_number(stream, figures[k]);
    fprintf(stream, ",%d,%d", (int)result->report.explicit_modes,
            (int)result->report.implicit_modes);
    add_levels(stream, &result->report);
  }
}

void experiment_units_csv(FILE *stream, const experiment_extremes *extremes) {
  fprintf(stream, "units,case,integrator,steps,difference,iterations,iterations_si,"
                  "same_levels\n");
  for (int64_t n = 0; n < extremes->unit_count; n++) {
    const experiment_unit_case *run = &extremes->units[n];
    const experiment_unit_result *result = &extremes->unit_results[n];
    // the names hold commas
    fprintf(stream, "\"%s\"", run->units->name);
    add_quoted(stream, run->extreme->name);
    fprintf(stream, ",%s,%lld", experiment_integrator_names[run->integrator],
            (long long)run->steps);
    add_number(stream, result->difference);
    fprintf(stream, ",%lld,%lld,%d\n", (long long)result->iterations,
            (long long)result->iterations_si, result->same_levels);
  }
}

void experiment_linear_csv(FILE *stream, const experiment_linear *linear) {
  fprintf(stream, "model,rank,static_5,static_20,dynamic_5,dynamic_20,static_5_n,static_20_n,"
                  "dynamic_5_ns,dynamic_20_ns,force_us,step_us,linear_step_us,nonlinear_us\n");
  for (int64_t n = 0; n < linear->body_count; n++) {
    const experiment_linear_result *result = &linear->results[n];
    const experiment_linear_point *rest = result->statics.at, *motion = result->dynamics.at;

    // deflections as shares of the length, loads, times
    const double numbers[] = {
        rest[0].amplitude,   rest[1].amplitude, motion[0].amplitude,
        motion[1].amplitude, rest[0].load,      rest[1].load,
        motion[0].load,      motion[1].load,    result->force_us,
        result->step_us,     result->linear_us, result->step_us - result->linear_us};
    fprintf(stream, "%s,%lld", linear->bodies[n].name, (long long)linear->bodies[n].model->rank);
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(stream, numbers[k]);
    fprintf(stream, "\n");
  }
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
