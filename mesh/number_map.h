/* From a number of a file to a place, by a hash table.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_NUMBER_MAP_H
#define THRUM_MESH_NUMBER_MAP_H

#include <stdint.h>

#include "thrum/status.h"

typedef struct thrum_numbered_place {
  int64_t number, place; /* place -1: a free slot */
} thrum_numbered_place;

/* Zeroed to begin with; free with thrum_number_map_free. */
typedef struct thrum_number_map {
  thrum_numbered_place *slots;
  uint64_t slot_count; /* a power of two */
  uint64_t used;
} thrum_number_map;

/* The number of the edge between two vertices, in whichever order. */
static inline int64_t thrum_edge_number(int32_t a, int32_t b) {
  return a < b ? (int64_t)a << 32 | b : (int64_t)b << 32 | a;
}

/* The place of a number; -1: it has none. Cost: constant. */
int64_t thrum_number_map_find(const thrum_number_map *map, int64_t number);
/* Gives a number that has no place yet the place, at least 0. Cost: constant on average. */
thrum_status thrum_number_map_add(thrum_number_map *map, int64_t number, int64_t place,
                                  thrum_error *error);
void thrum_number_map_free(thrum_number_map *map);

#endif
