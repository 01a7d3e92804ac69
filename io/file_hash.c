/* Computes the 64-bit FNV-1a hash of a file's bytes. SPDX-License-Identifier: Apache-2.0 */
#include "io/file_hash.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

#define HASH_CHUNK 65536

thrum_status file_hash(const char *path, uint64_t *hash, thrum_error *error) {
  static const uint64_t offset = UINT64_C(0xcbf29ce484222325), prime = UINT64_C(0x100000001b3);
  FILE *file = fopen(path, "rb");
  unsigned char *bytes = malloc(HASH_CHUNK);
  uint64_t value = offset;
  bool failed = file == NULL || bytes == NULL;

  // the file is read in pieces, so that memory does not grow with it
  for (size_t count = 1; !failed && count > 0;) {
    count = fread(bytes, 1, HASH_CHUNK, file);
    for (size_t n = 0; n < count; n++)
      value = (value ^ bytes[n]) * prime;
    failed = ferror(file) != 0;
  }

  free(bytes);
  if (file != NULL)
    fclose(file);
  if (failed)
    return thrum_error_set(error, THRUM_IO, "%.300s: cannot be read", path);
  *hash = value;
  return THRUM_OK;
}
