/* Finds out which file a path means and whether it can be written.
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/paths.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "thrum/thrum.h"

const char *path_basename(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash != NULL ? slash + 1 : path;
}

/* Returns the folder that a file lies in, "." if the path names none. The caller frees it; NULL
 * when there is no memory. */
static char *folder_of(const char *path) {
  const size_t length = (size_t)(path_basename(path) - path);
  char *folder = malloc(length + 2);
  if (folder != NULL) {
    memcpy(folder, path, length);
    memcpy(folder + length, length > 0 ? "" : ".", length > 0 ? 1 : 2);
  }
  return folder;
}

static bool same_place(const char *left, const char *right) {
  struct stat one, other;
  return stat(left, &one) == 0 && stat(right, &other) == 0 && one.st_dev == other.st_dev &&
         one.st_ino == other.st_ino;
}

bool path_same_file(const char *left, const char *right) {
  char *folder = folder_of(left), *other = folder_of(right);
  const bool same = same_place(left, right) ||
                    (folder && other && strcmp(path_basename(left), path_basename(right)) == 0 &&
                     same_place(folder, other));
  free(folder);
  free(other);
  return same;
}

thrum_status path_check_output(const char *path, thrum_error *error) {
  struct stat status;
  if (stat(path, &status) == 0 && !S_ISREG(status.st_mode)) {
    return thrum_error_set(error, THRUM_IO,
                           S_ISDIR(status.st_mode) ? "%s is a folder; name a file"
                                                   : "%s is no regular file; name another",
                           path);
  }

  // the file itself need not exist yet, but its folder must allow a new one
  char *folder = folder_of(path);
  if (folder == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "out of memory");
  const bool writable = access(folder, W_OK | X_OK) == 0;
  free(folder);

  if (path_basename(path)[0] == 0 || !writable) {
    return thrum_error_set(error, THRUM_IO,
                           "%s cannot be written: its folder does not exist or "
                           "is not writable",
                           path);
  }
  return THRUM_OK;
}

bool path_program(char *path, size_t size) {
  const ssize_t length = readlink("/proc/self/exe", path, size - 1);
  if (length <= 0 || (size_t)length >= size - 1)
    return false;
  path[length] = 0;
  return true;
}

bool path_beside(const char *name, char *path, size_t size) {
  if (!path_program(path, size))
    return false;

  // the name takes the place of the program's own
  char *own = strrchr(path, '/');
  if (own == NULL)
    return false;
  const size_t room = size - (size_t)(own + 1 - path);
  const int written = snprintf(own + 1, room, "%s", name);
  return written > 0 && (size_t)written < room;
}

/* The prefix that this program lies in, as PREFIX/bin/thrum. */
static bool own_prefix(char *path, size_t size) {
  if (!path_program(path, size))
    return false;

  // without the name of the program and that of bin
  for (int up = 0; up < 2; up++) {
    char *slash = strrchr(path, '/');
    if (slash == NULL)
      return false;
    *slash = 0;
  }
  return true;
}

bool path_share(const char *name, char *path, size_t size) {
  // without /proc, as in some containers, the program lies where it was to be installed
  if (!own_prefix(path, size)) {
#ifdef THRUM_PREFIX
    if (strlen(THRUM_PREFIX) >= size)
      return false;
    memcpy(path, THRUM_PREFIX, sizeof THRUM_PREFIX);
#else
    return false;
#endif
  }

  const size_t length = strlen(path), room = size - length;
  const int written = snprintf(path + length, room, "/share/thrum/%s", name);
  return written > 0 && (size_t)written < room;
}
