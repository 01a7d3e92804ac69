/* Whole files are read here, and files are written so that no reader sees half of one: the bytes go
 * to a temporary file beside the target, are synced to the disk, and then take the target's name in
 * one step (rename). Until then the old file, if any, is untouched; when anything fails the
 * temporary file is removed. A symbolic link as target is replaced, as by mv; a device or a pipe is
 * refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/folder_swap.h"
#include "platform/interrupt.h"

#define ATTEMPTS 100
#define SHOWN 200

/* Returns the end of a long path, so that the reason still fits behind it in a message. */
static const char *shown(const char *path) {
  size_t size = strlen(path);
  return size > SHOWN ? path + size - SHOWN : path;
}

const char *thrum_file_hint(int number) {
  // the advice follows the reason in messages about files that cannot be written
  switch (number) {
  case ENOSPC:
  case EDQUOT:
    return "; make room, or write to another disk";
  case EFBIG:
    return "; raise the limit of a file's size (ulimit -f), or write to another disk";

  case EROFS:
  case EACCES:
  case EPERM:
    return "; write to a folder that you may write to";

  case ENOENT:
    return "; make its folder first";

  default:
    return "";
  }
}

static thrum_status fail(const char *path, const char *what, int number, thrum_error *error) {
  return thrum_error_set(error, THRUM_IO, "%s: %s: %s", shown(path), what, strerror(number));
}

static thrum_status fail_writing(const char *path, const char *what, int number,
                                 thrum_error *error) {
  return thrum_error_set(error, THRUM_IO, "%s: %s: %s%s", shown(path), what, strerror(number),
                         thrum_file_hint(number));
}

/* Refuses targets that a rename would destroy or could not replace. */
static thrum_status check_target(const char *path, thrum_error *error) {
  struct stat info;
  if (path[0] == '\0')
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the path of an output file is empty");
  if (stat(path, &info) != 0 || S_ISREG(info.st_mode))
    return THRUM_OK;
  if (S_ISDIR(info.st_mode))
    return thrum_error_set(error, THRUM_IO, "%s: is a folder, give the path of a file",
                           shown(path));
  return thrum_error_set(error, THRUM_IO, "%s: not a regular file, it will not be replaced",
                         shown(path));
}

