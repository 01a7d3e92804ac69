/* Computes the 64-bit FNV-1a hash of a file's bytes. SPDX-License-Identifier: Apache-2.0 */
#include "io/file_hash.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "thrum/thrum.h"

#define HASH_CHUNK 65536

#define HASH_START UINT64_C(0xcbf29ce484222325)
#define HASH_PRIME UINT64_C(0x100000001b3)

uint64_t hash_bytes(uint64_t hash, const void *data, size_t size) {
  hash = hash == 0 ? HASH_START : hash;
  const unsigned char *bytes = data;
  for (size_t n = 0; n < size; n++)
    hash = (hash ^ bytes[n]) * HASH_PRIME;
  return hash;
}

thrum_status file_hash(const char *path, uint64_t *hash, thrum_error *error) {
  FILE *file = fopen(path, "rb");
  unsigned char *bytes = malloc(HASH_CHUNK);
  uint64_t value = HASH_START;
  int failure = file == NULL || bytes == NULL ? errno : 0;

  // the file is read in pieces, so that memory does not grow with it
  for (size_t count = 1; failure == 0 && count > 0;) {
    count = fread(bytes, 1, HASH_CHUNK, file);
    value = hash_bytes(value, bytes, count);
    if (ferror(file) != 0)
      failure = errno;
  }

  free(bytes);
  if (file != NULL)
    fclose(file);
  if (failure != 0)
    return thrum_error_set(error, failure == ENOMEM ? THRUM_OUT_OF_MEMORY : THRUM_IO,
                           "%.300s: cannot be read: %s", path, strerror(failure));
  *hash = value;
  return THRUM_OK;
}
