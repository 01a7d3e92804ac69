/* How a model follows pulls at its surface, and shapes with which it follows them better, design 2.
 *
 * A pull is a force on a patch of the surface, a twentieth of the body's diagonal in radius. The
 * give of a place is how far a unit force moves its patch along itself, in the linear static answer
 * and in the mean over all directions of the force: a third of the trace of its compliance. A model
 * follows a place by that share of the body's give which its basis shows. Places that give less
 * than a hundredth of what the softest gives are stiff: they move too little to be seen, and are
 * not judged.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_TOUCH_H
#define THRUM_PRECOMPUTE_MODEL_TOUCH_H

#include "thrum/model.h"

/* Opaque: places on the surface of a body, and its compliances between them. */
typedef struct thrum_touch thrum_touch;

typedef struct thrum_touch_coverage {
  int64_t places; /* that were judged, */
  int64_t stiff;  /* and that were not */
  double worst;   /* least share of the give that the model follows a judged place by [1], */
  double mean;    /* and the mean of them */
  int32_t vertex; /* 0-based, in the middle of the worst */

  /* Least share in any one direction of a judged place, among those along which it gives at least a
   * hundredth of what the softest place gives in the mean: below `worst`, which is a mean over
   * directions; and the place. */
  double direction;
  int32_t direction_vertex;
} thrum_touch_coverage;

/* Finds places on the surface of the model's body, which must stay, and solves for them; 1440
 * solves with one factor of the stiffness at most. THRUM_MISSING without a mesh or basis, or where
 * all of the surface is held. */
thrum_status thrum_touch_create(const thrum_model *model, thrum_touch **touch, thrum_error *error);
void thrum_touch_free(thrum_touch *touch); /* NULL is fine */

/* The body behind the places, and its factor. */
const struct thrum_model_statics *thrum_touch_statics(const thrum_touch *touch);

/* How a model of the same mesh and held vertices follows pulls at the places. */
void thrum_touch_measure(thrum_touch *touch, const thrum_model *model,
                         thrum_touch_coverage *coverage);

/* The share by which each of `count` points on the surface (x 3, at rest) is followed: that of the
 * nearest place, 1 for stiff ones. Of the last model that was measured. Cost: points times places.
 */
void thrum_touch_spread(const thrum_touch *touch, const double *points, int64_t count,
                        double *follows);

/* Shapes beside the basis of `model`, *found of them and at most `most`, with which it follows all
 * judged places by `share`: fields of 3 vertex_count, one after the other. They are made of the
 * answers at 480 places, and judged at 96 others as well; *found == most may be too few. */
thrum_status thrum_touch_shapes(thrum_touch *touch, const thrum_model *model, double share,
                                int64_t most, double *fields, int64_t *found, thrum_error *error);

#endif
