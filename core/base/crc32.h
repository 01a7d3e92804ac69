/* CRC-32 of zip files (reflected polynomial 0xEDB88320), eight bytes a step.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_CRC32_H
#define THRUM_CORE_BASE_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* Made by thrum_crc32_prepare, constant afterwards; 8 KiB, lives where the caller likes. */
typedef struct thrum_crc32_table {
  uint32_t row[8][256]; /* row[k][b]: remainder of byte b followed by k zero bytes */
} thrum_crc32_table;

void thrum_crc32_prepare(thrum_crc32_table *table);

/* Checksum of all bytes so far: `crc` is 0 at the start, then the value of the piece before. */
uint32_t thrum_crc32(const thrum_crc32_table *table, uint32_t crc, const void *data, size_t size);

#endif
