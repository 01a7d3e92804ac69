/* Writes the headers of .npy files and reads .npy files of doubles.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_NPY_FILE_H
#define THRUM_IO_NPY_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define THRUM_NPY_HEADER_MAX 192

/* Writes the header of a .npy 1.0 file in C order, padded with blanks to a multiple of 64; columns
 * 0 means a plain vector. Returns the header's length. */
size_t thrum_npy_header(unsigned char header[THRUM_NPY_HEADER_MAX], const char *descr, int64_t rows,
                        int64_t columns);

/* Writes the header for <f8 in the same way; returns its length, at most 192 bytes. */
size_t thrum_npy_header_f8(unsigned char header[192], int64_t rows, int64_t columns);

/* Writes a .npy file of <f8, first beside its place and then renamed; columns 0 as above. */
thrum_status thrum_npy_write_f8(const char *path, const double *values, int64_t rows,
                                int64_t columns, thrum_error *error);

/* Reads a .npy file of <f8 in C order with one or two dimensions; *columns is 0 for a plain vector.
 * The caller frees *values, which may be infinite or NaN. */
thrum_status thrum_npy_read_f8(const char *path, double **values, int64_t *rows, int64_t *columns,
                               thrum_error *error);

#endif
