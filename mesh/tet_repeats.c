/* Tets that come again, by a hash table of their sorted vertices. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/tet_repeats.h"

#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

/* The vertices of a tet in ascending order. */
static void sorted_tet(const int32_t *tet, int32_t sorted[4]) {
  memcpy(sorted, tet, 4 * sizeof *tet);
  for (int i = 1; i < 4; i++)
    for (int j = i; j > 0 && sorted[j] < sorted[j - 1]; j--) {
      int32_t swap = sorted[j];
      sorted[j] = sorted[j - 1];
      sorted[j - 1] = swap;
    }
}

thrum_status thrum_mesh_tet_repeats(const thrum_mesh *mesh, int64_t **earlier, thrum_error *error) {
  uint64_t slots = 16;
  while (slots < 2 * (uint64_t)mesh->tet_count)
    slots *= 2;

  int64_t *table = NULL;
  THRUM_TRY(thrum_reserve(earlier, mesh->tet_count, sizeof **earlier, "the mesh", error));
  THRUM_TRY(thrum_reserve(&table, (int64_t)slots, sizeof *table, "the mesh", error));
  for (uint64_t i = 0; i < slots; i++)
    table[i] = -1;

  // open addressing over the sorted vertices
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t key[4], other[4];
    sorted_tet(mesh->tets + 4 * t, key);
    uint64_t hash = 0;
    for (int a = 0; a < 4; a++)
      hash = (hash ^ (uint32_t)key[a]) * UINT64_C(0x9e3779b97f4a7c15);

    // the slot of these vertices, or a free one
    uint64_t slot = hash >> 20 & (slots - 1);
    for (; table[slot] >= 0; slot = (slot + 1) & (slots - 1)) {
      sorted_tet(mesh->tets + 4 * table[slot], other);
      if (memcmp(key, other, sizeof key) == 0)
        break;
    }
    (*earlier)[t] = table[slot];
    if (table[slot] < 0)
      table[slot] = t;
  }

  free(table);
  return THRUM_OK;
}
