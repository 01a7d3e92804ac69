/* Loading a model file from disk into one heap block. The file is read into a block that is freed
 * when the model is laid out in its own.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "core/model/file_buffer.h"
#include "core/model/model_layout.h"

// lays the model out in a block of its own; takes the file's over
static thrum_status adopt(unsigned char *file, size_t size, const thrum_model **model,
                          thrum_error *error) {
  size_t needed = 0;
  thrum_status status = thrum_model_size(file, size, &needed, error);
  void *memory = status == THRUM_OK ? thrum_file_buffer_allocate(needed) : NULL;
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
  unsigned char *block = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_buffer_read(path, &block, &size, error));
  thrum_error reason = {.status = THRUM_OK};
  thrum_status status = adopt(block, size, model, &reason);
  return status == THRUM_OK ? status : thrum_file_buffer_fail(path, status, reason.message, error);
}

void thrum_model_destroy(const thrum_model *model) {
  free((void *)(uintptr_t)model);
}