/* Opens a new file beside the target, with the permissions that the user's umask leaves. */
static thrum_status open_temporary(thrum_file_writer *writer, thrum_error *error) {
  size_t capacity = strlen(writer->path) + 48;
  writer->temporary = malloc(capacity);
  if (writer->temporary == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a file name");

  // another process may have left or be writing a file of the same name, so the names are numbered
  int file = -1;
  for (int i = 0; i < ATTEMPTS && file < 0; i++) {
    snprintf(writer->temporary, capacity, "%s.%ld.%d.tmp", writer->path, (long)getpid(), i);

    // an interrupt between creating and marking the file would leave it behind
    thrum_interrupt_hold();
    file = open(writer->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    const int reason = errno;
    if (file >= 0)
      thrum_interrupt_mark(writer->temporary);
    thrum_interrupt_let();

    // only an existing name is worth another attempt
    errno = reason;
    if (file < 0 && reason != EEXIST)
      break;
  }

  if (file >= 0) {
    writer->stream = fdopen(file, "wb");
    if (writer->stream != NULL)
      return THRUM_OK;
  }

  // the reason is kept before closing the file overwrites it
  int number = errno;
  if (file >= 0) {
    close(file);
    unlink(writer->temporary);
  }
  return fail_writing(writer->path, "cannot be created", number, error);
}

static void release(thrum_file_writer *writer) {
  thrum_interrupt_unmark(writer->temporary);
  free(writer->path);
  free(writer->temporary);
  *writer = (thrum_file_writer){NULL, NULL, NULL};
}

thrum_status thrum_file_writer_open(const char *path, thrum_file_writer *writer,
                                    thrum_error *error) {
  if (path == NULL || writer == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "no path or no writer is given");
  THRUM_TRY(check_target(path, error));

  // the caller's writer is set only when the file is open
  thrum_file_writer opened = {NULL, malloc(strlen(path) + 1), NULL};
  if (opened.path == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a file name");
  strcpy(opened.path, path);
  thrum_status status = open_temporary(&opened, error);
  if (status != THRUM_OK)
    release(&opened);
  else
    *writer = opened;
  return status;
}

thrum_status thrum_file_writer_put(thrum_file_writer *writer, const void *data, size_t size,
                                   thrum_error *error) {
  if (writer == NULL || writer->stream == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the output file is not open");
  if (size > 0 && fwrite(data, 1, size, writer->stream) != size)
    return fail_writing(writer->path, "cannot be written", errno, error);
  return THRUM_OK;
}

/* Makes the new name itself survive a power cut; returns 0 or an errno. */
static int sync_folder(const char *path) {
  const char *slash = strrchr(path, '/');
  const size_t size = slash == NULL ? 0 : (size_t)(slash - path) + 1;
  char *folder = malloc(size + 2);
  if (folder == NULL)
    return ENOMEM;
  memcpy(folder, path, size);
  memcpy(folder + size, ".", 2);
  const int number = thrum_folder_sync(folder);
  free(folder);
  return number;
}

/* Flushes, syncs and closes the stream; returns 0, or the errno of the first step that failed. */
static int close_stream(thrum_file_writer *writer) {
  FILE *stream = writer->stream;
  int number = 0;
  // an earlier failed write leaves its mark on the stream; errno is still its own
  if (ferror(stream) || fflush(stream) != 0 || fsync(fileno(stream)) != 0)
    number = errno != 0 ? errno : EIO;
  writer->stream = NULL;
  if (fclose(stream) != 0 && number == 0)
    number = errno;
  return number;
}

thrum_status thrum_file_writer_finish(thrum_file_writer *writer, thrum_error *error) {
  if (writer == NULL || writer->stream == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the output file is not open");
  const int number = close_stream(writer);
  if (number == 0)
    return THRUM_OK;
  const thrum_status status = fail_writing(writer->path, "cannot be written", number, error);
  thrum_file_writer_abandon(writer);
  return status;
}

thrum_status thrum_file_writer_commit(thrum_file_writer *writer, thrum_error *error) {
  if (writer == NULL || writer->temporary == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the output file is not open");
  int number = writer->stream != NULL ? close_stream(writer) : 0;
  if (number == 0 && rename(writer->temporary, writer->path) != 0)
    number = errno;

  // only a complete file takes the target's name
  thrum_status status = THRUM_OK;
  if (number != 0) {
    unlink(writer->temporary);
    status = fail_writing(writer->path, "cannot be written", number, error);
  } else if ((number = sync_folder(writer->path)) != 0) {
    status = fail_writing(writer->path, "is written, but may be lost when the power fails", number,
                          error);
  }
  release(writer);
  return status;
}

void thrum_file_writer_abandon(thrum_file_writer *writer) {
  if (writer == NULL)
    return;
  if (writer->stream != NULL)
    fclose(writer->stream);
  if (writer->temporary != NULL)
    unlink(writer->temporary);
  release(writer);
}

thrum_status thrum_file_writer_end(thrum_file_writer *writer, thrum_status status,
                                   thrum_error *error) {
  if (status >= 0)
    return thrum_file_writer_commit(writer, error);
  thrum_file_writer_abandon(writer);
  return status;
}

thrum_status thrum_file_write_atomic(const char *path, const void *data, size_t size,
                                     thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  return thrum_file_writer_end(&writer, thrum_file_writer_put(&writer, data, size, error), error);
}

/* Reads the rest of an open regular file, whose size is known. */
static thrum_status read_all(FILE *stream, const char *path, size_t expected, void **data,
                             thrum_error *error) {
  // one byte more, so that text can be ended by 0 by its reader
  char *buffer = expected < PTRDIFF_MAX ? malloc(expected + 1) : NULL;
  if (buffer == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "%s: no memory for its %lu bytes",
                           shown(path), (unsigned long)expected);

  // a file that changed its size while it was read is refused
  errno = 0;
  if (fread(buffer, 1, expected, stream) != expected || fgetc(stream) != EOF) {
    free(buffer);
    return fail(path, "cannot be read", errno != 0 ? errno : EIO, error);
  }

  buffer[expected] = '\0';
  *data = buffer;
  return THRUM_OK;
}

thrum_status thrum_file_read(const char *path, void **data, size_t *size, thrum_error *error) {
  if (path == NULL || data == NULL || size == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_file_read: an argument is NULL");

  // looked at before it is opened, because opening a pipe would wait for its other end
  struct stat info;
  if (stat(path, &info) != 0)
    return fail(path, "cannot be read", errno, error);
  if (!S_ISREG(info.st_mode))
    return thrum_error_set(error, THRUM_IO, "%s: cannot be read: %s", shown(path),
                           S_ISDIR(info.st_mode) ? "it is a folder" : "it is not a regular file");

  // the size is asked of the open file, which may be another than before
  FILE *stream = fopen(path, "rb");
  if (stream == NULL)
    return fail(path, "cannot be read", errno, error);
  thrum_status status = THRUM_OK;
  if (fstat(fileno(stream), &info) != 0 || info.st_size < 0)
    status = fail(path, "cannot be read", errno, error);
  else
    status = read_all(stream, path, (size_t)info.st_size, data, error);

  fclose(stream);
  if (status == THRUM_OK)
    *size = (size_t)info.st_size;
  return status;
}

thrum_status thrum_file_name_memory(const char *path, thrum_status status, thrum_error *error) {
  if (status != THRUM_OUT_OF_MEMORY || error == NULL)
    return status;
  const thrum_error detail = *error;
  return thrum_error_set(error, status, "%.200s: %s", path, detail.message);
}
