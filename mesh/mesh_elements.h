/* The elements of a mesh, one after the other, whichever they are.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_ELEMENTS_H
#define THRUM_MESH_MESH_ELEMENTS_H

#include "mesh/mesh.h"
#include "mesh/solids.h"

typedef struct thrum_mesh_element {
  thrum_solid_form form;
  int count;                            /* of its nodes */
  int32_t region;                       /* 0-based */
  int32_t nodes[THRUM_SOLID_NODES_MAX]; /* 0-based, in the order of Abaqus and VTK */
} thrum_mesh_element;

/* How many there are: solids, or tets where there are none. */
int64_t thrum_mesh_element_count(const thrum_mesh *mesh);
/* Element e, from 0. */
thrum_mesh_element thrum_mesh_element_at(const thrum_mesh *mesh, int64_t e);
/* The region of element e. */
int32_t thrum_mesh_element_region(const thrum_mesh *mesh, int64_t e);
/* Its number in the file, or in the mesh, from 1; parts of one element of the file have one. */
int64_t thrum_mesh_element_number(const thrum_mesh *mesh, int64_t e);
/* How many elements there are of each form. */
void thrum_mesh_count_forms(const thrum_mesh *mesh, int64_t counts[THRUM_FORMS]);

#endif
