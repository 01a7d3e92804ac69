/* Writes .npz files, the model file among them, as docs/model_format.md describes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_NPZ_H
#define THRUM_IO_NPZ_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/model.h"

/* An array of an .npz. */
typedef struct thrum_npz_array {
  const char *name;      /* at most 27 characters, [a-z][a-z0-9_]* */
  const char *descr;     /* <f8, <f4, <i4, |u1 */
  int64_t rows, columns; /* columns 0: a plain vector */
  const void *data;
  size_t size; /* bytes of data */
} thrum_npz_array;

/* The initialiser of an entry of an X-list such as THRUM_MODEL_ARRAYS. `rows_` and `columns_` are
 * expressions of the sizes that the list names, which must be in scope; the literal 1 as `columns_`
 * means a plain vector. */
#define THRUM_NPZ_ARRAY(type, name_, rows_, columns_, data_)                                       \
  {                                                                                                \
    .name = #name_, .descr = THRUM_NPZ_DESCR_##type, .rows = (rows_),                              \
    .columns = #columns_[0] == '1' && #columns_[1] == '\0' ? 0 : (columns_), .data = (data_),      \
    .size = (size_t)(rows_) * (size_t)(columns_) * sizeof(thrum_##type)                            \
  }

/* The types of the lists as .npy spells them. */
#define THRUM_NPZ_DESCR_f8 "<f8"
#define THRUM_NPZ_DESCR_f4 "<f4"
#define THRUM_NPZ_DESCR_i4 "<i4"
#define THRUM_NPZ_DESCR_u1 "|u1"

#define THRUM_NPZ_ARRAYS_MAX 48 /* in one file */

/* Writes at most THRUM_NPZ_ARRAYS_MAX arrays as docs/model_format.md says; 4 GiB or more is refused
 * before anything is written. */
thrum_status thrum_npz_write(const char *path, const thrum_npz_array *arrays, int count,
                             thrum_error *error);

/* Lists the arrays that a model has, in the order of the file; returns how many there are. Each
 * points into the model. */
int thrum_npz_of_model(const thrum_model *model, thrum_npz_array arrays[THRUM_NPZ_ARRAYS_MAX]);

/* Checks the model with thrum_model_check and writes the model file. 4 GiB or more is refused
 * before anything is written. */
thrum_status thrum_model_save(const char *path, const thrum_model *model, thrum_error *error);

#endif
