/* The triangles of a tetrahedral mesh, by a hash table of their sorted vertices. Cost: linear in
 * the mesh; about 130 bytes a tet.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_faces.h"

#include <stdlib.h>

#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

typedef struct face_table {
  thrum_mesh_faces found;
  int32_t *slots; /* index of a face, -1 free; slot_count of them, a power of two */
  uint64_t slot_count;
} face_table;

/* Corners of the face opposite to each corner, going round outwards of a positive tet. */
static const int OPPOSITE[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

/* Sorts three vertices; true when an even number of swaps did it. */
static bool sort_even(int32_t v[3]) {
  static const int pairs[3][2] = {{0, 1}, {1, 2}, {0, 1}};
  bool even = true;
  for (int p = 0; p < 3; p++) {
    int32_t *a = &v[pairs[p][0]], *b = &v[pairs[p][1]];
    if (*a > *b) {
      const int32_t swap = *a;
      *a = *b;
      *b = swap;
      even = !even;
    }
  }
  return even;
}

static uint64_t first_slot(const face_table *table, const int32_t v[3]) {
  uint64_t hash = 0;
  for (int i = 0; i < 3; i++)
    hash = (hash ^ (uint32_t)v[i]) * UINT64_C(0x9e3779b97f4a7c15);
  return hash >> 24 & (table->slot_count - 1);
}

static bool same_face(const thrum_mesh_face *face, const int32_t v[3]) {
  return face->vertices[0] == v[0] && face->vertices[1] == v[1] && face->vertices[2] == v[2];
}

/* Adds a face of a tet, or finds it there already. */
static thrum_status add_face(face_table *table, int32_t tet, const int32_t vertices[3],
                             int64_t tets[3], thrum_error *error) {
  // a face is known by its vertices in ascending order
  int32_t v[3] = {vertices[0], vertices[1], vertices[2]};
  const bool even = sort_even(v);
  uint64_t slot = first_slot(table, v);

  // the second tetrahedron of a face must lie on its other side, and there is no third
  for (; table->slots[slot] >= 0; slot = (slot + 1) & (table->slot_count - 1)) {
    thrum_mesh_face *face = &table->found.faces[table->slots[slot]];
    if (!same_face(face, v))
      continue;
    if (face->other >= 0 || face->even == even) {
      tets[0] = face->tet;
      tets[1] = face->other >= 0 ? face->other : tet;
      tets[2] = face->other >= 0 ? tet : -1;
      return THRUM_BAD_VALUE;
    }
    face->other = tet;
    return THRUM_OK;
  }

  const thrum_mesh_face fresh = {
      .vertices = {v[0], v[1], v[2]}, .tet = tet, .other = -1, .even = even};
  table->slots[slot] = (int32_t)table->found.count;
  return thrum_mesh_append(&table->found.faces, &table->found.count, &fresh, sizeof fresh, error);
}

thrum_status thrum_mesh_find_faces(const thrum_mesh *mesh, thrum_mesh_faces *faces, int64_t tets[3],
                                   thrum_error *error) {
  if (mesh->tet_count > INT32_MAX / 4)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "more than 2^29 - 1 tetrahedra");

  face_table table = {.slot_count = 64};
  // the table stays at most half full, so that searches in it are short
  while (table.slot_count < (uint64_t)mesh->tet_count * 8)
    table.slot_count *= 2;
  THRUM_TRY(thrum_reserve(&table.slots, table.slot_count, sizeof *table.slots, "the faces", error));
  for (uint64_t i = 0; i < table.slot_count; i++)
    table.slots[i] = -1;

  // four faces a tetrahedron
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < 4 * mesh->tet_count && status >= 0; i++) {
    const int32_t *v = mesh->tets + i / 4 * 4;
    const int *corner = OPPOSITE[i % 4];
    const int32_t face[3] = {v[corner[0]], v[corner[1]], v[corner[2]]};
    status = add_face(&table, (int32_t)(i / 4), face, tets, error);
  }

  free(table.slots);
  if (status < 0)
    free(table.found.faces);
  else
    *faces = table.found;
  return status;
}
