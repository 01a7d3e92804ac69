/* Arrays that grow while a file is read.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_GROW_H
#define THRUM_MESH_MESH_GROW_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

/* Makes room for `more` items of `size` bytes behind the `count` ones of the array at *array (a
 * pointer to any object), which this function alone has given its memory, or NULL with a count of
 * 0. Room is doubled, so that memory follows what a file holds and not what it claims, and follows
 * from the count. The array is as it was when there is no memory (or a size would overflow). */
thrum_status thrum_mesh_grow(void *array, int64_t count, int64_t more, size_t size,
                             thrum_error *error);

/* Appends the item of `size` bytes at `item` to such an array of *count items. */
thrum_status thrum_mesh_append(void *array, int64_t *count, const void *item, size_t size,
                               thrum_error *error);

#endif
