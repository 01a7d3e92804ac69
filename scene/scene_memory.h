/* Memory of a scene. Private to scene/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_MEMORY_H
#define THRUM_SCENE_SCENE_MEMORY_H

#include "scene/scene_private.h"

/* Where models, states and the blocks of workers begin. */
#define SCENE_ALIGNMENT 64

static inline size_t scene_round_up(size_t size) {
  return (size + SCENE_ALIGNMENT - 1) / SCENE_ALIGNMENT * SCENE_ALIGNMENT;
}

/* A block on a boundary that models and states want; NULL without memory. free() frees. */
void *scene_aligned(size_t size);

/* Room for `count` items of `size` in the array that the pointer at `array` points to; false
 * without memory, the array as it was. */
bool scene_grow(void *array, int64_t count, size_t size);

#endif
