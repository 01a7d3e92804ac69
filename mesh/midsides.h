/* The middle nodes of ten-node tetrahedra: making them, leaving them out, and checking them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MIDSIDES_H
#define THRUM_MESH_MIDSIDES_H

#include "mesh/mesh.h"

/* A tet with a wrong middle node, and what is wrong with it, as the end of "tet 7 ...". */
typedef struct thrum_midside_fault {
  int64_t tet; /* 0-based */
  char text[200];
} thrum_midside_fault;

/* Makes a clean mesh of linear tets quadratic: a node in the middle of each edge, behind the
 * vertices that are there, in the order in which tets have the edges. It joins the groups that hold
 * both ends of its edge. On failure the mesh is as it was. Cost: linear in the mesh. */
thrum_status thrum_midsides_add(thrum_mesh *mesh, thrum_error *error);

/* Undoes thrum_midsides_add: the mesh is linear again, as it was. */
void thrum_midsides_undo(thrum_mesh *mesh);

/* Appends `count` middle nodes of the edges whose vertices are `ends`, count x 2, at `places`,
 * count x 3. A node joins the groups that hold both ends of its edge. Elements do not name it yet.
 * On failure the mesh is as it was. */
thrum_status thrum_midsides_append(thrum_mesh *mesh, const int32_t *ends, const double *places,
                                   int64_t count, thrum_error *error);

/* Numbers the edges of the tets as thrum_midsides_add numbers their middle nodes, from vertex_count
 * on; midsides: tet_count x 6, *count: how many edges there are. */
thrum_status thrum_midsides_number(const thrum_mesh *mesh, int32_t *midsides, int64_t *count,
                                   thrum_error *error);

/* Leaves the middle nodes out, so that only the corners of the tets count, and counts these tets as
 * cornered; the vertices stay until the mesh is cleaned. A linear mesh stays as it is. */
void thrum_midsides_drop(thrum_mesh *mesh);

/* Puts six middle nodes into the order that they have once corners 2 and 3 have changed places. */
void thrum_midsides_flip(int32_t *midsides);

/* Tets that share an edge must share its middle node, no middle node may be a corner or lie on two
 * edges, and the map of an element must not fold over at a point where it is integrated, at a
 * corner or at a middle node: THRUM_BAD_VALUE with *fault, and no text in *error. The mesh is
 * quadratic, its nodes exist and its tets are wound the right way. Cost: linear in the mesh. */
thrum_status thrum_midsides_check(const thrum_mesh *mesh, thrum_midside_fault *fault,
                                  thrum_error *error);

#endif
