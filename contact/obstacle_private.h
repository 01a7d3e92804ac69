/* Faces of obstacles, private to the runtime; the gap of a whole obstacle is in thrum/contact.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_OBSTACLE_PRIVATE_H
#define THRUM_RUNTIME_CONTACT_OBSTACLE_PRIVATE_H

#include "thrum/contact.h"

/* Number of faces that a point touches independently of each other: the walls of a room, else 1. */
int32_t thrum_obstacle_faces(const thrum_obstacle *obstacle);

/* Signed distance of x from a face [m], negative inside; `normal` gets the way out. */
double thrum_obstacle_face_gap(const thrum_obstacle *obstacle, int32_t face, const double x[3],
                               double normal[3]);

#endif
