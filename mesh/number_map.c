/* From numbers to places, by open addressing; the table is at most half full.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/number_map.h"

#include <stdlib.h>

/* The slot of a number, or the free one where it would stand. */
static uint64_t find_slot(const thrum_number_map *map, int64_t number) {
  uint64_t hash = (uint64_t)number * UINT64_C(0x9e3779b97f4a7c15);
  hash ^= hash >> 29;
  uint64_t slot = (hash * UINT64_C(0xbf58476d1ce4e5b9) >> 20) & (map->slot_count - 1);
  while (map->slots[slot].place >= 0 && map->slots[slot].number != number)
    slot = (slot + 1) & (map->slot_count - 1);
  return slot;
}

int64_t thrum_number_map_find(const thrum_number_map *map, int64_t number) {
  return map->used > 0 ? map->slots[find_slot(map, number)].place : -1;
}

/* Moves all numbers to a table of twice the size. */
static thrum_status grow(thrum_number_map *map, thrum_error *error) {
  thrum_number_map larger = {.slot_count = map->slot_count > 0 ? 2 * map->slot_count : 64};
  larger.slots = malloc(larger.slot_count * sizeof *larger.slots);
  if (!larger.slots)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
  for (uint64_t i = 0; i < larger.slot_count; i++)
    larger.slots[i].place = -1;

  for (uint64_t i = 0; i < map->slot_count; i++)
    if (map->slots[i].place >= 0)
      larger.slots[find_slot(&larger, map->slots[i].number)] = map->slots[i];
  larger.used = map->used;
  free(map->slots);
  *map = larger;
  return THRUM_OK;
}

thrum_status thrum_number_map_add(thrum_number_map *map, int64_t number, int64_t place,
                                  thrum_error *error) {
  if (2 * (map->used + 1) > map->slot_count)
    THRUM_TRY(grow(map, error));
  map->slots[find_slot(map, number)] = (thrum_numbered_place){number, place};
  map->used++;
  return THRUM_OK;
}

void thrum_number_map_free(thrum_number_map *map) {
  free(map->slots);
  *map = (thrum_number_map){0};
}
