/* Files read whole into heap blocks; see block.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/model/file_buffer.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/large_memory.h"
#include "core/model/archive.h"

#define SHOWN 150u

// the end of a long path, so that the reason still fits behind it
static const char *short_path(const char *path, const char **dots) {
  size_t size = strlen(path);
  *dots = size > SHOWN ? "..." : "";
  return size > SHOWN ? path + size - SHOWN : path;
}

thrum_status thrum_file_buffer_fail(const char *path, thrum_status status, const char *reason,
                                    thrum_error *error) {
  const char *dots;
  const char *shown = short_path(path, &dots);
  return thrum_error_set(error, status, "%s%s: %s", dots, shown, reason);
}

void *thrum_file_buffer_allocate(size_t size) {
  return thrum_large_memory(size);
}

// size of the open file; a folder opens but cannot be read, a pipe has no size
static thrum_status find_size(FILE *stream, const char *path, size_t *size, thrum_error *error) {
  errno = 0;
  if (fgetc(stream) == EOF) {
    if (!ferror(stream))
      return thrum_file_buffer_fail(path, THRUM_BAD_FORMAT, "the file is empty", error);
    return thrum_file_buffer_fail(path, THRUM_IO, errno != 0 ? strerror(errno) : "cannot be read",
                                  error);
  }

  // only a regular file has an end; offsets in an .npz have 32 bits
  long end = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : -1;
  if (end <= 0 || fseek(stream, 0, SEEK_SET) != 0)
    return thrum_file_buffer_fail(path, THRUM_IO, "not a regular file", error);
  if ((unsigned long)end >= 0xFFFFFFFFul)
    return thrum_file_buffer_fail(path, THRUM_UNSUPPORTED,
                                  "4 GiB or more: no file of Thrum is that large", error);
  *size = (size_t)end;
  return THRUM_OK;
}

// the whole file
static thrum_status read_stream(FILE *stream, const char *path, unsigned char **block, size_t *size,
                                thrum_error *error) {
  THRUM_TRY(find_size(stream, path, size, error));
  unsigned char *memory = thrum_file_buffer_allocate(*size);
  if (memory == NULL)
    return thrum_file_buffer_fail(path, THRUM_OUT_OF_MEMORY, "no memory to load it", error);

  // a failure has a reason of the system; a file that is shorter or longer than it was has none
  errno = 0;
  if (fread(memory, 1, *size, stream) != *size || fgetc(stream) != EOF) {
    const char *reason =
        ferror(stream) && errno != 0 ? strerror(errno) : "the file changed meanwhile";
    thrum_file_buffer_fail(path, THRUM_IO, reason, error);
    free(memory);
    return THRUM_IO;
  }
  *block = memory;
  return THRUM_OK;
}

thrum_status thrum_file_buffer_read(const char *path, unsigned char **block, size_t *size,
                                    thrum_error *error) {
  if (path[0] == '\0')
    return thrum_error_set(error, THRUM_IO, "the name of the file is empty");
  errno = 0;
  FILE *stream = fopen(path, "rb");
  if (stream == NULL)
    return thrum_file_buffer_fail(path, THRUM_IO, errno != 0 ? strerror(errno) : "cannot be opened",
                                  error);
  const thrum_status status = read_stream(stream, path, block, size, error);
  fclose(stream);
  return status;
}
