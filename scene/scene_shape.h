/* The present coordinates of a body, and where its points are. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_SHAPE_H
#define THRUM_SCENE_SCENE_SHAPE_H

#include "scene/scene_private.h"

/* Coordinates of a body that show it, the first entries of q and p: those stepped, or all. */
static inline int64_t scene_shown(const scene_body *body) {
  return body->derived->condensed ? body->model->rank : body->derived->rank;
}

/* w'^2 over w^2 of the scaled body. */
double scene_stiffening(const scene_body *body);

/* Makes body->q, and body->p if `p`, those of the present step. */
thrum_status scene_body_read(scene_body *body, bool p, thrum_error *error);

/* The counts of the body since its start, over all its states. */
scene_counts scene_body_counts(const scene_body *body);

/* A point of a body, rest position and three rows of U, in the world; body->q and, for a velocity
 * (which may be NULL), body->p are read. */
void scene_point(const scene_body *body, const double rest[3], const double *rows,
                 double position[3], double velocity[3]);

#endif
