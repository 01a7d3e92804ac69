/* Memory of a scene.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_SCENE_SCENE_MEMORY_H
#define THRUM_SCENE_SCENE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A block on a boundary that models and states want; NULL without memory. free() frees. */
void *scene_aligned(size_t size);

/* Room for `count` items of `size` in the array that the pointer at `array` points to; false
 * without memory, the array as it was. */
bool scene_grow(void *array, int64_t count, size_t size);

#endif
