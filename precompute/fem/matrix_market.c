/* The Matrix Market exchange format: a banner, comments, "rows columns entries", then one line
 * "row column value" an entry of the lower triangle, numbered from 1.
 * R. Boisvert, R. Pozo, K. Remington 1996, The Matrix Market exchange formats, NISTIR 5935.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/matrix_market.h"

#include <inttypes.h>
#include <stdio.h>

#include "io/file.h"

thrum_status thrum_matrix_market_write(const char *path, const thrum_sparse *matrix,
                                       const char *about, thrum_error *error) {
  thrum_file_writer writer = {0};
  thrum_status status = thrum_file_writer_open(path, &writer, error);

  // the head: what it is, and its sizes
  char line[400];
  if (status >= 0) {
    const int length = snprintf(line, sizeof line,
                                "%%%%MatrixMarket matrix coordinate real symmetric\n"
                                "%% %.200s\n%" PRId64 " %" PRId64 " %" PRId64 "\n",
                                about, matrix->size, matrix->size, matrix->begin[matrix->size]);
    status = thrum_file_writer_put(&writer, line, (size_t)length, error);
  }

  // the entries, counted from 1
  for (int64_t column = 0; column < matrix->size && status >= 0; column++)
    for (int64_t n = matrix->begin[column]; n < matrix->begin[column + 1] && status >= 0; n++) {
      const int length = snprintf(line, sizeof line, "%" PRId64 " %" PRId64 " %.17g\n",
                                  matrix->row[n] + 1, column + 1, matrix->value[n]);
      status = thrum_file_writer_put(&writer, line, (size_t)length, error);
    }

  return thrum_file_writer_end(&writer, status, error);
}

thrum_status thrum_rows_write(const char *path, const thrum_fem *fem, thrum_error *error) {
  thrum_file_writer writer = {0};
  thrum_status status = thrum_file_writer_open(path, &writer, error);
  for (int64_t f = 0; f < fem->free_count && status >= 0; f++) {
    char line[32];
    const int32_t component = fem->component[f];
    const int length =
        snprintf(line, sizeof line, "%d %c\n", component / 3 + 1, "xyz"[component % 3]);
    status = thrum_file_writer_put(&writer, line, (size_t)length, error);
  }
  return thrum_file_writer_end(&writer, status, error);
}
