/* Reading a zip archive of stored members from memory, one member after the other.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_MODEL_ZIP_H
#define THRUM_CORE_MODEL_ZIP_H

#include <stddef.h>
#include <stdint.h>

#include "core/base/crc32.h"
#include "thrum/status.h"

#define THRUM_ZIP_MEMBERS_MAX 4096 /* keeps the search for duplicates short */

/* Position of a walk over an archive. Copying it copies the position. */
typedef struct thrum_zip {
  const unsigned char *bytes;
  size_t directory; /* offset of the central directory = end of the local records */
  size_t end;       /* offset of the end record = end of the central directory */
  size_t count;     /* members */
  size_t index;     /* members passed */
  size_t central;   /* offset of the next central record */
  size_t local;     /* offset of the next local record */
  thrum_crc32_table table;
} thrum_zip;

typedef struct thrum_zip_member {
  const char *name; /* not ended by 0; NULL after the last member */
  size_t name_size;
  const unsigned char *data; /* any alignment */
  size_t size;
} thrum_zip_member;

/* Finds the end record in the last 22 bytes and starts the walk. */
thrum_status thrum_zip_open(const void *file, size_t file_size, thrum_zip *zip, thrum_error *error);

/* Gives the next member, checked against its local record and its CRC-32. */
thrum_status thrum_zip_next(thrum_zip *zip, thrum_zip_member *member, thrum_error *error);

/* A member's name fit for a message: at most 40 printable characters, ended by 0. */
void thrum_zip_name_text(char text[48], const char *name, size_t name_size);

#endif
