/* The one list of arrays of thrum/model.h, unfolded into tables. See model_layout.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/model/model_layout.h"

#define PRESENCE_REQUIRED 1
#define PRESENCE_OPTIONAL 0

const thrum_array_info thrum_array_table[THRUM_ARRAY_COUNT] = {
#define X(type, name, rows, columns, presence, meaning)                                            \
  {#name,                                                                                          \
   THRUM_DESCR_##type,                                                                             \
   sizeof(thrum_##type),                                                                           \
   THRUM_SIZE_##columns == THRUM_SIZE_1 ? 1 : 2,                                                   \
   THRUM_SIZE_##rows,                                                                              \
   THRUM_SIZE_##columns,                                                                           \
   THRUM_SIZE_##columns == THRUM_SIZE_1 ? "(" #rows ",)" : "(" #rows ", " #columns ")",            \
   PRESENCE_##presence},
    THRUM_MODEL_ARRAYS(X)
#undef X
};

const char *const thrum_size_names[THRUM_SIZE_point_rows + 1] = {
#define X(name, meaning) #name,
    THRUM_MODEL_SIZES(X)
#undef X
        "basis_rows",
    "point_rows"};

static int64_t extent(const int64_t *size, int size_id) {
  // literal extents have ids of their own, behind the sizes of the model
  switch (size_id) {
  // rows of the basis come in threes
  case THRUM_SIZE_basis_rows:
    return 3 * size[THRUM_SIZE_vertex_count];

  // a gradient has nine
  case THRUM_SIZE_point_rows:
    return 9 * size[THRUM_SIZE_point_count];

  // literal extents
  case THRUM_SIZE_1:
    return 1;
  case THRUM_SIZE_2:
    return 2;
  case THRUM_SIZE_3:
    return 3;
  case THRUM_SIZE_4:
    return 4;
  case THRUM_SIZE_6:
    return 6;

  default:
    return size[size_id];
  }
}

const thrum_array_list thrum_model_list = {thrum_array_table, THRUM_ARRAY_COUNT,
                                           THRUM_SIZE_COUNT,  THRUM_SIZE_point_rows + 1,
                                           thrum_size_names,  extent};

int64_t thrum_layout_extent(const thrum_layout *layout, int size_id) {
  return extent(layout->size, size_id);
}

size_t thrum_layout_bytes(const thrum_layout *layout, int array) {
  const thrum_array_info *info = &thrum_array_table[array];
  return (size_t)thrum_layout_extent(layout, info->rows) *
         (size_t)thrum_layout_extent(layout, info->columns) * info->item;
}

void thrum_layout_from_model(thrum_layout *layout, const thrum_model *model) {
#define X(name, meaning) layout->size[THRUM_SIZE_##name] = model->name;
  THRUM_MODEL_SIZES(X)
#undef X
#define X(type, name, rows, columns, presence, meaning)                                            \
  layout->data[THRUM_ARRAY_##name] = (const unsigned char *)model->name;
  THRUM_MODEL_ARRAYS(X)
#undef X
}

void thrum_layout_to_model(const thrum_layout *layout, thrum_model *model) {
// sizes and arrays come from the lists of the format
#define X(name, meaning) model->name = layout->size[THRUM_SIZE_##name];
  THRUM_MODEL_SIZES(X)
#undef X
#define X(type, name, rows, columns, presence, meaning)                                            \
  model->name = (const thrum_##type *)(const void *)layout->data[THRUM_ARRAY_##name];
  THRUM_MODEL_ARRAYS(X)
#undef X

  // the rest is derived from them later
  model->packed = NULL;
  model->packed_single = NULL;
  model->packed_count = 0;
  model->packed_c3 = model->packed_c4 = model->packed_gradients = NULL;
  model->identity = 0;
  model->shape = NULL;
  model->follow = model->follow_by_pair = NULL;
  model->follow_scale = 0.0;
}
