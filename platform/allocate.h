/* Checked allocation. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_ALLOCATE_H
#define THRUM_PLATFORM_ALLOCATE_H

#include "thrum/status.h"
#include <stddef.h>
#include <stdint.h>

/* malloc of count x size bytes with the product checked; NULL sets the error. */
void *thrum_allocate(int64_t count, size_t size, const char *what, thrum_error *error);

/* The same of `size` bytes, aligned as the runtime wants the memory that it lays its objects into;
 * free() frees. */
void *thrum_allocate_aligned(size_t size, const char *what, thrum_error *error);

#endif
