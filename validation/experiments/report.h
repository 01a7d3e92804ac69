/* Reports: one HTML page each, with nothing outside it. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_REPORT_H
#define THRUM_VALIDATION_EXPERIMENTS_REPORT_H

#include "validation/experiments/svg_plot.h"
#include "validation/experiments/tables.h"

/* Where the figures were made; borrowed texts. */
typedef struct experiment_place {
  const char *machine;
  const char *compiler;
  const char *blas_core;
  const char *command;
} experiment_place;

extern const char *const experiment_colors[EXPERIMENT_INTEGRATOR_COUNT];

/* The page around a report: up to its first paragraph, and its end. */
void experiment_page_begin(experiment_text *text, const char *title, const experiment_place *place);
void experiment_page_end(experiment_text *text);

/* A cell of a table: the number, or a dash where there is none. */
__attribute__((format(printf, 2, 0))) void experiment_cell(experiment_text *text,
                                                           const char *format, double value);

/* The runs by body, load, damping, integrator, as experiment_matrix_run leaves them. */
void experiment_matrix_report(experiment_text *text, const experiment_run *runs, int64_t count,
                              double dt, const experiment_place *place);

/* The cases by body, amplitude, integrator. */
void experiment_long_report(experiment_text *text, const experiment_long_case *cases,
                            const experiment_long_result *results, int64_t count,
                            const experiment_place *place);

/* The cases by body, time step, integrator. */
void experiment_sweep_report(experiment_text *text, const experiment_sweep_case *cases,
                             const experiment_sweep_result *results, int64_t count,
                             const experiment_place *place);

/* The cases by body, integrator; the units by body, system, integrator. */
void experiment_extremes_report(experiment_text *text, const experiment_extreme_case *cases,
                                const experiment_extreme_result *results, int64_t count,
                                const experiment_unit_case *units,
                                const experiment_unit_result *unit_results, int64_t unit_count,
                                const experiment_place *place);

/* Linear against nonlinear, by body. */
void experiment_linear_report(experiment_text *text, const experiment_body *bodies,
                              const experiment_linear_result *results, int64_t count,
                              const experiment_place *place);

#endif
