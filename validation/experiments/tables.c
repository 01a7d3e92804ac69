/* Results as comma-separated tables; a number that is not there is left empty.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/tables.h"

#include <math.h>

const char *const experiment_level_names[EXPERIMENT_LEVEL_COUNT] = {
#define X(name, field, heading) #name,
    EXPERIMENT_LEVEL_LIST(X)
#undef X
};

const char *const experiment_level_headings[EXPERIMENT_LEVEL_COUNT] = {
#define X(name, field, heading) heading,
    EXPERIMENT_LEVEL_LIST(X)
#undef X
};

int64_t experiment_level(const thrum_state_report *report, int fallback_level) {
  switch (fallback_level) {
#define X(name, field, heading)                                                                    \
  case EXPERIMENT_LEVEL_##name:                                                                    \
    return report->field;
    EXPERIMENT_LEVEL_LIST(X)
#undef X
  default:
    return 0;
  }
}

const char *experiment_status_name(thrum_status status) {
  switch (status) {
  case THRUM_OK:
    return "done";
  case THRUM_NOT_CONVERGED:
    return "not_converged";
  case THRUM_NOT_FINITE:
    return "not_finite";
  default:
    return status > 0 ? "done" : "failed";
  }
}

const char *experiment_long_status(const experiment_long_result *result) {
  return result->lost ? "lost" : experiment_status_name(result->status);
}

static void add_number(experiment_text *text, double value) {
  if (isfinite(value)) {
    experiment_text_add(text, ",%.10g", value);
  } else {
    experiment_text_add(text, ",");
  }
}

static void add_level_names(experiment_text *text) {
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, ",%s", experiment_level_names[n]);
  experiment_text_add(text, "\n");
}

static void add_levels(experiment_text *text, const thrum_state_report *report) {
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_text_add(text, ",%lld", (long long)experiment_level(report, n));
  experiment_text_add(text, "\n");
}

void experiment_matrix_csv(experiment_text *text, const experiment_run *runs, int64_t count) {
  experiment_text_add(text, "model,load,force_n,damping,integrator,status,simulated_s,us_per_step,"
                            "mean_iterations,energy_peak_j,energy_end_j,high_end_j,energy_change,"
                            "peak_amplitude,explicit_modes,implicit_modes");
  add_level_names(text);
  for (int64_t n = 0; n < count; n++) {
    const experiment_run *run = &runs[n];
    experiment_text_add(text, "%s,%s,%.6g,%g,%s,%s", run->body->name,
                        experiment_load_names[run->load], run->force, run->alpha,
                        experiment_integrator_names[run->integrator],
                        experiment_status_name(run->status));
    const double numbers[] = {run->simulated,     run->us_per_step,   run->mean_iterations,
                              run->energy_peak,   run->energy_end,    run->high_end,
                              run->energy_change, run->peak_amplitude};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    experiment_text_add(text, ",%d,%d", (int)run->report.explicit_modes,
                        (int)run->report.implicit_modes);
    add_levels(text, &run->report);
  }
}

void experiment_curves_csv(experiment_text *text, const experiment_run *runs, int64_t count) {
  experiment_text_add(text, "model,load,damping,integrator,time_s,total_j,high_j,explicit_modes,"
                            "amplitude\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < runs[n].row_count; k++) {
      const experiment_row *row = &runs[n].rows[k];
      experiment_text_add(text, "%s,%s,%g,%s,%.6g,%.10g,%.10g,%g,%.6g\n", runs[n].body->name,
                          experiment_load_names[runs[n].load], runs[n].alpha,
                          experiment_integrator_names[runs[n].integrator], row->time, row->total,
                          row->high, row->explicit_modes, row->amplitude);
    }
  }
}

void experiment_long_csv(experiment_text *text, const experiment_long_case *cases,
                         const experiment_long_result *results, int64_t count) {
  experiment_text_add(text, "model,integrator,amplitude,reached,impulse_ns,dt_s,status,steps,"
                            "us_per_step,energy_j,windows,total_change,total_worst,high_change,"
                            "high_slope_per_s,high_slope_error_per_s,"
                            "high_slope_error_correlated_per_s");
  add_level_names(text);
  for (int64_t n = 0; n < count; n++) {
    const experiment_long_case *run = &cases[n];
    const experiment_long_result *result = &results[n];
    experiment_text_add(text, "%s,%s,%g,%.6g,%.10g,%g,%s,%lld", run->body->name,
                        experiment_integrator_names[run->integrator], run->amplitude, run->reached,
                        run->impulse, run->dt, experiment_long_status(result),
                        (long long)result->report.steps);
    add_number(text, result->us_per_step);
    add_number(text, result->energy);
    experiment_text_add(text, ",%lld", (long long)result->window_count);
    add_number(text, result->total_change);
    add_number(text, result->total_worst);
    add_number(text, result->high_change);
    add_number(text, result->high_slope);
    add_number(text, result->high_slope_error);
    add_number(text, result->high_slope_error_correlated);
    add_levels(text, &result->report);
  }
}

void experiment_windows_csv(experiment_text *text, const experiment_long_case *cases,
                            const experiment_long_result *results, int64_t count) {
  experiment_text_add(text, "model,integrator,amplitude,window,begin_s,total_j,high_j\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < results[n].window_count; k++) {
      experiment_text_add(text, "%s,%s,%g,%lld,%g,%.13g,%.10g\n", cases[n].body->name,
                          experiment_integrator_names[cases[n].integrator], cases[n].amplitude,
                          (long long)k, (double)k * EXPERIMENT_WINDOW_SECONDS, results[n].total[k],
                          results[n].high[k]);
    }
  }
}

void experiment_sweep_csv(experiment_text *text, const experiment_sweep_case *cases,
                          const experiment_sweep_result *results, int64_t count) {
  experiment_text_add(text, "model,integrator,dt_s,status,simulated_s,us_per_step,mean_iterations,"
                            "energy_j,energy_error,energy_change,peak_amplitude");
  add_level_names(text);
  for (int64_t n = 0; n < count; n++) {
    const experiment_sweep_result *result = &results[n];
    experiment_text_add(text, "%s,%s,%g,%s,%.6g", cases[n].body->name,
                        experiment_integrator_names[cases[n].integrator], cases[n].dt,
                        experiment_sweep_status(result), result->simulated);
    add_number(text, result->us_per_step);
    add_number(text, (double)result->report.iterations / (double)result->report.steps);
    add_number(text, result->energy);
    add_number(text, result->energy_error);
    add_number(text, result->energy_change);
    add_number(text, result->peak_amplitude);
    add_levels(text, &result->report);
  }
}

/* A text in quotes, as it may hold a comma. */
static void add_quoted(experiment_text *text, const char *plain) {
  experiment_text_add(text, ",\"");
  for (const char *at = plain; *at != 0; at++)
    experiment_text_add(text, *at == '"' ? "\"\"" : "%c", *at);
  experiment_text_add(text, "\"");
}

