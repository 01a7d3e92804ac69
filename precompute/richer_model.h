/* A model with more directions than another one, of the same body.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_RICHER_MODEL_H
#define THRUM_PRECOMPUTE_RICHER_MODEL_H

#include "precompute/model/basis_judge.h"
#include "precompute/precompute.h"

/* Has all of the other model's coordinates: q (of the richer) = change (its rank x the other's,
 * row-major) q. Groups are the other's, and borrowed. */
typedef struct thrum_richer_model {
  thrum_precomputed made;
  thrum_model model; /* with the groups, packed */
  void *packed;
  double *inertia; /* of its shape, where it is of solids and free */
  double *change;
} thrum_richer_model;

/* The basis of `model`, which the judge is of, and `most` directions at most: those in which its
 * looks found it lacking, the largest first, and behind them how the mesh follows `count` loads
 * (each 3 vertex_count), at rest and beyond. THRUM_OK with no change made where there is no
 * direction. */
thrum_status thrum_richer_model_make(const thrum_model *model, const thrum_basis_judge *judge,
                                     const double *loads, int64_t count, int64_t most,
                                     thrum_richer_model *richer, thrum_error *error);
void thrum_richer_model_free(thrum_richer_model *richer); /* a zeroed one is fine */

#endif
