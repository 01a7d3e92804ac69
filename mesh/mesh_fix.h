/* Which components of which vertices are held, by a text that names them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_FIX_H
#define THRUM_MESH_MESH_FIX_H

#include "mesh/mesh.h"

/* Adds to `fixed` (vertex_count bytes, bits 0..2 = x, y, z held) what `spec` names:
 * a place (vertex_places.h), such as `x<0.01&z>0` or `near:1,0,0`; else an existing file, a list of
 * 1-based vertices (commas, spaces, newlines, a:b ranges, # comments; numbered as in the mesh file,
 * so dropped vertices are looked up through the map kept by clean); else a group of the mesh. A
 * suffix `:xyz`, `:z`, ... picks components, default all. *count gets how many vertices it named;
 * naming none is refused, but for a list without numbers, as Vega has for free bodies. On failure
 * nothing is changed. */
thrum_status thrum_mesh_fix(const thrum_mesh *mesh, const char *spec, uint8_t *fixed,
                            int64_t *count, thrum_error *error);

#endif
