/* Writing .npy and .npz files as docs/model_format.md describes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_NPZ_H
#define THRUM_IO_NPZ_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/model.h"

/* One array of an .npz. */
typedef struct thrum_npz_array {
  const char *name;      /* at most 27 characters, [a-z][a-z0-9_]* */
  const char *descr;     /* <f8, <f4, <i4, |u1 */
  int64_t rows, columns; /* columns 0: a plain vector */
  const void *data;
  size_t size; /* bytes of data */
} thrum_npz_array;

/* One entry of an X-list such as THRUM_MODEL_ARRAYS as an initialiser. `rows_` and `columns_` are
 * the list's: expressions, where the sizes that it names are in scope; `columns_` the literal 1 is
 * a plain vector. */
#define THRUM_NPZ_ARRAY(type, name_, rows_, columns_, data_)                                       \
  {                                                                                                \
    .name = #name_, .descr = THRUM_NPZ_DESCR_##type, .rows = (rows_),                              \
    .columns = #columns_[0] == '1' && #columns_[1] == '\0' ? 0 : (columns_), .data = (data_),      \
    .size = (size_t)(rows_) * (size_t)(columns_) * sizeof(thrum_##type)                            \
  }

/* Types of the lists as .npy spells them. */
#define THRUM_NPZ_DESCR_f8 "<f8"
#define THRUM_NPZ_DESCR_f4 "<f4"
#define THRUM_NPZ_DESCR_i4 "<i4"
#define THRUM_NPZ_DESCR_u1 "|u1"

/* Writes at most 32 arrays as docs/model_format.md says; 4 GiB or more is refused before anything
 * is written. */
thrum_status thrum_npz_write(const char *path, const thrum_npz_array *arrays, int count,
                             thrum_error *error);

/* Writes the model file (checked first with thrum_model_check). 4 GiB or more is refused before
 * anything is written. */
thrum_status thrum_model_save(const char *path, const thrum_model *model, thrum_error *error);

#endif
