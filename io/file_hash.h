/* Hashes of files and of bytes in memory. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_FILE_HASH_H
#define THRUM_IO_FILE_HASH_H

#include "thrum/status.h"
#include <stddef.h>
#include <stdint.h>

/* FNV-1a of 64 bits, from `hash`; 0 starts. */
uint64_t hash_bytes(uint64_t hash, const void *data, size_t size);

/* Computes the 64-bit FNV-1a hash of a file's bytes. */
thrum_status file_hash(const char *path, uint64_t *hash, thrum_error *error);

#endif
