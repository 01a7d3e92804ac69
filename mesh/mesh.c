/* The mesh itself: release, volume and hash. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

#include "runtime/base/vec3.h"

void thrum_mesh_free(thrum_mesh *mesh) {
  for (int64_t g = 0; g < mesh->group_count; g++) {
    free(mesh->groups[g].name);
    free(mesh->groups[g].vertices);
  }
  free(mesh->groups);
  free(mesh->vertices);
  free(mesh->tets);
  free(mesh->tet_region);
  free(mesh->materials);
  free(mesh->file_vertex);
  free(mesh->file_number);
  free(mesh->tet_line);
  *mesh = (thrum_mesh){0};
}

thrum_status thrum_mesh_deliver(thrum_status status, thrum_mesh *read, thrum_mesh *mesh) {
  if (status < 0)
    thrum_mesh_free(read);
  else
    *mesh = *read;
  return status;
}

double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t) {
  double edges[3][3];
  thrum_tet_edges(mesh->vertices, mesh->tets + 4 * t, edges);
  return thrum_triple3(edges[0], edges[1], edges[2]) / 6;
}

/* FNV-1a over the eight bytes of a number, lowest first, on any machine. */
static uint64_t hash_number(uint64_t hash, uint64_t number) {
  for (int i = 0; i < 8; i++) {
    hash ^= number >> 8 * i & 0xff;
    hash *= UINT64_C(1099511628211);
  }
  return hash;
}

uint64_t thrum_mesh_hash(const thrum_mesh *mesh) {
  uint64_t hash = UINT64_C(14695981039346656037);
  hash = hash_number(hash, (uint64_t)mesh->vertex_count);
  hash = hash_number(hash, (uint64_t)mesh->tet_count);
  for (int64_t i = 0; i < 3 * mesh->vertex_count; i++) {
    uint64_t bits;
    memcpy(&bits, &mesh->vertices[i], sizeof bits);
    hash = hash_number(hash, bits);
  }
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    hash = hash_number(hash, (uint64_t)mesh->tets[i]);
  for (int64_t t = 0; t < mesh->tet_count; t++)
    hash = hash_number(hash, (uint64_t)mesh->tet_region[t]);
  return hash;
}
