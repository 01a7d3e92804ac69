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

/* Writes at most 32 arrays as docs/model_format.md says; 4 GiB or more is refused before anything
 * is written. */
thrum_status thrum_npz_write(const char *path, const thrum_npz_array *arrays, int count,
                             thrum_error *error);

/* Writes the model file (checked first with thrum_model_check). 4 GiB or more is refused before
 * anything is written. */
thrum_status thrum_model_save(const char *path, const thrum_model *model, thrum_error *error);

#endif
