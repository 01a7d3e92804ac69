/* Header of a .npy array of any of the model file's types.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_NPY_FILE_H
#define THRUM_IO_NPY_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define THRUM_NPY_HEADER_MAX 192

/* .npy 1.0, C order, padded with blanks to a multiple of 64; columns 0: a plain vector. Returns the
 * length. */
size_t thrum_npy_header(unsigned char header[THRUM_NPY_HEADER_MAX], const char *descr, int64_t rows,
                        int64_t columns);

/* Header of a .npy 1.0 file for <f8, C order, `rows` x `columns` (columns 0: a plain vector),
 * padded to a multiple of 64; returns its length, at most 192 bytes. */
size_t thrum_npy_header_f8(unsigned char header[192], int64_t rows, int64_t columns);

/* Reads a .npy file of <f8, one- or two-dimensional (*columns is 0 for a plain vector), C order;
 * *values malloc'ed, caller frees. Values may be infinite or NaN. */
thrum_status thrum_npy_read_f8(const char *path, double **values, int64_t *rows, int64_t *columns,
                               thrum_error *error);

#endif
