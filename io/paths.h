/* Which file a path means. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_PATHS_H
#define THRUM_IO_PATHS_H

#include "thrum/status.h"
#include <stdbool.h>
#include <stddef.h>

/* The folder that a file lies in, "." without any; to be freed, NULL without memory. */
char *path_folder(const char *path);
/* Are two paths one file, or would they be, if it were written? */
bool path_same_file(const char *left, const char *right);
/* share/thrum/NAME of the prefix that this program would be installed in; false: `path` is too
 * short, or the system does not say where the program is. */
bool path_share(const char *name, char *path, size_t size);

/* Refuses an output that could not be written, before long work rather than after it. */
thrum_status path_check_output(const char *path, thrum_error *error);

/* The part of a path after its last slash. */
const char *path_basename(const char *path);

#endif
