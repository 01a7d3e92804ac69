/* The header of a .npy array of format 1.0, read from memory.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_NPY_H
#define THRUM_CORE_BASE_NPY_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define THRUM_NPY_DIMS_MAX 8

typedef struct thrum_npy {
  char type[8]; /* descr as it stands: <f8, <f4, <i4, |u1, anything else of up to 7 characters */
  int fortran;  /* first index fastest */
  int dims;
  int64_t shape[THRUM_NPY_DIMS_MAX];
  const unsigned char *data; /* behind the header, any alignment */
  size_t size;               /* bytes of data */
} thrum_npy;

/* Parses the header of the `size` bytes at `bytes`. Messages begin with `where`. The size of the
 * data is not compared with the shape: thrum_npy_expect does that. */
thrum_status thrum_npy_parse(const void *bytes, size_t size, const char *where, thrum_npy *npy,
                             thrum_error *error);

/* Refuses an array that is not of `type` and `item` bytes an entry, in C order and of exactly
 * the size that its shape asks for. */
thrum_status thrum_npy_expect(const thrum_npy *npy, const char *type, size_t item,
                              const char *where, thrum_error *error);

/* The shape as Python writes it, such as (3, 2) or (5,), cut to fit. */
void thrum_npy_shape_text(const thrum_npy *npy, char text[96]);

#endif
