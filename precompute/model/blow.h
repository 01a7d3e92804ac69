/* What a short load gives the mesh, and what a model's basis takes of it, design 10.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_BLOW_H
#define THRUM_PRECOMPUTE_MODEL_BLOW_H

#include "thrum/model.h"

typedef struct thrum_blow {
  double mesh;  /* energy of the linear body behind the model after the load [J] */
  double basis; /* and of its coordinates alone */
} thrum_blow;

/* The energies after `steps` steps of implicit midpoint of `dt` [s] from rest, under constant
 * `forces` (3 vertex_count) [N]. Assembles the body and factorises M + dt^2/4 K. THRUM_MISSING
 * without mesh or basis, or for a body that nothing holds. */
thrum_status thrum_blow_measure(const thrum_model *model, const double *forces, double dt,
                                int64_t steps, thrum_blow *blow, thrum_error *error);

#endif
