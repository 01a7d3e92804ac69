/* The X-list of thrum/embedding.h as a table, and a view of a surface file in which every array is
 * a run of bytes of any alignment; private to the runtime and to who writes the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_READOUT_EMBEDDING_PRIVATE_H
#define THRUM_RUNTIME_READOUT_EMBEDDING_PRIVATE_H

#include "core/model/archive.h"
#include "thrum/embedding.h"

/* Sizes by number; those behind the list's have their values in embedding.c. */
enum thrum_embedding_size_id {
#define X(name, meaning) THRUM_EMBEDDING_SIZE_##name,
  THRUM_EMBEDDING_SIZES(X)
#undef X
      THRUM_EMBEDDING_SIZE_COUNT,
  THRUM_EMBEDDING_SIZE_basis_rows = THRUM_EMBEDDING_SIZE_COUNT, /* 3 vertex_count */
  THRUM_EMBEDDING_SIZE_1,
  THRUM_EMBEDDING_SIZE_2,
  THRUM_EMBEDDING_SIZE_3,
  THRUM_EMBEDDING_SIZE_4
};

enum thrum_embedding_array_id {
#define X(type, name, rows, columns, presence, meaning) THRUM_EMBEDDING_ARRAY_##name,
  THRUM_EMBEDDING_ARRAYS(X)
#undef X
      THRUM_EMBEDDING_ARRAY_COUNT
};

extern const thrum_array_list thrum_embedding_list;

typedef struct thrum_embedding_layout {
  int64_t size[THRUM_EMBEDDING_SIZE_COUNT];
  const unsigned char *data[THRUM_EMBEDDING_ARRAY_COUNT]; /* NULL: absent; any alignment */
} thrum_embedding_layout;

/* Finds the arrays of a surface file; checks the file, the version, types and shapes, but no value.
 */
thrum_status thrum_embedding_read(const void *file, size_t file_size,
                                  thrum_embedding_layout *layout, thrum_error *error);

/* The arrays must be aligned to their entries. */
void thrum_embedding_fill(const thrum_embedding_layout *layout, thrum_embedding *embedding);

#endif
