/* Loading a model file from disk into one heap block, the only place of the runtime that allocates.
 * The file is read into a block that is freed when the model is laid out in its own.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model_layout.h"

#define SHOWN 150u

// the end of a long path, so that the reason still fits behind it
static const char *short_path(const char *path, const char **dots) {
  size_t size = strlen(path);
  *dots = size > SHOWN ? "..." : "";
  return size > SHOWN ? path + size - SHOWN : path;
}

static thrum_status fail(const char *path, thrum_status status, const char *reason,
                         thrum_error *error) {
  const char *dots;
  const char *shown = short_path(path, &dots);
  return thrum_error_set(error, status, "%s%s: %s", dots, shown, reason);
}

static void *allocate(size_t size) {
  if (size > PTRDIFF_MAX - THRUM_ALIGNMENT)
    return NULL;
  return aligned_alloc(THRUM_ALIGNMENT,
                       (size + THRUM_ALIGNMENT - 1) / THRUM_ALIGNMENT * THRUM_ALIGNMENT);
}

// size of the open file; a folder opens but cannot be read, a pipe has no size
static thrum_status find_size(FILE *stream, const char *path, size_t *size, thrum_error *error) {
  errno = 0;
  if (fgetc(stream) == EOF) {
    if (!ferror(stream))
      return fail(path, THRUM_BAD_FORMAT, "the file is empty", error);
    return fail(path, THRUM_IO, errno != 0 ? strerror(errno) : "cannot be read", error);
  }
  long end = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : -1;
  if (end <= 0 || fseek(stream, 0, SEEK_SET) != 0)
    return fail(path, THRUM_IO, "not a regular file", error);
  if ((unsigned long)end >= 0xFFFFFFFFul)
    return fail(path, THRUM_UNSUPPORTED, "4 GiB or more: no model file is that large", error);
  *size = (size_t)end;
  return THRUM_OK;
}

// the whole file
static thrum_status read_block(FILE *stream, const char *path, unsigned char **block, size_t *size,
                               thrum_error *error) {
  thrum_status status = find_size(stream, path, size, error);
  if (status != THRUM_OK)
    return status;
  unsigned char *memory = allocate(*size);
  if (memory == NULL)
    return fail(path, THRUM_OUT_OF_MEMORY, "no memory to load the model", error);
  if (fread(memory, 1, *size, stream) != *size || fgetc(stream) != EOF) {
    free(memory);
    return fail(path, THRUM_IO, "cannot be read to its end, or changed meanwhile", error);
  }
  *block = memory;
  return THRUM_OK;
}

// lays the model out in a block of its own; takes the file's over
static thrum_status adopt(unsigned char *file, size_t size, const thrum_model **model,
                          thrum_error *error) {
  size_t needed = 0;
  thrum_status status = thrum_model_size(file, size, &needed, error);
  void *memory = status == THRUM_OK ? allocate(needed) : NULL;
  if (status == THRUM_OK && memory == NULL)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory to load the model");
  if (status == THRUM_OK)
    status = thrum_model_init(memory, needed, file, size, model, error);
  if (status != THRUM_OK)
    free(memory);
  free(file);
  return status;
}

thrum_status thrum_model_load(const char *path, const thrum_model **model, thrum_error *error) {
  if (path == NULL || model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_load: no path or no model");
  if (path[0] == '\0')
    return thrum_error_set(error, THRUM_IO, "the name of the model file is empty");
  errno = 0;
  FILE *stream = fopen(path, "rb");
  if (stream == NULL)
    return fail(path, THRUM_IO, errno != 0 ? strerror(errno) : "cannot be opened", error);
  unsigned char *block = NULL;
  size_t size = 0;
  thrum_status status = read_block(stream, path, &block, &size, error);
  fclose(stream);
  if (status != THRUM_OK)
    return status;
  thrum_error reason = {THRUM_OK, ""};
  status = adopt(block, size, model, &reason);
  return status == THRUM_OK ? status : fail(path, status, reason.message, error);
}

void thrum_model_free(const thrum_model *model) {
  free((void *)(uintptr_t)model);
}
