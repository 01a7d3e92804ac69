/* Gmsh .msh files: being written. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/mesh.h"

thrum_status thrum_mesh_read_msh(const char *path, thrum_mesh *mesh, thrum_error *error) {
  (void)mesh;
  return thrum_error_set(error, THRUM_UNSUPPORTED, "%.200s: .msh is not read yet", path);
}
