/* Memory for numbers that are read again and again in order. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_LARGE_MEMORY_H
#define THRUM_CORE_BASE_LARGE_MEMORY_H

#include <stddef.h>

/* Memory of `size` bytes or a little more, aligned to THRUM_ALIGNMENT or better; NULL where there
 * is none. Much of it is asked for in large pages. free() frees. Any thread. */
void *thrum_large_memory(size_t size);

#endif
