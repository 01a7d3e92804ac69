/* The head of a snapshot (seal.h). The checksum is CRC-32, which finds every change of up to 32
 * bits in a row. Cost: about one cycle a byte. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/seal.h"

#include <string.h>

#include "core/base/crc32.h"

/* Reads differently in the other byte order. */
#define ORDER UINT32_C(0x01020304)
#define ORDER_SWAPPED UINT32_C(0x04030201)

typedef struct seal {
  char letters[8];
  uint32_t order, version;
  uint64_t size; /* of the whole, in bytes */
  uint32_t checksum;
  uint32_t unused; /* zero */
} seal;

_Static_assert(sizeof(seal) == THRUM_SEAL_BYTES, "the head has no padding");

/* The checksum of the head, whose own field counts as zero, and then of the content. */
static uint32_t checksum_of(seal head, const unsigned char *memory) {
  thrum_crc32_table table;
  thrum_crc32_prepare(&table);
  head.checksum = 0;
  const uint32_t crc = thrum_crc32(&table, 0, &head, sizeof head);
  return thrum_crc32(&table, crc, memory + sizeof head, (size_t)head.size - sizeof head);
}

void thrum_seal_put(void *memory, size_t size, thrum_seal_kind kind) {
  seal head = {.order = ORDER, .version = kind.version, .size = size};
  memcpy(head.letters, kind.letters, sizeof head.letters);
  head.checksum = checksum_of(head, memory);
  memcpy(memory, &head, sizeof head);
}

thrum_status thrum_seal_check(const void *memory, size_t size, thrum_seal_kind kind,
                              size_t expected, thrum_error *error) {
  seal head;
  if (!memory)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the snapshot's memory is NULL");
  if (size < sizeof head)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "a snapshot of %zu bytes is wanted, the memory has %zu", expected, size);

  // what it is and who can read it, before anything that depends on that
  memcpy(&head, memory, sizeof head);
  if (memcmp(head.letters, kind.letters, sizeof head.letters) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "the memory holds no snapshot of this kind");
  if (head.order == ORDER_SWAPPED)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the snapshot was made on a machine of the other byte order");
  if (head.order != ORDER)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "the snapshot's byte order is none");
  if (head.version != kind.version)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the snapshot has version %lu, this library reads version %lu",
                           (unsigned long)head.version, (unsigned long)kind.version);

  // sizes, then every bit
  if (head.size != expected)
    return thrum_error_set(
        error, THRUM_MODEL_MISMATCH,
        "the snapshot is of another model, of other options or of another scene: "
        "it has %llu bytes where %zu are needed",
        (unsigned long long)head.size, expected);
  if (size < expected)
    return thrum_error_set(error, THRUM_BUFFER_TOO_SMALL,
                           "the snapshot was cut short: it has %zu bytes, the memory %zu", expected,
                           size);
  if (head.checksum != checksum_of(head, memory))
    return thrum_error_set(error, THRUM_BAD_CHECKSUM,
                           "the snapshot does not match its checksum: its bits have changed");
  return THRUM_OK;
}
