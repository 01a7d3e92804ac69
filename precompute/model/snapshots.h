/* Shapes of a motion that a basis cannot show: proper orthogonal decomposition of what is left of
 * snapshots. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_SNAPSHOTS_H
#define THRUM_PRECOMPUTE_MODEL_SNAPSHOTS_H

#include "precompute/model/model_fem.h"

/* The `count` fields that show the most of what the basis of `model` leaves of the snapshots, in
 * the norm of the stiffness at rest (strain energy of small displacements): fields of 3
 * vertex_count, one after the other, orthonormal in that norm and mass-orthogonal to the basis.
 * snapshots: runs x each fields; each run counts alike, whatever its size. `body` is that of the
 * model. *found: how many there are, fewer where fewer show all of it. Source: Berkooz, Holmes and
 * Lumley 1993, doi:10.1146/annurev.fl.25.010193.002543, by the method of snapshots. Cost: n (runs
 * each)^2. */
thrum_status thrum_snapshot_shapes(const thrum_model *model, const thrum_model_fem *body,
                                   const double *snapshots, int64_t runs, int64_t each,
                                   int64_t count, double *fields, int64_t *found,
                                   thrum_error *error);

#endif
