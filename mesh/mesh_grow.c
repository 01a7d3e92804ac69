/* Arrays that double their room, so that adding an item costs constant time on average.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_grow.h"

#include <stdlib.h>

void *thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size) {
  if (needed <= *capacity)
    return array;
  int64_t room = *capacity < 32 ? 64 : *capacity;
  while (room < needed) {
    if (room > INT64_MAX / 2)
      return NULL;
    room *= 2;
  }
  if ((uint64_t)room > SIZE_MAX / 2 / size)
    return NULL;
  void *moved = realloc(array, (size_t)room * size);
  if (moved)
    *capacity = room;
  return moved;
}
