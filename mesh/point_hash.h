/* Vertices at just the same place, by a hash table of their coordinates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_POINT_HASH_H
#define THRUM_MESH_POINT_HASH_H

#include <stdint.h>

#include "thrum/status.h"

/* Zeroed to begin with; the vertices themselves are the caller's. */
typedef struct thrum_point_hash {
  int32_t *slots;      /* vertex, -1 free */
  uint64_t slot_count; /* a power of two */
} thrum_point_hash;

/* The earliest of `count` vertices (x 3), all of which went through here in ascending order, that
 * is at `position`, or `count` when there is none: the caller then makes it vertex `count`. 0 and
 * -0 are one place. Cost: constant. */
thrum_status thrum_point_hash_find(thrum_point_hash *places, const double *vertices, int64_t count,
                                   const double position[3], int32_t *vertex, thrum_error *error);
void thrum_point_hash_free(thrum_point_hash *places);

#endif
