/* Makes the folder for results. SPDX-License-Identifier: Apache-2.0 */
#include "io/folder.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/file.h"
#include "platform/interrupt.h"
#include "thrum/thrum.h"

thrum_status folder_make(const char *path, thrum_error *error) {
  struct stat status;
  if (mkdir(path, 0777) != 0 && errno != EEXIST) {
    const int reason = errno;
    return thrum_error_set(error, THRUM_IO, "%.200s: the folder cannot be made (%s)%s", path,
                           strerror(reason), thrum_file_hint(reason));
  }

  // the name may have existed before as a file, or without the right to write
  if (stat(path, &status) == 0 && !S_ISDIR(status.st_mode))
    return thrum_error_set(error, THRUM_IO, "%.200s: is a file; -o names a folder", path);
  if (access(path, W_OK) != 0) {
    const int reason = errno;
    return thrum_error_set(error, THRUM_IO, "%.200s: cannot be written to (%s)%s", path,
                           strerror(reason), thrum_file_hint(reason));
  }
  return THRUM_OK;
}

thrum_status folder_make_output(const char *path, thrum_error *error) {
  const bool is_new = access(path, F_OK) != 0;
  thrum_interrupt_hold();
  const thrum_status status = folder_make(path, error);
  if (status >= 0 && is_new)
    thrum_interrupt_mark(path);
  thrum_interrupt_let();
  return status;
}

void folder_give_up(const char *path) {
  // a folder that holds something stays
  if (thrum_interrupt_unmark(path))
    rmdir(path);
}
