/* What holds a body at rest, and whether it is a body still: reaction forces and tetrahedra that
 * are turned inside out. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_FORCES_H
#define THRUM_DRIVER_STATICS_STATIC_FORCES_H

#include <cjson/cJSON.h>

#include "driver/statics/static_options.h"
#include "io/report.h"

/* Forces on some vertices, and their moment about the origin where the vertices are now. */
typedef struct static_resultant {
  double force[3], moment[3]; /* [N], [N m] */
  double size;                /* sum of the lengths of the forces, of gravity the weight [N] */
  int64_t vertices;
} static_resultant;

/* Of one group all of whose vertices are held, or of a --move or --rotate. */
typedef struct static_group {
  const char *option; /* "move", "rotate"; NULL: a group of the model */
  const char *name;
  static_resultant sum;
} static_group;

/* A zeroed one knows nothing. */
typedef struct static_forces {
  bool known;
  static_resultant held, load;    /* all that holds the body, and all loads */
  double left[3], left_moment[3]; /* of both together: what is not balanced */
  static_group *groups;           /* group_count; owned */
  int64_t group_count;
  int64_t inverted;     /* tetrahedra that are turned inside out */
  int64_t inverted_tet; /* 0-based, the worst of them */
} static_forces;

void static_forces_free(static_forces *forces);

/* A body at rest: displacements, internal forces and loads of all components (3 vertex_count each),
 * and what is held (vertex_count, bits 0, 1, 2 of x, y, z), of which the reactions are internal
 * less loads. */
typedef struct static_body {
  const thrum_model *model;
  const double *u, *internal, *loads;
  const uint8_t *held;
} static_body;

/* Sums reactions; writes those of each held vertex where the request says. On failure nothing is
 * left to free. THRUM_NOT_CONVERGED where a file is asked for, and the forces of a reduced model
 * leave over more than all of the load. */
thrum_status static_forces_sum(const static_request *request, const static_body *body,
                               static_forces *forces, thrum_error *error);

/* The same of a reduced answer, by the mesh that the model keeps; the loads at their factor. A
 * model without a mesh and a basis is passed over. */
thrum_status static_forces_reduced(const static_request *request, const thrum_model *model,
                                   const double *q, static_forces *forces, thrum_error *error);

/* THRUM_MISSING where --reactions asks for those of such a model. */
thrum_status static_forces_check(const static_request *request, const thrum_model *model,
                                 thrum_error *error);

/* What is not balanced, of the forces that act. */
double static_forces_left(const static_forces *forces);

/* Warns of reactions of a reduced model that leave over more than a tenth of the load. */
void static_forces_warn(const static_request *request, const static_forces *forces);

/* Adds "reactions" and "inverted_tets" to the object, null where they are not known. */
void static_forces_json(const static_forces *forces, cJSON *object);

/* The lines of a table about them. */
extern const report_line static_forces_lines[];

#endif
