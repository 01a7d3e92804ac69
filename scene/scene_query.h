/* The present coordinates and points of a body.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_QUERY_H
#define THRUM_SCENE_SCENE_QUERY_H

#include "scene/scene_data.h"

/* Makes body->q, and body->p if `p`, those of the present step. */
thrum_status scene_body_read(scene_body *body, bool p, thrum_error *error);

/* A point of a body, rest position and three rows of U, in the world; body->q and, for a velocity
 * (which may be NULL), body->p are read. */
void scene_point(const scene_body *body, const double rest[3], const double *rows,
                 double position[3], double velocity[3]);

#endif
