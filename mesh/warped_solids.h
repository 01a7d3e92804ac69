/* Hexahedra, wedges and pyramids of order 1 that the plain cut (solids.h) would not leave as they
 * are.
 *
 * A face of four corners is the bilinear surface through them. Cut by a diagonal it loses or gains
 * half of the tetrahedron of its corners, so that a twisted element loses volume, and tets of it
 * may lie inside out. Such an element is cut by cones from its centre, the mean of its corners,
 * over its faces, each of four triangles around its own centre, the mean of its corners. That has
 * just the volume of the trilinear element: with T(a, b, c) = a . (b x c), the cone from the origin
 * over the bilinear face is (T012 + T123 + T230 + T301) / 12, and so is that over the four
 * triangles. A neighbour at such a face is cut by cones from its centre too, so that faces fit.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_WARPED_SOLIDS_H
#define THRUM_MESH_WARPED_SOLIDS_H

#include "mesh/mesh_builder.h"

/* Cuts the elements of a builder of linear elements again that need it; its vertices are in order.
 * New vertices come behind all others, with numbers of their own, and join the lists that hold all
 * corners of their face or element. Refuses elements that no cut leaves right side out. Cost: n log
 * n in the elements that are cut again, else linear. */
thrum_status thrum_builder_recut(thrum_mesh_builder *b, const char *name);

#endif
