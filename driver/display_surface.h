/* The surface of a model's mesh as triangles (what is shown is driver/render_mesh.h), and the
 * motion of a finished run, for other programs. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_DISPLAY_SURFACE_H
#define THRUM_DRIVER_DISPLAY_SURFACE_H

#include <stdbool.h>

#include "driver/run_placement.h"
#include "thrum/thrum.h"

/* Triangles between a tet and nothing, outwards counter-clockwise. */
typedef struct cli_skin {
  int64_t vertex_count;
  int32_t *vertices; /* vertex_count: 0-based vertices of the model, ascending */
  int64_t triangle_count;
  int32_t *triangles; /* triangle_count x 3: 0-based places in `vertices` */
} cli_skin;
thrum_status cli_skin_make(const thrum_model *model, cli_skin *skin, thrum_error *error);
void cli_skin_free(cli_skin *skin);

/* What `thrum simulate` left in a folder. */
typedef struct cli_run {
  const thrum_model *model;
  int64_t rank; /* of q: the run's, at most the model's */
  int64_t rows;
  double *times; /* rows, ascending [s] */
  double *q;     /* rows x rank */
  cli_run_place place;
  double *places; /* rows x CLI_RUN_PLACE; NULL: the body stays where it stands */
} cli_run;

/* Is there a run.json in the folder? */
bool cli_is_run(const char *path);

/* Reads RUN/run.json, energy.csv (times), q.npy and the model: `model` when it is not NULL, else
 * the one that run.json names, from here or from beside RUN. Refuses a model whose bytes are not
 * those that the run was made with. cli_run_free frees, the model too. */
thrum_status cli_run_read(const char *path, const char *model, cli_run *run, thrum_error *error);
void cli_run_free(cli_run *run);

/* Keeps the rows that are nearest to `rate` a second, none twice, and the last; 0: all. */
void cli_run_thin(cli_run *run, double rate);

#endif
