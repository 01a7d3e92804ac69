/* Von Mises' stress at the nodes of a body, its peak, and how both are said.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_NODE_STRESS_H
#define THRUM_DRIVER_MODEL_NODE_STRESS_H

#include <cjson/cJSON.h>

#include "io/report.h"
#include "precompute/fem/solid_stress.h"
#include "precompute/model/model_fem.h"
#include "thrum/thrum.h"

/* A zeroed one knows nothing. */
typedef struct node_stress {
  void *memory;
  const thrum_stress_nodes *nodes; /* NULL: none */
  thrum_model_fem body;            /* of a model of solids */
  thrum_solid_stresses solids;
  bool patches;               /* averages of patches of linear tetrahedra */
  int64_t count;              /* pairs of a vertex and a region */
  double *work;               /* owned; holds the arrays below */
  double *cauchy, *von_mises; /* of each pair of a vertex and a region */
  double *largest;            /* vertex_count: the largest of its regions [Pa] */
  double *u;                  /* 3 vertex_count [m], for who has coordinates alone */
  double peak;                /* of all looks [Pa]; NaN: none yet */
  int64_t peak_node;          /* of `nodes`; -1: none yet */
  double peak_time;           /* [s] */
  double peak_place[3];       /* of the vertex at rest [m] */
} node_stress;

/* Plans for a model with a mesh, which must stay. On failure nothing is left to free. */
thrum_status node_stress_open(const thrum_model *model, node_stress *stress, thrum_error *error);

/* Looks at displacements of all vertices (3 vertex_count) of the same model. */
thrum_status node_stress_look(const thrum_model *model, const double *u, double time,
                              node_stress *stress, thrum_error *error);

/* Adds the peak to an object: value, vertex (from 1), place, region (from 1), and what it is. */
void node_stress_json(const node_stress *stress, cJSON *object);

/* The lines of a table about "stress" of its report. */
extern const report_line node_stress_lines[];

bool node_stress_is_open(const node_stress *stress);
void node_stress_close(node_stress *stress);

#endif
