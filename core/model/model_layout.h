/* The X-list of thrum/model.h as tables, shared by the reader and the writer of the model file, and
 * a view of a model in which every array is a run of bytes of any alignment.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_MODEL_MODEL_LAYOUT_H
#define THRUM_CORE_MODEL_MODEL_LAYOUT_H

#include <stddef.h>
#include <stdint.h>

#include "core/model/archive.h"
#include "thrum/model.h"

/* Sizes by number; behind those of the model the ones that a list entry may also name, whose values
 * are in model_layout.c. */
enum thrum_size_id {
#define X(name, meaning) THRUM_SIZE_##name,
  THRUM_MODEL_SIZES(X)
#undef X
      THRUM_SIZE_COUNT,
  THRUM_SIZE_basis_rows = THRUM_SIZE_COUNT, /* 3 vertex_count */
  THRUM_SIZE_point_rows,                    /* 9 point_count */
  THRUM_SIZE_modulus_rows,                  /* 2 region_count */
  THRUM_SIZE_guide_axes,                    /* 3 guide_count */
  THRUM_SIZE_1,
  THRUM_SIZE_2,
  THRUM_SIZE_3,
  THRUM_SIZE_4,
  THRUM_SIZE_6,
  THRUM_SIZE_18
};

enum thrum_array_id {
#define X(type, name, rows, columns, presence, meaning) THRUM_ARRAY_##name,
  THRUM_MODEL_ARRAYS(X)
#undef X
      THRUM_ARRAY_COUNT
};

/* Names of the sizes, basis_rows and what follows it included; constant. */
extern const char *const thrum_size_names[THRUM_SIZE_guide_axes + 1];

/* One entry an array, in file order; constant. */
extern const thrum_array_info thrum_array_table[THRUM_ARRAY_COUNT];
extern const thrum_array_list thrum_model_list;

typedef struct thrum_layout {
  int64_t size[THRUM_SIZE_COUNT];
  const unsigned char *data[THRUM_ARRAY_COUNT]; /* NULL: absent; any alignment */
} thrum_layout;

/* Bytes of an array whose sizes have passed thrum_layout_check_sizes. */
size_t thrum_layout_bytes(const thrum_layout *layout, int array);

void thrum_layout_from_model(thrum_layout *layout, const thrum_model *model);

/* The arrays must be aligned to their entries. */
void thrum_layout_to_model(const thrum_layout *layout, thrum_model *model);

/* Which arrays must be there together, and how sizes depend on each other. Reads no array but
 * `format`, whose version it checks. */
thrum_status thrum_layout_check_presence(const thrum_layout *layout, thrum_error *error);
thrum_status thrum_layout_check_sizes(const thrum_layout *layout, thrum_error *error);

/* Every value: finite, ascending, in range. Needs the sizes checked. */
thrum_status thrum_layout_check_values(const thrum_layout *layout, thrum_error *error);

/* Finds and checks everything in a model file; the layout points into it. */
thrum_status thrum_layout_read(const void *file, size_t file_size, thrum_layout *layout,
                               thrum_error *error);

#endif
