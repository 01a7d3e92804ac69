/* Writes zip archives of stored members, without zip64. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_ZIP_WRITE_H
#define THRUM_IO_ZIP_WRITE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/status.h"

#define THRUM_ZIP_NAME_MAX 256 /* bytes of a member's name, its end included */

/* A member: its bytes are those of `head` and then those of `data`, which the caller owns. */
typedef struct thrum_zip_source {
  char name[THRUM_ZIP_NAME_MAX];
  const void *head; /* may be NULL where head_size is 0 */
  size_t head_size;
  const void *data;
  uint64_t data_size;
  bool aligned; /* the bytes begin at a multiple of THRUM_ALIGNMENT of the file */
  /* by thrum_zip_plan and thrum_zip_write */
  uint32_t offset, crc;
  size_t extra; /* bytes of padding in front of them */
} thrum_zip_source;

/* Lays the members out. Refuses what would reach 4 GiB, with the member and `what` the file is. */
thrum_status thrum_zip_plan(thrum_zip_source *members, int count, const char *what,
                            thrum_error *error);

/* Writes members that were laid out; `path` keeps its contents unless all is written. */
thrum_status thrum_zip_write(const char *path, thrum_zip_source *members, int count,
                             thrum_error *error);

#endif
