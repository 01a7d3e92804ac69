/* The files of a cache by their age. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/cache_trim.h"

#include <dirent.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define PATH_MOST 4096

typedef struct cached_file {
  char *name;
  int64_t bytes, changed;
} cached_file;

typedef struct file_list {
  cached_file *files;
  size_t count, room;
} file_list;

/* Joins the path of a file; false where it is too long. */
static bool path_of(const char *folder, const char *name, char path[PATH_MOST]) {
  const int length = snprintf(path, PATH_MOST, "%s/%s", folder, name);
  return length > 0 && length < PATH_MOST;
}

/* Adds a file to the list; false without memory. */
static bool list_add(file_list *list, const char *name, const struct stat *status) {
  if (list->count == list->room) {
    const size_t room = 2 * list->room + 16;
    cached_file *more = realloc(list->files, room * sizeof *more);
    if (more == NULL)
      return false;
    list->files = more;
    list->room = room;
  }
  char *copy = strdup(name);
  if (copy == NULL)
    return false;
  list->files[list->count++] = (cached_file){copy, status->st_size, status->st_mtime};
  return true;
}

static void list_folder(const char *folder, const char *prefix, file_list *list) {
  DIR *entries = opendir(folder);
  if (entries == NULL)
    return;
  bool more = true;
  for (struct dirent *entry = readdir(entries); entry != NULL && more; entry = readdir(entries)) {
    char path[PATH_MOST];
    struct stat status;
    // a link is no file of ours
    if (strncmp(entry->d_name, prefix, strlen(prefix)) == 0 &&
        path_of(folder, entry->d_name, path) && lstat(path, &status) == 0 &&
        S_ISREG(status.st_mode))
      more = list_add(list, entry->d_name, &status);
  }
  closedir(entries);
}

static int by_age(const void *a, const void *b) {
  const int64_t first = ((const cached_file *)a)->changed,
                second = ((const cached_file *)b)->changed;
  return (first > second) - (first < second);
}

void cache_trim(const char *folder, const char *prefix, int64_t bytes_most, int64_t seconds) {
  file_list list = {0};
  int64_t bytes = 0;
  list_folder(folder, prefix, &list);
  for (size_t n = 0; n < list.count; n++)
    bytes += list.files[n].bytes;

  // the oldest first
  if (list.count > 0)
    qsort(list.files, list.count, sizeof *list.files, by_age);
  const int64_t since = (int64_t)time(NULL) - seconds;
  for (size_t n = 0; n < list.count && bytes > bytes_most && list.files[n].changed < since; n++) {
    char path[PATH_MOST];
    if (path_of(folder, list.files[n].name, path) && unlink(path) == 0)
      bytes -= list.files[n].bytes;
  }

  for (size_t n = 0; n < list.count; n++)
    free(list.files[n].name);
  free(list.files);
}
