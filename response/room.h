/* Arrays one after the other in memory that is counted first and laid out then, private to the
 * library of responses. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_ROOM_H
#define THRUM_RESPONSE_ROOM_H

#include <stddef.h>
#include <stdint.h>

typedef struct thrum_room {
  double *memory; /* NULL: it is only counted */
  int64_t used;   /* doubles */
} thrum_room;

/* The next `count` doubles, aligned to 64 bytes where the memory is; NULL where it is only counted.
 */
static inline double *thrum_room_take(thrum_room *room, int64_t count) {
  double *taken = room->memory != NULL ? room->memory + room->used : NULL;
  room->used += (count + 7) / 8 * 8;
  return taken;
}

#endif
