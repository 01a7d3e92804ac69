/* Faces of elements and what an even load on one puts on its nodes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_SOLID_FACE_H
#define THRUM_PRECOMPUTE_FEM_SOLID_FACE_H

#include "mesh/solids.h"

enum { THRUM_SOLID_FACES_MAX = 6, THRUM_SOLID_FACE_NODES_MAX = 8 };

/* The nodes of a face, each a place among the element's own: corners, then middle nodes. Returns
 * how many, 3 to 8. */
int thrum_solid_face_nodes(thrum_solid_form form, int face, int nodes[THRUM_SOLID_FACE_NODES_MAX]);

/* shares[k]: the integral over the face of the shape function of its node k [m^2], where the nodes
 * of the element lie at `places`. Returns the area of the face. */
double thrum_solid_face_shares(thrum_solid_form form, int face, double (*places)[3],
                               double shares[THRUM_SOLID_FACE_NODES_MAX]);

#endif
