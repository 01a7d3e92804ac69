/* Arrays that double their room, so that adding an item costs constant time on average.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_grow.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* The items that there is room for with `count` of them: a power of two, or INT64_MAX / 2 + 1. */
static int64_t room_of(int64_t count) {
  int64_t room = count > 0 ? 64 : 0;
  while (room < count && room <= INT64_MAX / 2)
    room *= 2;
  return room;
}

thrum_status thrum_mesh_grow(void *array, int64_t count, int64_t more, size_t size,
                             thrum_error *error) {
  const int64_t room = room_of(count + more);
  if (room == room_of(count))
    return THRUM_OK;

  // the caller's pointer may be of any type, so its bytes are copied
  void *moved;
  memcpy(&moved, array, sizeof moved);
  const bool fits = room >= count + more && (uint64_t)room <= SIZE_MAX / 2 / size;
  moved = fits ? realloc(moved, (size_t)room * size) : NULL;
  if (!moved)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
  memcpy(array, &moved, sizeof moved);
  return THRUM_OK;
}

thrum_status thrum_mesh_append(void *array, int64_t *count, const void *item, size_t size,
                               thrum_error *error) {
  unsigned char *items;
  THRUM_TRY(thrum_mesh_grow(array, *count, 1, size, error));
  memcpy(&items, array, sizeof items);
  memcpy(items + (size_t)*count * size, item, size);
  ++*count;
  return THRUM_OK;
}
