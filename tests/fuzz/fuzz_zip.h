/* Support for fuzz targets of Thrum's .npz files: mutations get valid checksums, since otherwise
 * the checks behind them would never be reached. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_ZIP_H
#define THRUM_TESTS_FUZZ_FUZZ_ZIP_H

#include <stdint.h>
#include <string.h>

#include "core/base/crc32.h"

/* Bytes before the archive in an input, which choose what is done with it. */
#ifndef FUZZ_ZIP_AT
#define FUZZ_ZIP_AT 0
#endif

#define LOCAL 30 /* bytes of a member's header before its name; CENTRAL: in the directory */
#define CENTRAL 46

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);

static inline size_t number(const uint8_t *at, int bytes) {
  size_t value = 0;
  for (int n = bytes - 1; n >= 0; n--)
    value = value << 8 | at[n];
  return value;
}

static inline void put(uint8_t *at, uint32_t value) {
  for (int n = 0; n < 4; n++)
    at[n] = (uint8_t)(value >> 8 * n);
}

/* Gives the members that the directory names the checksums of their bytes. */
static inline void mend_checksums(uint8_t *data, size_t size) {
  static thrum_crc32_table table;
  if (table.row[0][1] == 0)
    thrum_crc32_prepare(&table);

  // every central record, at whatever offset the mutation left it
  for (size_t at = 0; at + CENTRAL <= size; at++) {
    if (memcmp(data + at, "PK\1\2", 4) != 0)
      continue;

    // the member that it names, if that lies within the input
    const size_t length = number(data + at + 20, 4), local = number(data + at + 42, 4);
    if (local > size || size - local < LOCAL || memcmp(data + local, "PK\3\4", 4) != 0)
      continue;
    const size_t begin =
        local + LOCAL + number(data + local + 26, 2) + number(data + local + 28, 2);
    if (begin > size || length > size - begin)
      continue;

    // both records get the checksum of the bytes as they are
    const uint32_t sum = thrum_crc32(&table, 0, data + begin, length);
    put(data + at + 16, sum);
    put(data + local + 14, sum);
  }
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
  // half of the inputs do something else with the same archive
  if (FUZZ_ZIP_AT > 0 && seed % 2 != 0 && size > FUZZ_ZIP_AT) {
    uint8_t plan[FUZZ_ZIP_AT + 1];
    memcpy(plan, data, FUZZ_ZIP_AT);
    memcpy(data, plan, LLVMFuzzerMutate(plan, FUZZ_ZIP_AT, FUZZ_ZIP_AT));
    return size;
  }
  const size_t now = LLVMFuzzerMutate(data, size, max_size);
  // wrong checksums remain part of the inputs
  if (seed % 16 != 0 && now > FUZZ_ZIP_AT)
    mend_checksums(data + FUZZ_ZIP_AT, now - FUZZ_ZIP_AT);
  return now;
}

#endif
