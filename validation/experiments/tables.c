/* Results as comma-separated tables; a number that is not there is left empty.
 * SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/tables.h"

#include <math.h>

const char *const study_rung_names[STUDY_RUNG_COUNT] = {
#define X(name, field, heading) #name,
    STUDY_RUNG_LIST(X)
#undef X
};

const char *const study_rung_headings[STUDY_RUNG_COUNT] = {
#define X(name, field, heading) heading,
    STUDY_RUNG_LIST(X)
#undef X
};

int64_t study_rung(const thrum_state_report *report, int rung) {
  switch (rung) {
#define X(name, field, heading)                                                                    \
  case STUDY_RUNG_##name:                                                                          \
    return report->field;
    STUDY_RUNG_LIST(X)
#undef X
  default:
    return 0;
  }
}

const char *study_status_name(thrum_status status) {
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

const char *study_long_status(const study_long_result *result) {
  return result->lost ? "lost" : study_status_name(result->status);
}

static void add_number(study_text *text, double value) {
  if (isfinite(value)) {
    study_text_add(text, ",%.10g", value);
  } else {
    study_text_add(text, ",");
  }
}

static void add_rung_names(study_text *text) {
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, ",%s", study_rung_names[n]);
  study_text_add(text, "\n");
}

static void add_rungs(study_text *text, const thrum_state_report *report) {
  for (int n = 0; n < STUDY_RUNG_COUNT; n++)
    study_text_add(text, ",%lld", (long long)study_rung(report, n));
  study_text_add(text, "\n");
}

void study_matrix_csv(study_text *text, const study_run *runs, int64_t count) {
  study_text_add(text, "model,load,force_n,damping,integrator,status,simulated_s,us_per_step,"
                       "mean_iterations,energy_peak_j,energy_end_j,high_end_j,energy_change,"
                       "peak_amplitude,explicit_modes,implicit_modes");
  add_rung_names(text);
  for (int64_t n = 0; n < count; n++) {
    const study_run *run = &runs[n];
    study_text_add(text, "%s,%s,%.6g,%g,%s,%s", run->body->name, study_load_names[run->load],
                   run->force, run->alpha, study_integrator_names[run->integrator],
                   study_status_name(run->status));
    const double numbers[] = {run->simulated,     run->us_per_step,   run->mean_iterations,
                              run->energy_peak,   run->energy_end,    run->high_end,
                              run->energy_change, run->peak_amplitude};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    study_text_add(text, ",%d,%d", (int)run->report.explicit_modes,
                   (int)run->report.implicit_modes);
    add_rungs(text, &run->report);
  }
}

void study_curves_csv(study_text *text, const study_run *runs, int64_t count) {
  study_text_add(text, "model,load,damping,integrator,time_s,total_j,high_j,explicit_modes,"
                       "amplitude\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < runs[n].row_count; k++) {
      const study_row *row = &runs[n].rows[k];
      study_text_add(text, "%s,%s,%g,%s,%.6g,%.10g,%.10g,%g,%.6g\n", runs[n].body->name,
                     study_load_names[runs[n].load], runs[n].alpha,
                     study_integrator_names[runs[n].integrator], row->time, row->total, row->high,
                     row->explicit_modes, row->amplitude);
    }
  }
}

void study_long_csv(study_text *text, const study_long_case *cases,
                    const study_long_result *results, int64_t count) {
  study_text_add(text, "model,integrator,amplitude,reached,impulse_ns,dt_s,status,steps,"
                       "us_per_step,energy_j,windows,total_change,total_worst,high_change,"
                       "high_slope_per_s,high_slope_error_per_s,"
                       "high_slope_error_correlated_per_s");
  add_rung_names(text);
  for (int64_t n = 0; n < count; n++) {
    const study_long_case *run = &cases[n];
    const study_long_result *result = &results[n];
    study_text_add(text, "%s,%s,%g,%.6g,%.10g,%g,%s,%lld", run->body->name,
                   study_integrator_names[run->integrator], run->amplitude, run->reached,
                   run->impulse, run->dt, study_long_status(result),
                   (long long)result->report.steps);
    add_number(text, result->us_per_step);
    add_number(text, result->energy);
    study_text_add(text, ",%lld", (long long)result->window_count);
    add_number(text, result->total_change);
    add_number(text, result->total_worst);
    add_number(text, result->high_change);
    add_number(text, result->high_slope);
    add_number(text, result->high_slope_error);
    add_number(text, result->high_slope_error_correlated);
    add_rungs(text, &result->report);
  }
}

void study_windows_csv(study_text *text, const study_long_case *cases,
                       const study_long_result *results, int64_t count) {
  study_text_add(text, "model,integrator,amplitude,window,begin_s,total_j,high_j\n");
  for (int64_t n = 0; n < count; n++) {
    for (int64_t k = 0; k < results[n].window_count; k++) {
      study_text_add(text, "%s,%s,%g,%lld,%g,%.13g,%.10g\n", cases[n].body->name,
                     study_integrator_names[cases[n].integrator], cases[n].amplitude, (long long)k,
                     (double)k * STUDY_WINDOW_SECONDS, results[n].total[k], results[n].high[k]);
    }
  }
}

void study_sweep_csv(study_text *text, const study_sweep_case *cases,
                     const study_sweep_result *results, int64_t count) {
  study_text_add(text, "model,integrator,dt_s,status,simulated_s,us_per_step,mean_iterations,"
                       "energy_j,energy_error,energy_change,peak_amplitude");
  add_rung_names(text);
  for (int64_t n = 0; n < count; n++) {
    const study_sweep_result *result = &results[n];
    study_text_add(text, "%s,%s,%g,%s,%.6g", cases[n].body->name,
                   study_integrator_names[cases[n].integrator], cases[n].dt,
                   study_sweep_status(result), result->simulated);
    add_number(text, result->us_per_step);
    add_number(text, (double)result->report.iterations / (double)result->report.steps);
    add_number(text, result->energy);
    add_number(text, result->energy_error);
    add_number(text, result->energy_change);
    add_number(text, result->peak_amplitude);
    add_rungs(text, &result->report);
  }
}

/* A text in quotes, as it may hold a comma. */
static void add_quoted(study_text *text, const char *plain) {
  study_text_add(text, ",\"");
  for (const char *at = plain; *at != 0; at++)
    study_text_add(text, *at == '"' ? "\"\"" : "%c", *at);
  study_text_add(text, "\"");
}

