/* Loading a surface file into one heap block, as an embedding or as a surface for display.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "core/model/file_buffer.h"
#include "runtime/readout/embedding_private.h"

/* Copies the embedding behind its struct, each array at a multiple of 64: sizes are below 4 GiB, as
 * the file was. */
static thrum_status lay_out(thrum_embedding_layout *layout, const thrum_embedding **embedding,
                            thrum_error *error) {
  // one block for the struct and all arrays
  size_t size = thrum_round_up(sizeof(thrum_embedding));
  for (int a = 0; a < THRUM_EMBEDDING_ARRAY_COUNT; a++)
    if (layout->data[a] != NULL)
      size += thrum_round_up(thrum_archive_bytes(&thrum_embedding_list, layout->size, a));
  unsigned char *memory = thrum_file_buffer_allocate(size);
  if (memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory to load the surface");

  // the arrays follow the struct
  thrum_archive_copy(&thrum_embedding_list, layout->size, layout->data,
                     memory + thrum_round_up(sizeof(thrum_embedding)));

  // the entries are checked before the embedding is handed out
  thrum_embedding *made = (thrum_embedding *)(void *)memory;
  thrum_embedding_fill(layout, made);
  const thrum_status status = thrum_embedding_check(made, error);
  if (status != THRUM_OK)
    free(memory);
  else
    *embedding = made;
  return status;
}

thrum_status thrum_embedding_load(const char *path, const thrum_embedding **embedding,
                                  thrum_error *error) {
  if (path == NULL || embedding == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thrum_embedding_load: no path or no embedding");
  if (path[0] == '\0')
    return thrum_error_set(error, THRUM_IO, "the name of the surface file is empty");

  // the whole file, which is freed once its arrays are laid out
  unsigned char *file = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_buffer_read(path, &file, &size, error));
  thrum_error reason = {.status = THRUM_OK};
  thrum_embedding_layout layout;
  thrum_status status = thrum_embedding_read(file, size, &layout, &reason);
  if (status == THRUM_OK)
    status = lay_out(&layout, embedding, &reason);
  free(file);
  return status == THRUM_OK ? status : thrum_file_buffer_fail(path, status, reason.message, error);
}

void thrum_embedding_destroy(const thrum_embedding *embedding) {
  free((void *)(uintptr_t)embedding);
}

static thrum_status make_surface(const thrum_embedding *embedding, const thrum_model *model,
                                 const thrum_surface **surface, thrum_error *error) {
  size_t size = 0;
  const thrum_surface_def def = thrum_embedding_surface(embedding);
  THRUM_TRY(thrum_embedding_fits(embedding, model, error));
  THRUM_TRY(thrum_surface_size(model, &def, &size, error));
  void *memory = thrum_file_buffer_allocate(size);
  if (memory == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the surface");
  thrum_status status = thrum_surface_init(memory, size, model, &def, surface, error);
  if (status != THRUM_OK)
    free(memory);
  return status;
}

thrum_status thrum_surface_load(const char *path, const thrum_model *model,
                                const thrum_surface **surface, thrum_error *error) {
  if (model == NULL || surface == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thrum_surface_load: no model or no surface");
  const thrum_embedding *embedding = NULL;
  THRUM_TRY(thrum_embedding_load(path, &embedding, error));
  thrum_error reason = {.status = THRUM_OK};
  thrum_status status = make_surface(embedding, model, surface, &reason);
  thrum_embedding_destroy(embedding);
  return status == THRUM_OK ? status : thrum_file_buffer_fail(path, status, reason.message, error);
}

void thrum_surface_destroy(const thrum_surface *surface) {
  free((void *)(uintptr_t)surface);
}
