/* Reading a file into one aligned heap block, for the loaders. Beside them
 * only step/state_create.c allocates in the core.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_MODEL_FILE_BUFFER_H
#define THRUM_CORE_MODEL_FILE_BUFFER_H

#include <stddef.h>

#include "thrum/status.h"

/* At least `size` bytes aligned to 64; NULL when there are none. Freed with free. */
void *thrum_file_buffer_allocate(size_t size);

/* The whole file; *block is freed with free. Folders, pipes, empty files and those of 4 GiB or more
 * are refused. */
thrum_status thrum_file_buffer_read(const char *path, unsigned char **block, size_t *size,
                                    thrum_error *error);

/* "PATH: reason" of a path that may be long. */
thrum_status thrum_file_buffer_fail(const char *path, thrum_status status, const char *reason,
                                    thrum_error *error);

#endif
