/* The files of a run, written as it goes. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_OUTPUT_H
#define THRUM_DRIVER_RUN_OUTPUT_H

#include <cjson/cJSON.h>
#include <stdint.h>
#include <stdio.h>

#include "driver/run_folder.h"
#include "io/vtu.h"
#include "thrum/thrum.h"

typedef struct cli_run_output {
  cli_run_folder folder;
  const thrum_model *model;
  FILE *energy; /* energy.csv */
  FILE *q;      /* q.npy; its header is written last, when the rows are counted */
  FILE *places; /* places.npy, the same; NULL: the body stays where it stands */
  int64_t rows;
  cli_pvd pvd;
  double *displacement; /* vertex_count x 3; NULL: no frames */
  int64_t frames;
  bool moved;       /* places.npy is written */
  bool end;         /* end.npy is written */
  const char *plot; /* the plot's file name once drawn; NULL: none */
} cli_run_output;

/* Makes the work folder and opens the series; frames need a model with a mesh and a basis. On
 * failure nothing is left behind. */
thrum_status cli_run_output_open(const char *path, const thrum_model *model, bool frames,
                                 cli_run_output *output, thrum_error *error);

/* Opens places.npy, for the body of a scene that moves as a whole; before the first row. */
thrum_status cli_run_output_open_places(cli_run_output *output, thrum_error *error);
/* Its row, after that of q.npy; `matrix`: see thrum_scene_body_matrix. */
thrum_status cli_run_output_place(cli_run_output *output, const double matrix[16],
                                  thrum_error *error);

/* A row of energy.csv and of q.npy. */
thrum_status cli_run_output_record(cli_run_output *output, int64_t step, double time,
                                   const double *q, const thrum_energies *energies,
                                   thrum_error *error);

/* A frame for ParaView of the displacements in output->displacement, to each of which `base` [m] is
 * added. von_mises: tet_count [Pa], or NULL. */
thrum_status cli_run_output_frame(cli_run_output *output, double time, const double base[3],
                                  const double *von_mises, thrum_error *error);

/* Ends the series and writes end.npy: the two rows q and p. q NULL: there is no end to write. */
thrum_status cli_run_output_end(cli_run_output *output, const double *q, const double *p,
                                thrum_error *error);

/* Draws the energy plot where gnuplot is installed; without one the run is complete all the same.
 */
void cli_run_output_plot(cli_run_output *output, const char *title);

/* Writes run.json and puts the run in place. */
thrum_status cli_run_output_commit(cli_run_output *output, const cJSON *figures,
                                   thrum_error *error);

/* Removes what is not committed and frees; fine after commit and on a zeroed output. */
void cli_run_output_close(cli_run_output *output);

#endif
