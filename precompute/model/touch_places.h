/* Places over the visible surface of a body where a hand may pull.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_TOUCH_PLACES_H
#define THRUM_PRECOMPUTE_MODEL_TOUCH_PLACES_H

#include "precompute/fem/fem.h"

/* A pull acts on a patch: the vertices of the surface that are joined to its middle within a
 * radius, and what share of the force each bears. */
typedef struct thrum_touch_places {
  int64_t count;
  int32_t *middle; /* count: the vertex in the middle of each patch */
  int64_t *begin;  /* count + 1, into the next two */
  int32_t *vertex; /* of all patches, one after the other */
  double *share;   /* of the force; they sum up to 1 in a patch */
} thrum_touch_places;

/* Up to `count` places, spread over the corners of surface triangles that nothing holds, each as
 * far from those before it as can be: so any third of them is spread as well. The
 * share falls from the middle to the `radius` [m] as 1 - d^2 / radius^2. THRUM_MISSING where
 * everything is held. Cost: the surface times `count`. */
thrum_status thrum_touch_places_create(const thrum_mesh *mesh, const thrum_fem *fem, int64_t count,
                                       double radius, thrum_touch_places *places,
                                       thrum_error *error);
void thrum_touch_places_free(thrum_touch_places *places); /* a zeroed one is fine */

#endif
