/* Exchange, lock and sync of folders, see folder_swap.h. Linux exchanges two names in one step
 * (renameat2); the lock is flock's, which goes with the process however it ends.
 * SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE // renameat2, flock, realpath
#include "platform/folder_swap.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

/* Returns 0, an errno, or ENOSYS where there is no such step. */
static int exchange(const char *first, const char *second) {
#ifdef RENAME_EXCHANGE
  return renameat2(AT_FDCWD, first, AT_FDCWD, second, RENAME_EXCHANGE) == 0 ? 0 : errno;
#else
  (void)first;
  (void)second;
  return ENOSYS;
#endif
}

int thrum_folder_swap(const char *first, const char *second, const char *spare) {
  const int number = exchange(first, second);
  if (number != ENOSYS && number != EINVAL && number != ENOTSUP)
    return number;

  // three steps, each undone when the next one fails
  if (rename(first, spare) != 0)
    return errno;
  if (rename(second, first) != 0) {
    const int reason = errno;
    rename(spare, first);
    return reason;
  }
  if (rename(spare, second) != 0) {
    const int reason = errno;
    rename(first, second);
    rename(spare, first);
    return reason;
  }
  return 0;
}

int thrum_folder_lock(const char *path) {
  const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0)
    return -1;
  if (flock(folder, LOCK_EX | LOCK_NB) == 0)
    return folder;

  // closing must not hide the reason
  const int reason = errno;
  close(folder);
  errno = reason;
  return -1;
}

char *thrum_folder_real_path(const char *path) {
  return realpath(path, NULL);
}

int thrum_folder_sync(const char *path) {
  const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0)
    return 0;

  // a file system that cannot sync folders says one of these
  const int number = fsync(folder) == 0 ? 0 : errno;
  const bool cannot = number == EINVAL || number == EROFS || number == ENOTSUP || number == ENOSYS;
  close(folder);
  return cannot ? 0 : number;
}
