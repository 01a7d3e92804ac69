/* Touch modes that are not stepped: static answers beside a basis, which follow loads, design 2.
 *
 * The shapes T are K-orthogonal to the basis U, so that a load f moves T y by y = W_T^-1 T^T f and
 * leaves the answer of U as it is: the static correction of mode superposition by residual
 * attachment modes (D. J. Rixen 2004, doi:10.1016/j.cam.2003.12.014). The model is a condensed one
 * (thrum/condensed_model.h): its masters are the coordinates of U with their own polynomial, and
 * nothing but loads moves the slaves. Cost: one product with K and one with M for each shape.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_TOUCH_FOLLOW_H
#define THRUM_PRECOMPUTE_MODEL_TOUCH_FOLLOW_H

#include "precompute/model/touch.h"

/* A model whose touch modes follow, and the arrays that it does not share; zeroed: none. */
typedef struct thrum_touch_followers {
  thrum_model model; /* its other arrays are those of the model that it was made of */
  double *basis;     /* 3 vertex_count x (rank + count) */
  double *omega2;    /* rank + count: what is stepped, and the followers, each ascending */
  double *axis_mass; /* 3 x (rank + count) */
  double *slave_map; /* count x rank (rank + 1) / 2, zeros: no master moves a follower */
  int64_t count;
} thrum_touch_followers;

/* Adds `count` shapes of thrum_touch_shapes (fields, 3 vertex_count each) to a model with a
 * polynomial, which must stay; count >= 1. THRUM_NOT_CONVERGED where they depend on each other. */
thrum_status thrum_touch_follow(const thrum_touch *touch, const thrum_model *model,
                                const double *fields, int64_t count,
                                thrum_touch_followers *followers, thrum_error *error);
void thrum_touch_followers_free(thrum_touch_followers *followers); /* a zeroed one is fine */

#endif
