/* The one list of arrays of thrum/model.h, unfolded into tables. See model_layout.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/model/model_layout.h"

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

const char *const thrum_size_names[THRUM_SIZE_guide_axes + 1] = {
#define X(name, meaning) #name,
    THRUM_MODEL_SIZES(X)
#undef X
        "basis_rows",
    "point_rows", "modulus_rows", "guide_axes"};

// rows of the basis come in threes, and a gradient has nine; then the literals
#define AFTER(name) [THRUM_SIZE_##name - THRUM_SIZE_COUNT]
static const thrum_derived_size derived_sizes[] = {
    AFTER(basis_rows) = {3, THRUM_SIZE_vertex_count},
    AFTER(point_rows) = {9, THRUM_SIZE_point_count},
    AFTER(modulus_rows) = {2, THRUM_SIZE_region_count},
    AFTER(guide_axes) = {3, THRUM_SIZE_guide_count},
    AFTER(1) = {1, -1},
    AFTER(2) = {2, -1},
    AFTER(3) = {3, -1},
    AFTER(4) = {4, -1},
    AFTER(6) = {6, -1},
    AFTER(18) = {18, -1}};
#undef AFTER

const thrum_array_list thrum_model_list = {thrum_array_table, THRUM_ARRAY_COUNT,
                                           THRUM_SIZE_COUNT,  THRUM_SIZE_guide_axes + 1,
                                           thrum_size_names,  derived_sizes};

size_t thrum_layout_bytes(const thrum_layout *layout, int array) {
  return thrum_archive_bytes(&thrum_model_list, layout->size, array);
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
  model->point_plastic = NULL;
  model->levels = NULL;
  model->inertia = NULL;
  model->damping = NULL;
  model->unit_energy = 0.0;
}
