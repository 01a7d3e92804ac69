/* A run of a reduced model beside the whole mesh, stepped as far as a time allows.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_AGAINST_MESH_H
#define THRUM_DRIVER_RUN_AGAINST_MESH_H

#include "driver/record/run_folder.h"
#include "driver/run/against_report.h"

/* Steps the model again and the mesh beside it, for request->against_mesh seconds or until the user
 * stops it, and writes rows into the folder. shape: the model with its mesh; stepped: the same, or
 * what is condensed of it. A mesh that cannot be stepped is no failure, but told. */
thrum_status against_mesh_run(const simulate_request *request, const thrum_model *shape,
                              const thrum_model *stepped, const run_folder *folder,
                              against_mesh *against, thrum_error *error);

/* Draws the rows, where gnuplot is installed. */
void against_mesh_plot(const run_folder *folder, const char *title, against_mesh *against);

#endif
