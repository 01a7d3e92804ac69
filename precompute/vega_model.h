/* A model of VegaFEM's cubic polynomial (.cub) alone, without the mesh and the basis that it was
 * made with, which published assets often lack: it can be stepped, and shows coordinates only.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_VEGA_MODEL_H
#define THRUM_PRECOMPUTE_VEGA_MODEL_H

#include <stdbool.h>

#include "platform/allocate.h"
#include "thrum/model.h"

/* A model and the arrays that it points to. */
typedef struct thrum_vega_model {
  thrum_scope memory; /* of the arrays */
  thrum_model model;
  double *omega2, *c3, *c4; /* owned */
  double defect;            /* by how much components of the force disagree, relative */
  bool changed;             /* the coordinates were turned until the stiffness is diagonal */
} thrum_vega_model;

/* Reads the file. Its basis is taken as mass-orthonormal, as VegaFEM makes it; the coordinates are
 * turned until the stiffness is diagonal and ascends. THRUM_BAD_VALUE where it has a mode without
 * stiffness. On failure *made is untouched; release it with thrum_vega_model_free. */
thrum_status thrum_vega_model_read(const char *path, thrum_vega_model *made, thrum_error *error);

void thrum_vega_model_free(thrum_vega_model *made); /* leaves it empty */

#endif
