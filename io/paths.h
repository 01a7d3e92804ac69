/* Finds out which file a path means and whether it can be written.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_PATHS_H
#define THRUM_IO_PATHS_H

#include "thrum/status.h"
#include <stdbool.h>
#include <stddef.h>

/* Tells whether two paths name the same file, also if it does not exist yet. */
bool path_same_file(const char *left, const char *right);

/* The path of this program; false where `path` is too short or the system does not tell it. */
bool path_program(char *path, size_t size);

/* The path that a file of this name has in the folder of this program; false as path_program. */
bool path_beside(const char *name, char *path, size_t size);

/* Finds share/thrum/NAME in the prefix that this program is installed in, or, where the system does
 * not tell where the program is, in the prefix that it was built for. Returns false where `path` is
 * too short or that prefix is not known either. */
bool path_share(const char *name, char *path, size_t size);

/* Refuses an output that could not be written, before long work rather than after it. */
thrum_status path_check_output(const char *path, thrum_error *error);

/* Returns the part of a path after its last slash. */
const char *path_basename(const char *path);

#endif