void study_extremes_csv(study_text *text, const study_extreme_case *cases,
                        const study_extreme_result *results, int64_t count) {
  study_text_add(text, "subject,case,integrator,outcome,reason,dt_s,h_omega_first,h_omega_last,"
                       "steps,us_per_step,mean_iterations,work_j,energy_error,energy_end,"
                       "peak_amplitude,explicit_modes,implicit_modes");
  add_rung_names(text);
  for (int64_t n = 0; n < count; n++) {
    const study_extreme_body *body = cases[n].body;
    const study_extreme_result *result = &results[n];
    study_text_add(text, "%s", study_subject_names[body->extreme->subject]);
    add_quoted(text, body->extreme->name);
    study_text_add(text, ",%s,%s", study_integrator_names[cases[n].integrator],
                   study_extreme_outcome(&cases[n], result));
    add_quoted(text, result->status < 0 ? result->stop.message : "");
    const double numbers[] = {body->dt, body->dt * body->omega[0], body->dt * body->omega[1]};
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    study_text_add(text, ",%lld", (long long)result->report.steps);
    const double figures[] = {
        result->us_per_step, (double)result->report.iterations / (double)result->report.steps,
        result->work,        result->energy_error,
        result->energy_end,  result->peak_amplitude};
    for (size_t k = 0; k < sizeof figures / sizeof figures[0]; k++)
      add_number(text, figures[k]);
    study_text_add(text, ",%d,%d", (int)result->report.explicit_modes,
                   (int)result->report.implicit_modes);
    add_rungs(text, &result->report);
  }
}

void study_units_csv(study_text *text, const study_unit_case *cases,
                     const study_unit_result *results, int64_t count) {
  study_text_add(text, "units,case,integrator,steps,difference,iterations,iterations_si,"
                       "same_rungs\n");
  for (int64_t n = 0; n < count; n++) {
    // the names hold commas
    study_text_add(text, "\"%s\"", cases[n].units->name);
    add_quoted(text, cases[n].extreme->name);
    study_text_add(text, ",%s,%lld", study_integrator_names[cases[n].integrator],
                   (long long)cases[n].steps);
    add_number(text, results[n].difference);
    study_text_add(text, ",%lld,%lld,%d\n", (long long)results[n].iterations,
                   (long long)results[n].iterations_si, results[n].same_rungs);
  }
}

void study_linear_csv(study_text *text, const study_body *bodies,
                      const study_linear_result *results, int64_t count) {
  study_text_add(text, "model,rank,static_5,static_20,dynamic_5,dynamic_20,static_5_n,static_20_n,"
                       "dynamic_5_ns,dynamic_20_ns,force_us,step_us,linear_step_us,nonlinear_us\n");
  for (int64_t n = 0; n < count; n++) {
    const study_linear_result *result = &results[n];
    const study_linear_point *rest = result->statics.at, *motion = result->dynamics.at;
    const double numbers[] = {
        rest[0].amplitude,   rest[1].amplitude, motion[0].amplitude,
        motion[1].amplitude, rest[0].load,      rest[1].load,
        motion[0].load,      motion[1].load,    result->force_us,
        result->step_us,     result->linear_us, result->step_us - result->linear_us};
    study_text_add(text, "%s,%lld", bodies[n].name, (long long)bodies[n].model->rank);
    for (size_t k = 0; k < sizeof numbers / sizeof numbers[0]; k++)
      add_number(text, numbers[k]);
    study_text_add(text, "\n");
  }
}

void study_linear_curves_csv(study_text *text, const study_body *bodies,
                             const study_linear_result *results, int64_t count) {
  study_text_add(text, "model,kind,load,deflection,error\n");
  for (int64_t n = 0; n < count; n++) {
    const study_linear_curve *curves[2] = {&results[n].statics, &results[n].dynamics};
    for (int c = 0; c < 2; c++)
      for (int64_t k = 0; k < curves[c]->count; k++) {
        const study_linear_point *point = &curves[c]->points[k];
        study_text_add(text, "%s,%s,%.10g,%.10g,%.10g\n", bodies[n].name,
                       c == 0 ? "static" : "dynamic", point->load, point->amplitude, point->error);
      }
  }
}
