/* Reports: one HTML page each, with nothing outside it. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_REPORT_H
#define THRUM_VALIDATION_EXPERIMENTS_REPORT_H

#include "validation/experiments/svg_plot.h"
#include "validation/experiments/tables.h"

/* Where the figures were made; borrowed texts. */
typedef struct study_place {
  const char *machine;
  const char *compiler;
  const char *blas_core;
  const char *command;
} study_place;

extern const char *const study_colors[STUDY_INTEGRATOR_COUNT];

/* The page around a report: up to its first paragraph, and its end. */
void study_page_begin(study_text *text, const char *title, const study_place *place);
void study_page_end(study_text *text);

/* A cell of a table: the number, or a dash where there is none. */
__attribute__((format(printf, 2, 0))) void study_cell(study_text *text, const char *format,
                                                      double value);

/* The runs by body, load, damping, integrator, as study_matrix_run leaves them. */
void study_matrix_report(study_text *text, const study_run *runs, int64_t count, double dt,
                         const study_place *place);

/* The cases by body, amplitude, integrator. */
void study_long_report(study_text *text, const study_long_case *cases,
                       const study_long_result *results, int64_t count, const study_place *place);

/* The cases by body, time step, integrator. */
void study_sweep_report(study_text *text, const study_sweep_case *cases,
                        const study_sweep_result *results, int64_t count, const study_place *place);

/* The cases by body, integrator; the units by body, system, integrator. */
void study_extremes_report(study_text *text, const study_extreme_case *cases,
                           const study_extreme_result *results, int64_t count,
                           const study_unit_case *units, const study_unit_result *unit_results,
                           int64_t unit_count, const study_place *place);

/* Linear against nonlinear, by body. */
void study_linear_report(study_text *text, const study_body *bodies,
                         const study_linear_result *results, int64_t count,
                         const study_place *place);

#endif
