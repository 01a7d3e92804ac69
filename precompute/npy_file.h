/* Header of a .npy array of any of the model file's types.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_NPY_FILE_H
#define THRUM_PRECOMPUTE_NPY_FILE_H

#include <stddef.h>
#include <stdint.h>

#define THRUM_NPY_HEADER_MAX 192

/* .npy 1.0, C order, padded with blanks to a multiple of 64; columns 0: a plain vector. Returns the
 * length. */
size_t thrum_npy_header(unsigned char header[THRUM_NPY_HEADER_MAX], const char *descr, int64_t rows,
                        int64_t columns);

#endif
