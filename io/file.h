/* Files are read whole, and they are written beside their target, synced and renamed, so that a
 * reader never sees half a file. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_FILE_H
#define THRUM_IO_FILE_H

#include "thrum/status.h"
#include <stddef.h>

/* Writes a whole buffer to `path` through a temporary file beside it, fsync and rename. All
 * files that another program may be reading meanwhile are written in this way. */
thrum_status thrum_file_write_atomic(const char *path, const void *data, size_t size,
                                     thrum_error *error);

/* A writer does the same for output that is made piece by piece. open makes the temporary file,
 * commit syncs and renames it, abandon removes it. A zeroed writer is closed. */
typedef struct thrum_file_writer {
  void *stream; /* FILE * */
  char *path;
  char *temporary;
} thrum_file_writer;
thrum_status thrum_file_writer_open(const char *path, thrum_file_writer *writer,
                                    thrum_error *error);
thrum_status thrum_file_writer_put(thrum_file_writer *writer, const void *data, size_t size,
                                   thrum_error *error);
/* Syncs and closes, but does not rename yet, so that files that belong together are all complete
 * before the first takes its place. */
thrum_status thrum_file_writer_finish(thrum_file_writer *writer, thrum_error *error);
thrum_status thrum_file_writer_commit(thrum_file_writer *writer, thrum_error *error);
void thrum_file_writer_abandon(thrum_file_writer *writer);
/* Commits where `status` is that of success, abandons otherwise, and returns what came of it. */
thrum_status thrum_file_writer_end(thrum_file_writer *writer, thrum_status status,
                                   thrum_error *error);

/* Returns advice for a write that failed with this errno, which follows the reason in a message; ""
 * when there is none. */
const char *thrum_file_hint(int number);

/* Reads a whole file into *data (malloc, caller frees); refuses directories and the like. A 0 that
 * *size does not count stands behind the last byte. */
thrum_status thrum_file_read(const char *path, void **data, size_t *size, thrum_error *error);

/* Returns `status`, and where it is that of lacking memory, puts the file's name in front of the
 * message: what asks for memory while a file is taken in does not know the file. */
thrum_status thrum_file_name_memory(const char *path, thrum_status status, thrum_error *error);

#endif
