/* Models from bytes: in place, into the caller's memory, or made by hand; and their groups.
 * See thrum/model.h and docs/model_format.md. Nothing here allocates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "thrum/model.h"

#include <string.h>

#include "core/model/model_layout.h"
#include "core/polynomial/points.h"
#include "thrum/polynomial.h"

static int is_aligned(const void *p) {
  return (uintptr_t)p % THRUM_ALIGNMENT == 0;
}

thrum_status thrum_model_view(const void *file, size_t file_size, thrum_model *model,
                              thrum_error *error) {
  // a buffer that is used in place must be aligned
  if (file == NULL || model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_view: no file or no model");
  if (!is_aligned(file))
    return thrum_error_set(error, THRUM_MISALIGNED,
                           "the buffer of a model file must be aligned to 64 bytes to be used in "
                           "place: align it or use thrum_model_init");

  // the layout of the file; its arrays must be aligned too
  thrum_layout layout;
  THRUM_TRY(thrum_layout_read(file, file_size, &layout, error));
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++)
    if (layout.data[a] != NULL && !is_aligned(layout.data[a]))
      return thrum_error_set(error, THRUM_MISALIGNED,
                             "array '%s' is not aligned to 64 bytes in this file (numpy.savez does "
                             "not align): use thrum_model_init or thrum_model_load",
                             thrum_array_table[a].name);

  thrum_layout_to_model(&layout, model);
  model->identity = thrum_model_identity(model);
  return THRUM_OK;
}

// the struct, then every array and the packed coefficients, each at the next multiple of 64; 0 when
// no memory is that large
static size_t block_size(const thrum_layout *layout) {
  size_t size = thrum_round_up(sizeof(thrum_model));
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++) {
    if (layout->data[a] == NULL)
      continue;
    size_t bytes = thrum_round_up(thrum_layout_bytes(layout, a));
    if (bytes > PTRDIFF_MAX - size)
      return 0;
    size += bytes;
  }

  // a condensed model is packed when it is made steppable
  thrum_model model;
  thrum_layout_to_model(layout, &model);
  if (!thrum_has_energy(&model))
    return size;
  const size_t packed = thrum_round_up(thrum_model_pack_size(&model));
  return packed > PTRDIFF_MAX - size ? 0 : size + packed;
}

// reads the file and plans its block
static thrum_status plan(const void *file, size_t file_size, thrum_layout *layout, size_t *size,
                         thrum_error *error) {
  if (file == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "no bytes of a model file are given");
  THRUM_TRY(thrum_layout_read(file, file_size, layout, error));
  *size = block_size(layout);
  if (*size == 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "the model is larger than any memory");
  return THRUM_OK;
}

thrum_status thrum_model_size(const void *file, size_t file_size, size_t *size,
                              thrum_error *error) {
  thrum_layout layout;
  size_t needed = 0;
  if (size == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_size: no place for size");
  THRUM_TRY(plan(file, file_size, &layout, &needed, error));
  *size = needed;
  return THRUM_OK;
}

thrum_status thrum_model_init(void *memory, size_t memory_size, const void *file, size_t file_size,
                              const thrum_model **model, thrum_error *error) {
  if (memory == NULL || model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thrum_model_init: no memory or no place for the model");
  if (!is_aligned(memory))
    return thrum_error_set(error, THRUM_MISALIGNED,
                           "the memory of a model must be aligned to 64 bytes");

  // how much memory the model needs
  thrum_layout layout;
  size_t needed = 0;
  THRUM_TRY(plan(file, file_size, &layout, &needed, error));
  if (memory_size < needed)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the memory has %lu bytes, this model needs %lu",
                           (unsigned long)memory_size, (unsigned long)needed);

  // the arrays follow the struct
  unsigned char *next =
      thrum_archive_copy(&thrum_model_list, layout.size, layout.data,
                         (unsigned char *)memory + thrum_round_up(sizeof(thrum_model)));

  // behind them the packed coefficients, which the kernels read
  thrum_layout_to_model(&layout, memory);
  thrum_model *made = memory;
  if (thrum_has_energy(made))
    THRUM_TRY(
        thrum_model_pack(made, next, needed - (size_t)(next - (unsigned char *)memory), error));
  made->identity = thrum_model_identity(made);
  *model = made;
  return THRUM_OK;
}

int64_t thrum_model_masters(const thrum_model *model) {
  if (!model || !model->slave_map)
    return 0;
  return model->rank - model->slave_count;
}

thrum_status thrum_model_check_shapes(const thrum_model *model, thrum_error *error) {
  if (model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_check: no model");
  thrum_layout layout;
  thrum_layout_from_model(&layout, model);
  THRUM_TRY(thrum_layout_check_presence(&layout, error));
  return thrum_layout_check_sizes(&layout, error);
}

thrum_status thrum_model_check(const thrum_model *model, thrum_error *error) {
  thrum_layout layout;
  THRUM_TRY(thrum_model_check_shapes(model, error));
  thrum_layout_from_model(&layout, model);
  return thrum_layout_check_values(&layout, error);
}

const char *thrum_model_group_name(const thrum_model *model, int64_t index) {
  if (model == NULL || index < 0 || index >= model->group_count)
    return NULL;
  const char *name = (const char *)model->group_names;
  for (; index > 0; index--)
    name += strlen(name) + 1;
  return name;
}

thrum_status thrum_model_group(const thrum_model *model, const char *name, const int32_t **vertices,
                               int64_t *count, thrum_error *error) {
  if (model == NULL || name == NULL || vertices == NULL || count == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_group: an argument is NULL");

  // names stand one after the other, each ended by 0
  const char *known = (const char *)model->group_names;
  for (int64_t g = 0; g < model->group_count; g++, known += strlen(known) + 1) {
    if (strcmp(known, name) != 0)
      continue;
    int64_t begin = g == 0 ? 0 : model->group_ends[g - 1];
    *vertices = model->group_vertices + begin;
    *count = model->group_ends[g] - begin;
    return THRUM_OK;
  }

  // a wrong name is answered with one that exists
  if (model->group_count == 0)
    return thrum_error_set(error, THRUM_MISSING, "no group '%s': the model has no groups", name);
  return thrum_error_set(error, THRUM_MISSING, "no group '%s'; the first of %lu is '%s'", name,
                         (unsigned long)model->group_count, (const char *)model->group_names);
}
