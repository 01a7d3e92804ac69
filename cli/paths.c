/* Which file a path means. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli/cli.h"

char *cli_folder_of(const char *path) {
  const size_t length = (size_t)(cli_basename(path) - path);
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

bool cli_same_file(const char *left, const char *right) {
  char *folder = cli_folder_of(left), *other = cli_folder_of(right);
  const bool same = same_place(left, right) ||
                    (folder && other && strcmp(cli_basename(left), cli_basename(right)) == 0 &&
                     same_place(folder, other));
  free(folder);
  free(other);
  return same;
}
