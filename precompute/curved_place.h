/* Where a point lies in a mesh of ten-node tetrahedra with curved edges. SPDX-License-Identifier:
 * Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_CURVED_PLACE_H
#define THRUM_PRECOMPUTE_CURVED_PLACE_H

#include "mesh/tet_tree.h"
#include "thrum/model.h"

typedef struct thrum_curved_places thrum_curved_places;

/* *places: what turns places between corners into those of elements; NULL where the model has no
 * curved edges. The model must stay. thrum_curved_places_free frees. Cost: linear in the mesh. */
thrum_status thrum_curved_places_make(const thrum_model *model, thrum_curved_places **places,
                                      thrum_error *error);
void thrum_curved_places_free(thrum_curved_places *places); /* NULL is fine */

/* Moves *place, which thrum_tet_tree_find found for `point`, to the element that the point lies in,
 * among it and those that share a corner with it: weights are then the coordinates l of that
 * element, sum N_a(l) X_a = point, and distance is measured to the element. A point in none of them
 * goes to the one whose l is least negative; where the map reaches it in none, *place stays. */
void thrum_curved_place(const thrum_curved_places *places, const double point[3],
                        thrum_tet_place *place);

#endif
