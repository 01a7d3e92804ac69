/* Writes the headers of .npy files and reads .npy files (NumPy enhancement proposal 1, format 1.0).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/npy_file.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/npy.h"
#include "io/file.h"

size_t thrum_npy_header(unsigned char header[THRUM_NPY_HEADER_MAX], const char *descr, int64_t rows,
                        int64_t columns) {
  char shape[48];
  if (columns == 0)
    snprintf(shape, sizeof shape, "(%" PRId64 ",)", rows);
  else
    snprintf(shape, sizeof shape, "(%" PRId64 ", %" PRId64 ")", rows, columns);

  // magic string, version and the dictionary that describes the array
  memcpy(header, "\x93NUMPY\1\0", 8);
  int text = snprintf((char *)header + 10, THRUM_NPY_HEADER_MAX - 10,
                      "{'descr': '%s', 'fortran_order': False, 'shape': %s, }", descr, shape);

  // blanks and a newline bring the data behind it to a multiple of 64
  size_t used = 10 + (size_t)text;
  size_t size = (used + 1 + 63) / 64 * 64;
  memset(header + used, ' ', size - used - 1);
  header[size - 1] = '\n';

  // the length of the dictionary is little-endian
  header[8] = (unsigned char)((size - 10) & 0xFFu);
  header[9] = (unsigned char)((size - 10) >> 8);
  return size;
}

size_t thrum_npy_header_f8(unsigned char header[192], int64_t rows, int64_t columns) {
  return thrum_npy_header(header, "<f8", rows, columns);
}

static thrum_status parse_f8(const void *bytes, size_t size, const char *where, thrum_npy *npy,
                             thrum_error *error) {
  THRUM_TRY(thrum_npy_parse(bytes, size, where, npy, error));
  THRUM_TRY(thrum_npy_expect(npy, "<f8", 8, where, error));

  // the callers know only vectors and matrices
  if (npy->dims == 1 || npy->dims == 2)
    return THRUM_OK;

  char shape[96];
  thrum_npy_shape_text(npy, shape);
  return thrum_error_set(error, THRUM_BAD_SHAPE, "%s has shape %s, a vector or a matrix is needed",
                         where, shape);
}

thrum_status thrum_npy_read_f8(const char *path, double **values, int64_t *rows, int64_t *columns,
                               thrum_error *error) {
  void *bytes = NULL;
  size_t size = 0;
  THRUM_TRY(thrum_file_read(path, &bytes, &size, error));

  // the end of a long path, so that the reason still fits behind it in a message
  const char *where = strlen(path) > 200 ? path + strlen(path) - 200 : path;

  thrum_npy npy;
  thrum_status status = parse_f8(bytes, size, where, &npy, error);

  // the parsed data lies inside the file's bytes, which are freed
  double *copy = NULL;
  if (status == THRUM_OK) {
    copy = malloc(npy.size > 0 ? npy.size : 1);
    if (copy == NULL)
      status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "%s: no memory for its values", where);
  }

  if (status == THRUM_OK) {
    memcpy(copy, npy.data, npy.size);
    *values = copy;
    *rows = npy.shape[0];
    *columns = npy.dims == 1 ? 0 : npy.shape[1];
  }
  free(bytes);
  return status;
}

thrum_status thrum_npy_write_f8(const char *path, const double *values, int64_t rows,
                                int64_t columns, thrum_error *error) {
  unsigned char header[THRUM_NPY_HEADER_MAX];
  thrum_file_writer writer = {0};
  const size_t size = thrum_npy_header_f8(header, rows, columns);
  const size_t count = (size_t)rows * (size_t)(columns > 0 ? columns : 1);
  thrum_status status = thrum_file_writer_open(path, &writer, error);
  THRUM_THEN(status, thrum_file_writer_put(&writer, header, size, error));
  THRUM_THEN(status, thrum_file_writer_put(&writer, values, count * sizeof *values, error));
  return thrum_file_writer_end(&writer, status, error);
}
