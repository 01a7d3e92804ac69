/* Arrays that double their room, so that adding an item costs constant time on average.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_grow.h"

#include <stdlib.h>
#include <string.h>

bool thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size) {
  if (needed <= *capacity)
    return true;
  int64_t room = *capacity < 32 ? 64 : *capacity;
  while (room < needed) {
    if (room > INT64_MAX / 2)
      return false;
    room *= 2;
  }
  if ((uint64_t)room > SIZE_MAX / 2 / size)
    return false;

  // the caller's pointer may be of any type, so its bytes are copied
  void *moved;
  memcpy(&moved, array, sizeof moved);
  moved = realloc(moved, (size_t)room * size);
  if (!moved)
    return false;
  memcpy(array, &moved, sizeof moved);
  *capacity = room;
  return true;
}
