/* What reading a mesh changed, said to the user. SPDX-License-Identifier: Apache-2.0 */
#include "cli/mesh_warnings.h"

#include "cli/cli.h"

void cli_warn_mesh(const thrum_mesh *mesh, const char *name) {
  if (mesh->cornered_tets > 0) {
    cli_warn("%s: %lld tetrahedra of ten nodes were read by their corners", name,
             (long long)mesh->cornered_tets);
  }
  if (mesh->flipped_tets > 0) {
    cli_warn("%s: %s inside out; %lld flipped", name,
             mesh->flipped_tets == mesh->tet_count ? "every tetrahedron was"
                                                   : "some tetrahedra were",
             (long long)mesh->flipped_tets);
  }
  if (mesh->dropped_vertices > 0) {
    cli_warn("%s: %lld vertices that no tetrahedron uses were dropped", name,
             (long long)mesh->dropped_vertices);
  }
}
