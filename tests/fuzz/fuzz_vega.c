/* Fuzz target of VegaFEM's bases (.U) and polynomials (.cub): the first byte says which.
 * sources: precompute/vega_reduced.c platform/allocate.c io/file.c platform/interrupt.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include "precompute/vega_reduced.h"
#include "tests/fuzz/fuzz_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size == 0)
    return 0;

  // the reader takes a path, so the input becomes a file
  thrum_imported_basis imported = {0};
  thrum_error error = {0};
  const char *path = fuzz_file(data + 1, size - 1);
  if (path == NULL)
    return 0;

  // the first byte chooses between a basis and a polynomial, and gives the rank of the latter
  thrum_status status;
  if (data[0] % 2 == 0) {
    status = thrum_vega_basis_read(path, &imported, &error);
  } else {
    // the rank of a polynomial comes from its basis, which is read first
    imported.rank = 1 + data[0] / 2 % 8;
    status = thrum_vega_cubic_read(path, &imported, &error);
  }

  fuzz_check(status, &error);

  thrum_imported_basis_free(&imported);
  return 0;
}
