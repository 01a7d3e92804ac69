/* Arrays that grow while a file is read.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_MESH_GROW_H
#define THRUM_MESH_MESH_GROW_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Makes room for `needed` items of `size` bytes in the array at *array (a pointer to any object,
 * malloc'ed or NULL), doubling *capacity, so that memory follows what a file holds and not what it
 * claims. False when out of memory (or a size would overflow), and the array is as it was then. */
bool thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size);

#endif
