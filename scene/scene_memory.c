/* Memory of a scene. SPDX-License-Identifier: Apache-2.0 */

#include "scene/scene_memory.h"

#include <stdlib.h>
#include <string.h>

void *scene_aligned(size_t size) {
  // aligned_alloc wants a multiple of the alignment
  if (size > SIZE_MAX - SCENE_ALIGNMENT)
    return NULL;
  return aligned_alloc(SCENE_ALIGNMENT, scene_round_up(size));
}

bool scene_grow(void *array, int64_t count, size_t size) {
  void *old = NULL;
  memcpy(&old, array, sizeof old);
  void *grown = realloc(old, (size_t)count * size);
  if (grown == NULL)
    return false;
  memcpy(array, &grown, sizeof grown);
  return true;
}
