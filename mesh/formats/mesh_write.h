/* Writes meshes; mesh_write.c chooses the writer, and each writer is a file mesh_write_FORMAT.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_FORMATS_MESH_WRITE_H
#define THRUM_MESH_FORMATS_MESH_WRITE_H

#include "mesh/formats/mesh_out.h"
#include "mesh/solids.h"

/* Writes the mesh in the format that the suffix names: .veg, .msh, .node or .ele (both files),
 * .mesh, .vtk, .vtu, .inp. Vertices come back bit for bit, elements and regions in their order
 * (.mesh: form after form). Elements that the format does not have are refused. On failure there is
 * no file, or the old one as it was; *lost is untouched. */
thrum_status thrum_mesh_write(const char *path, const thrum_mesh *mesh,
                              const thrum_mesh_write_options *options, thrum_mesh_lost *lost,
                              thrum_error *error);

/* Has the format that the suffix names elements of this form? */
bool thrum_mesh_write_takes(const char *path, thrum_solid_form form);

typedef void thrum_mesh_writer(thrum_mesh_out *out, thrum_mesh_written *w);
thrum_mesh_writer thrum_mesh_write_veg, thrum_mesh_write_msh, thrum_mesh_write_node,
    thrum_mesh_write_ele, thrum_mesh_write_medit, thrum_mesh_write_vtk, thrum_mesh_write_vtu,
    thrum_mesh_write_abaqus;

#endif
