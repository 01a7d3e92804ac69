/* Measures of a run on the body: stress in all tetrahedra, and monitors of where the model
 * can be believed. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_SIMULATE_MEASURES_H
#define THRUM_DRIVER_RUN_SIMULATE_MEASURES_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "driver/model/node_stress.h"
#include "driver/run/basis_record.h"
#include "driver/run/simulate_options.h"
#include "thrum/thrum.h"

/* A zeroed one measures nothing. */
typedef struct simulate_measures {
  void *stress_points_memory, *monitor_memory;
  const thrum_stress_points *stress_points; /* NULL: no --stress, or of solids */
  double *work, *von_mises;                 /* tet_count of the latter, at their centres [Pa] */
  node_stress nodes;                        /* at the nodes of the mesh, with --stress */
  const thrum_model *model;                 /* of the run, whose mesh they are of */
  thrum_model field_model; /* of the full order: its only coordinate is the displacement, in */
  double *field;      /* 3 vertex_count [m], which is filled before each look; NULL: q is read */
  double peak_stress; /* largest of the centres, rows and frames [Pa]; NaN: none yet */
  int64_t peak_tet;   /* 0-based */
  double peak_time;
  const thrum_monitor *monitor; /* NULL: --monitor off, or no mesh */
  thrum_monitor_record record;
  double stretch_time;  /* of the least stretch [s] */
  double warned_at[32]; /* when each bit was first raised [s] */
  double load_share;    /* largest of the loads but gravity; NaN: none */
  double warns_below;   /* principal stretch */
  bool basis_asked;     /* the basis is judged, or told why not */
  bool basis_found;     /* its error was found over the whole run, so no estimate is warned of */
  basis_record basis;
} simulate_measures;

/* Plans what the request asks for and looks at its loads. On failure nothing is left to free. */
thrum_status simulate_measures_open(const simulate_request *request, const thrum_model *model,
                                    simulate_measures *measures, thrum_error *error);

/* Whether anything is measured. */
bool simulate_measures_are_open(const simulate_measures *measures);

/* Looks at q at `time`; von_mises holds the stresses then. */
thrum_status simulate_measures_look(simulate_measures *measures, const double *q, double time,
                                    thrum_error *error);

/* Adds "stress", "error_estimate" and "monitor" of a run that ends there [s] to the object, null
 * where there is none. */
void simulate_measures_json(const simulate_measures *measures, double end, cJSON *object);

/* A line on standard error for each warning; each begins with `who`, the body of a scene, or "". */
void simulate_measures_warn(const simulate_measures *measures, const char *who);

void simulate_measures_close(simulate_measures *measures);

#endif
