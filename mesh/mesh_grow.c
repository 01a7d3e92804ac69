/* Arrays that double their room, so that adding an item costs constant time on average.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_grow.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

thrum_status thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size,
                             thrum_error *error) {
  int64_t room = *capacity < 32 ? 64 : *capacity;
  if (needed <= *capacity)
    return THRUM_OK;
  while (room < needed && room <= INT64_MAX / 2)
    room *= 2;

  // the caller's pointer may be of any type, so its bytes are copied
  void *moved;
  memcpy(&moved, array, sizeof moved);
  const bool fits = room >= needed && (uint64_t)room <= SIZE_MAX / 2 / size;
  moved = fits ? realloc(moved, (size_t)room * size) : NULL;
  if (!moved)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
  memcpy(array, &moved, sizeof moved);
  *capacity = room;
  return THRUM_OK;
}

thrum_status thrum_mesh_append(void *array, int64_t *count, int64_t *capacity, const void *item,
                               size_t size, thrum_error *error) {
  unsigned char *items;
  THRUM_TRY(thrum_mesh_grow(array, capacity, *count + 1, size, error));
  memcpy(&items, array, sizeof items);
  memcpy(items + (size_t)*count * size, item, size);
  ++*count;
  return THRUM_OK;
}
