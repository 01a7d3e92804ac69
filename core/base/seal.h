/* The head of a snapshot: what it is, of which version, in which byte order, and the checksum of
 * all of it. Private to the libraries; a snapshot is these bytes and then its content.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_SEAL_H
#define THRUM_CORE_BASE_SEAL_H

#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

/* Bytes of the head. */
#define THRUM_SEAL_BYTES 32

/* The kind of a content, in eight letters, and the version of its layout. */
typedef struct thrum_seal_kind {
  char letters[8];
  uint32_t version;
} thrum_seal_kind;

/* Fills the first THRUM_SEAL_BYTES of `memory`, whose content up to `size` bytes is in place. Takes
 * 8 KiB of stack. Any thread. */
void thrum_seal_put(void *memory, size_t size, thrum_seal_kind kind);

/* Is `memory` a snapshot of this kind and version, of `expected` bytes, with every bit as it was
 * sealed? `size` is what the memory has: THRUM_BUFFER_TOO_SMALL. THRUM_INVALID_ARGUMENT for NULL,
 * THRUM_BAD_FORMAT where it is no such snapshot, THRUM_UNSUPPORTED for another version or byte
 * order, THRUM_MODEL_MISMATCH for another size, THRUM_BAD_CHECKSUM for changed bits. Takes 8 KiB of
 * stack. Any thread. */
thrum_status thrum_seal_check(const void *memory, size_t size, thrum_seal_kind kind,
                              size_t expected, thrum_error *error);

#endif
