/* The files of a run, written as it goes. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_OUTPUT_H
#define THRUM_DRIVER_RECORD_RUN_OUTPUT_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "driver/record/run_folder.h"
#include "io/vtu.h"
#include "thrum/thrum.h"

typedef struct run_output {
  run_folder folder;
  const thrum_model *model;
  FILE *energy; /* energy.csv */
  FILE *q;      /* q.npy; its header is written last, when the rows are counted */
  FILE *places; /* places.npy, the same; NULL: the body stays where it stands */
  int64_t rows;
  pvd_file pvd;
  double *displacement; /* vertex_count x 3; NULL: no frames */
  int64_t frames;
  bool moved;       /* places.npy is written */
  bool end;         /* end.npy is written */
  const char *plot; /* the plot's file name once drawn; NULL: none */
} run_output;

/* Opens a series of rows in the folder, an array of doubles whose number of rows is not known yet;
 * and puts the number into its header and closes it, whatever comes of it. NULL, or false, and
 * errno where that fails. */
FILE *run_series_open(const run_folder *folder, const char *name, int64_t columns);
bool run_series_close(FILE **series, int64_t rows, int64_t columns);

/* Makes the work folder and opens the series; frames need a model with a mesh and a basis.
 * `inside`: the body is part of a scene, and `path` is in the scene's work folder. On failure
 * nothing is left behind. */
thrum_status run_output_open(const char *path, const thrum_model *model, bool frames, bool inside,
                             run_output *output, thrum_error *error);

/* Opens places.npy, for the body of a scene that moves as a whole; before the first row. */
thrum_status run_output_open_places(run_output *output, thrum_error *error);
/* Writes a row of places.npy, after that of q.npy; `matrix`: see thrum_scene_body_matrix. */
thrum_status run_output_place(run_output *output, const double matrix[16], thrum_error *error);

/* A row of energy.csv and of q.npy. */
thrum_status run_output_record(run_output *output, int64_t step, double time, const double *q,
                               const thrum_energies *energies, thrum_error *error);

/* A frame for ParaView of the displacements in output->displacement, to each of which `base` [m] is
 * added. stress may be NULL. */
thrum_status run_output_frame(run_output *output, double time, const double base[3],
                              const vtu_stress *stress, thrum_error *error);

/* Ends the series and writes end.npy: the two rows q and p. q NULL: there is no end to write. */
thrum_status run_output_end(run_output *output, const double *q, const double *p,
                            thrum_error *error);

/* Draws the energy plot where gnuplot is installed; without one the run is complete all the same.
 */
void run_output_plot(run_output *output, const char *title);

/* Writes run.json and puts the run in place. */
thrum_status run_output_commit(run_output *output, const cJSON *figures, thrum_error *error);

/* Removes what is not committed and frees; fine after commit and on a zeroed output. */
void run_output_close(run_output *output);

#endif
