/* Springs between vertices and the ground, by a text that names them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_SPRINGS_H
#define THRUM_MESH_MESH_SPRINGS_H

#include "mesh/mesh.h"

/* Adds springs to mesh->springs, which is made where it is NULL. `spec` is WHERE:k or
 * WHERE:kx,ky,kz; WHERE names vertices as thrum_mesh_fix reads them, and k, finite and >= 0, is the
 * stiffness of all of them together [N/m], shared out evenly: along each axis, or along x, y and z;
 * where all are 0 there is no spring.
 * On failure nothing is changed. */
thrum_status thrum_mesh_add_springs(thrum_mesh *mesh, const char *spec, thrum_error *error);

#endif
