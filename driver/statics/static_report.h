/* The answer of `thrum static` and its forms.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_REPORT_H
#define THRUM_DRIVER_STATICS_STATIC_REPORT_H

#include "driver/model/basis_estimate.h"
#include "driver/model/node_stress.h"
#include "driver/statics/static_forces.h"
#include "driver/statics/static_options.h"
#include "io/vtu.h"

/* How far the answer of a reduced model can be believed; NaN: not looked at. */
typedef struct static_belief {
  uint32_t warnings; /* thrum_warning */
  double stretch;    /* least of the sampled tetrahedra */
  bool judged;       /* the monitor is on for a reduced model */
  basis_estimate error;
} static_belief;

typedef struct static_answer {
  const static_request *request;
  const thrum_model *model;
  thrum_equilibrium_report report;
  const double *q;        /* rank */
  const double *mode;     /* rank */
  double (*displaced)[3]; /* target_count: mean displacement [m] */
  double peak;            /* largest displacement [m]; NaN without a basis */
  int64_t peak_vertex;    /* 0-based, -1: none */
  double seconds;         /* of the search */
  int64_t components;     /* of the full order */
  static_belief belief;
  static_forces forces;
  node_stress stress;

  /* How well the critical load is known; NaN: there is none. */
  double critical_from, critical_to; /* factors between which it lies */
  double critical_share;             /* least eigenvalue at the former over that at the start */
  double least_start;                /* the latter [1/s^2] */
  double critical_mesh;              /* where the mesh of a model would lose it, extrapolated */
  double lost_at; /* factor beyond which the branch was not followed; NaN: it was */

  double lower_energy; /* of a shape of body and load that has less [J]; NaN: none was found */
} static_answer;

/* What flags the answer: "inverted", "higher", "unstable", "snapped", "buckled", "lost" or
 * "basis_wrong"; NULL: nothing does. */
const char *static_flag(const static_answer *answer);

/* Looks at the stress at displacements u (3 vertex_count) of a model of the law that they are of,
 * which may go afterwards; passed over where the material flows or the model has no mesh. */
thrum_status static_stress_look(const thrum_model *model, const double *u, node_stress *stress,
                                thrum_error *error);

/* The stress for a frame; all NULL: none. */
vtu_stress static_stress_frame(const node_stress *stress);

/* Was the stability of the path looked at? */
bool static_was_watched(const static_answer *answer);

/* Prints the answer as an object, or as the table that is made of it. */
void static_report_print(const static_answer *answer, bool json);

#endif