void experiment_extremes_csv(experiment_text *text, const experiment_extreme_case *cases,
                             const experiment_extreme_result *results, int64_t count) {
  experiment_text_add(text,
                      "subject,case,integrator,outcome,reason,dt_s,h_omega_first,h_omega_last,"
                      "steps,us_per_step,mean_iterations,work_j,energy_error,energy_end,"
                      "peak_amplitude,explicit_modes,implicit_modes");
  add_level_names(text);
  for (int64_t n = 0; n < count; n++) {
    const experiment_extreme_body *body = cases[n].body;
    const experiment_extreme_result *result = &results[n];
    experiment_text_add(text, "%s", experiment_subject_names[body->extreme->subject]);
    add_quoted(text, body->extreme->name);
    experiment_text_add(text, ",%s,%s", experiment_integrator_names[cases[n].integrator],
                        experiment_extreme_outcome(&cases[n], result));
    add_quoted(text, result->status < 0 ? result->stop.message : "");
    const double numbers[] = {body->dt, body->dt * body->omega[0], body->dt * body->omega[1]};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    experiment_text_add(text, ",%lld", (long long)result->report.steps);
    const double figures[] = {
        result->us_per_step, (double)result->report.iterations / (double)result->report.steps,
        result->work,        result->energy_error,
        result->energy_end,  result->peak_amplitude};
    for (size_t k = 0; k < sizeof figures / sizeof figures[0]; k++)
      add_number(text, figures[k]);
    experiment_text_add(text, ",%d,%d", (int)result->report.explicit_modes,
                        (int)result->report.implicit_modes);
    add_levels(text, &result->report);
  }
}

void experiment_units_csv(experiment_text *text, const experiment_unit_case *cases,
                          const experiment_unit_result *results, int64_t count) {
  experiment_text_add(text, "units,case,integrator,steps,difference,iterations,iterations_si,"
                            "same_levels\n");
  for (int64_t n = 0; n < count; n++) {
    // the names hold commas
    experiment_text_add(text, "\"%s\"", cases[n].units->name);
    add_quoted(text, cases[n].extreme->name);
    experiment_text_add(text, ",%s,%lld", experiment_integrator_names[cases[n].integrator],
                        (long long)cases[n].steps);
    add_number(text, results[n].difference);
    experiment_text_add(text, ",%lld,%lld,%d\n", (long long)results[n].iterations,
                        (long long)results[n].iterations_si, results[n].same_levels);
  }
}

void experiment_linear_csv(experiment_text *text, const experiment_body *bodies,
                           const experiment_linear_result *results, int64_t count) {
  experiment_text_add(text,
                      "model,rank,static_5,static_20,dynamic_5,dynamic_20,static_5_n,static_20_n,"
                      "dynamic_5_ns,dynamic_20_ns,force_us,step_us,linear_step_us,nonlinear_us\n");
  for (int64_t n = 0; n < count; n++) {
    const experiment_linear_result *result = &results[n];
    const experiment_linear_point *rest = result->statics.at, *motion = result->dynamics.at;
    const double numbers[] = {
        rest[0].amplitude,   rest[1].amplitude, motion[0].amplitude,
        motion[1].amplitude, rest[0].load,      rest[1].load,
        motion[0].load,      motion[1].load,    result->force_us,
        result->step_us,     result->linear_us, result->step_us - result->linear_us};
    experiment_text_add(text, "%s,%lld", bodies[n].name, (long long)bodies[n].model->rank);
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    experiment_text_add(text, "\n");
  }
}

void experiment_linear_curves_csv(experiment_text *text, const experiment_body *bodies,
                                  const experiment_linear_result *results, int64_t count) {
  experiment_text_add(text, "model,kind,load,deflection,error\n");
  for (int64_t n = 0; n < count; n++) {
    const experiment_linear_curve *curves[2] = {&results[n].statics, &results[n].dynamics};
    for (int c = 0; c < 2; c++)
      for (int64_t k = 0; k < curves[c]->count; k++) {
        const experiment_linear_point *point = &curves[c]->points[k];
        experiment_text_add(text, "%s,%s,%.10g,%.10g,%.10g\n", bodies[n].name,
                            c == 0 ? "static" : "dynamic", point->load, point->amplitude,
                            point->error);
      }
  }
}
