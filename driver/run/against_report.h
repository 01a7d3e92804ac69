/* What was found of a run beside the whole mesh, and how it is told.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_AGAINST_REPORT_H
#define THRUM_DRIVER_RUN_AGAINST_REPORT_H

#include <cjson/cJSON.h>

#include "driver/run/simulate_options.h"
#include "io/report.h"

#define AGAINST_MESH_CSV "against_mesh.csv"

/* Errors are root mean squares over the mesh, in the norm of its mass, and over time so far, over
 * those of the mesh's own motion. A zeroed one was not asked for. */
typedef struct against_mesh {
  bool asked;
  bool whole;             /* the mesh was stepped to the end */
  const char *ended;      /* why not; NULL: it was, or nothing more is known */
  int64_t steps;          /* of the mesh */
  double time;            /* the same [s] */
  double displacement;    /* NaN: nothing moved */
  double velocity;        /* the same */
  double seconds;         /* that it took */
  const char *stepped_by; /* the integrator of the mesh */
  const char *plot;       /* the plot's file name once drawn; NULL: none */
} against_mesh;

/* "against_mesh" of the report, null where it was not asked for; and the lines of the table. */
void against_mesh_json(const against_mesh *against, cJSON *object);
extern const report_line against_mesh_lines[];

/* Is the error that was found larger than what is accepted? */
bool against_mesh_is_large(const against_mesh *against, const basis_asked *asked);

#endif
