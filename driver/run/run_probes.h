/* Places of a body that a run follows: the mean displacement of targets, as rows of probes.csv, a
 * plot, and what is said of them at the end. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_RUN_PROBES_H
#define THRUM_DRIVER_RUN_RUN_PROBES_H

#include <cjson/cJSON.h>
#include <stdio.h>

#include "driver/record/run_folder.h"
#include "driver/run/simulate_options.h"
#include "io/report.h"

/* A target that is followed. */
typedef struct run_probe {
  char text[LOAD_TEXT_MAX]; /* as the user named it, fit for a terminal */
  load_vertices at;
  double last[3];                 /* mean displacement [m] */
  double farthest, farthest_time; /* its largest length [m], and when [s] */
  double low[3], high[3];         /* its range along each axis [m] */
} run_probe;

/* A zeroed one follows nothing. */
typedef struct run_probes {
  const thrum_model *model;
  run_probe *list;
  int64_t count;
  bool full;     /* rows are displacements of the mesh */
  double *field; /* 3 vertex_count [m], in which the caller puts them; of the full order alone */
  FILE *rows;
  int64_t row_count;
  const char *plot; /* the plot's file name once drawn; NULL: none */
} run_probes;

#define RUN_PROBES_CSV "probes.csv"

/* Finds what the request follows, or, where it names nothing, where its loads act, and opens the
 * file. On failure nothing is left to free. */
thrum_status run_probes_open(const simulate_request *request, const thrum_model *model,
                             const run_folder *folder, run_probes *probes, thrum_error *error);

/* A row at coordinates q (rank), or of the displacements in `field`. */
thrum_status run_probes_record(run_probes *probes, const run_folder *folder, int64_t step,
                               double time, const double *q, thrum_error *error);

/* Ends the file. */
thrum_status run_probes_end(run_probes *probes, const run_folder *folder, thrum_error *error);

/* Draws of each probe the axis along which it moves furthest, where gnuplot is installed. */
void run_probes_plot(run_probes *probes, const run_folder *folder, const char *title);

/* "probes" of a report, a row each; and the line of each in the table. */
void run_probes_json(const run_probes *probes, cJSON *object);
extern const report_line run_probes_lines[];

void run_probes_close(run_probes *probes);

#endif
