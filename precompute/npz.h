/* Writing .npy and .npz files as docs/model_format.md describes: temporary file beside the target,
 * fsync, rename, so that a reader never sees half a file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_NPZ_H
#define THRUM_PRECOMPUTE_NPZ_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/model.h"

/* Writes a whole buffer to `path` through a temporary file beside it, fsync and rename. The one
 * way in which Thrum writes a file that somebody may be reading. */
thrum_status thrum_file_write_atomic(const char *path, const void *data, size_t size,
                                     thrum_error *error);

/* The same for output made piece by piece. open makes the temporary file, commit syncs and renames
 * it, abandon removes it. A zeroed writer is closed. */
typedef struct thrum_file_writer {
  void *stream; /* FILE * */
  char *path;
  char *temporary;
} thrum_file_writer;
thrum_status thrum_file_writer_open(const char *path, thrum_file_writer *writer,
                                    thrum_error *error);
thrum_status thrum_file_writer_put(thrum_file_writer *writer, const void *data, size_t size,
                                   thrum_error *error);
/* Syncs and closes, but does not rename yet: for files that belong together, so that all are whole
 * before the first takes its place. */
thrum_status thrum_file_writer_finish(thrum_file_writer *writer, thrum_error *error);
thrum_status thrum_file_writer_commit(thrum_file_writer *writer, thrum_error *error);
void thrum_file_writer_abandon(thrum_file_writer *writer);

/* What to do about a write that failed with this errno, to go behind the reason; "" when nothing
 * comes to mind. */
const char *thrum_file_hint(int number);

/* Reads a whole file into *data (malloc, caller frees); refuses directories and the like. A 0 that
 * *size does not count stands behind the last byte. */
thrum_status thrum_file_read(const char *path, void **data, size_t *size, thrum_error *error);

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

/* Header of a .npy 1.0 file for <f8, C order, `rows` x `columns` (columns 0: a plain vector),
 * padded to a multiple of 64; returns its length, at most 192 bytes. */
size_t thrum_npy_header_f8(unsigned char header[192], int64_t rows, int64_t columns);

/* Reads a .npy file of <f8, one- or two-dimensional (*columns is 0 for a plain vector), C order;
 * *values malloc'ed, caller frees. Values may be infinite or NaN. */
thrum_status thrum_npy_read_f8(const char *path, double **values, int64_t *rows, int64_t *columns,
                               thrum_error *error);

#endif
