/* Checked allocation. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_ALLOCATE_H
#define THRUM_PLATFORM_ALLOCATE_H

#include "thrum/status.h"
#include <stddef.h>
#include <stdint.h>

/* Zeroed memory of count x size bytes, the product checked, for *memory, which is a pointer to any
 * object and becomes NULL where there is no memory for it. `memory` is void *, so that the address
 * of any such pointer will do. */
thrum_status thrum_reserve(void *memory, int64_t count, size_t size, const char *what,
                           thrum_error *error);

/* malloc of `size` bytes, aligned as the runtime wants the memory that it lays its objects into;
 * free() frees. */
void *thrum_allocate_aligned(size_t size, const char *what, thrum_error *error);

/* The same for *memory, as thrum_reserve has it, but not zeroed. */
thrum_status thrum_reserve_aligned(void **memory, size_t size, const char *what,
                                   thrum_error *error);

/* Memory that is given back together: what a function takes while it works, or what an object owns.
 * After one allocation has failed, `status` says so and the others give NULL, so that one check
 * serves for several. */
typedef struct thrum_scope {
  const char *what;   /* "no memory for WHAT" */
  thrum_error *error; /* may be NULL */
  thrum_status status;
  struct thrum_scope_block *last;
} thrum_scope;

/* A scope that owns nothing yet. */
thrum_scope thrum_scope_begin(const char *what, thrum_error *error);

/* Memory that thrum_scope_free gives back: zeroed, or aligned like that of thrum_allocate_aligned.
 */
void *thrum_scope_allocate(thrum_scope *scope, int64_t count, size_t size);
void *thrum_scope_allocate_aligned(thrum_scope *scope, size_t size);

/* Gives back all memory of a scope; one that is zeroed owns none. */
void thrum_scope_free(thrum_scope *scope);

#endif
