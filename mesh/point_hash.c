/* Open addressing, at most half full; see point_hash.h. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/point_hash.h"

#include <stdlib.h>
#include <string.h>

void thrum_point_hash_free(thrum_point_hash *places) {
  free(places->slots);
  *places = (thrum_point_hash){0};
}

static uint64_t first_slot(const thrum_point_hash *places, const double position[3]) {
  uint64_t hash = 0, bits;
  for (int axis = 0; axis < 3; axis++) {
    const double number = position[axis] + 0.0; // -0 becomes 0
    memcpy(&bits, &number, sizeof bits);
    hash = (hash ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
    hash ^= hash >> 29;
  }
  return hash & (places->slot_count - 1);
}

static void put(thrum_point_hash *places, const double *vertices, int32_t vertex) {
  uint64_t slot = first_slot(places, vertices + 3 * (int64_t)vertex);
  while (places->slots[slot] >= 0)
    slot = (slot + 1) & (places->slot_count - 1);
  places->slots[slot] = vertex;
}

static thrum_status grow(thrum_point_hash *places, const double *vertices, int64_t count,
                         thrum_error *error) {
  if ((uint64_t)count * 2 + 2 < places->slot_count)
    return THRUM_OK;
  const uint64_t wanted = places->slot_count == 0 ? 64 : 2 * places->slot_count;
  int32_t *grown = realloc(places->slots, wanted * sizeof *grown);
  if (grown == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the vertices");
  places->slots = grown;
  places->slot_count = wanted;
  memset(grown, 0xff, wanted * sizeof *grown);
  for (int64_t v = 0; v < count; v++)
    put(places, vertices, (int32_t)v);
  return THRUM_OK;
}

thrum_status thrum_point_hash_find(thrum_point_hash *places, const double *vertices, int64_t count,
                                   const double position[3], int32_t *vertex, thrum_error *error) {
  THRUM_TRY(grow(places, vertices, count, error));
  uint64_t slot = first_slot(places, position);
  for (; places->slots[slot] >= 0; slot = (slot + 1) & (places->slot_count - 1)) {
    const double *known = vertices + 3 * (int64_t)places->slots[slot];
    if (known[0] == position[0] && known[1] == position[1] && known[2] == position[2]) {
      *vertex = places->slots[slot];
      return THRUM_OK;
    }
  }
  places->slots[slot] = *vertex = (int32_t)count;
  return THRUM_OK;
}
