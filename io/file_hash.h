/* Hashes of files. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_FILE_HASH_H
#define THRUM_IO_FILE_HASH_H

#include "thrum/status.h"
#include <stdint.h>

/* Computes the 64-bit FNV-1a hash of a file's bytes. */
thrum_status file_hash(const char *path, uint64_t *hash, thrum_error *error);

#endif
