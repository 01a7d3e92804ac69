/* Writes zip archives of stored members: local records with the bytes, then the directory, then the
 * end record. Source: PKWARE's APPNOTE.TXT 6.3. SPDX-License-Identifier: Apache-2.0 */
#include "io/zip_write.h"

#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/crc32.h"
#include "io/file.h"

#define LOCAL_SIZE 30u
#define CENTRAL_SIZE 46u
#define END_SIZE 22u
#define EXTRA_HEAD 4u
#define EXTRA_PADDING 0xD935u
#define ZIP_VERSION 20u
#define DOS_DATE 0x0021u /* 1 January 1980, the first day that zip knows */
#define FILE_LIMIT UINT64_C(0xFFFFFFFF)

static void put16(unsigned char *p, uint32_t value) {
  p[0] = (unsigned char)(value & 0xFFu);
  p[1] = (unsigned char)(value >> 8 & 0xFFu);
}

static void put32(unsigned char *p, uint32_t value) {
  put16(p, value & 0xFFFFu);
  put16(p + 2, value >> 16);
}

/* Returns the size of the extra record, at least its own head, that ends where the bytes must
 * begin. */
static size_t padding(uint64_t position) {
  size_t needed = (size_t)((THRUM_ALIGNMENT - position % THRUM_ALIGNMENT) % THRUM_ALIGNMENT);
  return needed < EXTRA_HEAD ? needed + THRUM_ALIGNMENT : needed;
}

thrum_status thrum_zip_plan(thrum_zip_source *members, int count, const char *what,
                            thrum_error *error) {
  uint64_t at = 0, directory_size = 0;
  for (int n = 0; n < count; n++) {
    thrum_zip_source *member = &members[n];
    const size_t name_size = strlen(member->name);
    member->offset = (uint32_t)at;
    member->extra = member->aligned ? padding(at + LOCAL_SIZE + name_size) : 0;

    // each size is far below 2^63 and `at` below 2^32, so the sum is exact
    at += LOCAL_SIZE + name_size + member->extra + member->head_size + member->data_size;
    directory_size += CENTRAL_SIZE + name_size;

    // the directory behind the members must be addressable too
    if (at + directory_size + END_SIZE >= FILE_LIMIT)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "the file would reach 4 GiB with '%s', more than %s without zip64 can "
                             "hold: use a smaller rank or mesh",
                             member->name, what);
  }
  return THRUM_OK;
}

static uint32_t member_size(const thrum_zip_source *member) {
  return (uint32_t)(member->head_size + member->data_size);
}

/* Writes the fields that local and central records share, from `version needed` to the length of
 * the name. */
static void put_common(unsigned char *p, const thrum_zip_source *member) {
  put16(p, ZIP_VERSION);
  put16(p + 2, 0); // flags
  put16(p + 4, 0); // stored
  put16(p + 6, 0); // time
  put16(p + 8, DOS_DATE);
  put32(p + 10, member->crc);
  put32(p + 14, member_size(member));
  put32(p + 18, member_size(member));
  put16(p + 22, (uint32_t)strlen(member->name));
}

static thrum_status write_member(thrum_file_writer *writer, const thrum_zip_source *member,
                                 thrum_error *error) {
  unsigned char record[LOCAL_SIZE + THRUM_ZIP_NAME_MAX + THRUM_ALIGNMENT + EXTRA_HEAD] = {0};
  const size_t name_size = strlen(member->name);

  // the local record repeats what the directory says
  memcpy(record, "PK\3\4", 4);
  put_common(record + 4, member);
  put16(record + 28, (uint32_t)member->extra);
  memcpy(record + LOCAL_SIZE, member->name, name_size);

  // the extra field is padding, so that the bytes can be mapped at an aligned address
  unsigned char *extra = record + LOCAL_SIZE + name_size;
  if (member->extra > 0) {
    put16(extra, EXTRA_PADDING);
    put16(extra + 2, (uint32_t)(member->extra - EXTRA_HEAD));
  }

  THRUM_TRY(thrum_file_writer_put(writer, record, LOCAL_SIZE + name_size + member->extra, error));
  if (member->head_size > 0)
    THRUM_TRY(thrum_file_writer_put(writer, member->head, member->head_size, error));
  return thrum_file_writer_put(writer, member->data, (size_t)member->data_size, error);
}

static thrum_status write_directory(thrum_file_writer *writer, const thrum_zip_source *members,
                                    int count, thrum_error *error) {
  uint32_t directory = 0, size = 0;
  for (int n = 0; n < count; n++) {
    const thrum_zip_source *member = &members[n];
    const size_t name_size = strlen(member->name);
    unsigned char record[CENTRAL_SIZE + THRUM_ZIP_NAME_MAX] = {0};
    memcpy(record, "PK\1\2", 4);
    put16(record + 4, ZIP_VERSION);
    put_common(record + 6, member);
    put32(record + 42, member->offset);
    memcpy(record + CENTRAL_SIZE, member->name, name_size);
    THRUM_TRY(thrum_file_writer_put(writer, record, CENTRAL_SIZE + name_size, error));
    size += (uint32_t)(CENTRAL_SIZE + name_size);
    directory =
        (uint32_t)(member->offset + LOCAL_SIZE + name_size + member->extra) + member_size(member);
  }

  // readers begin with the end record, which tells where the directory is
  unsigned char end[END_SIZE] = {0};
  memcpy(end, "PK\5\6", 4);
  put16(end + 8, (uint32_t)count);
  put16(end + 10, (uint32_t)count);
  put32(end + 12, size);
  put32(end + 16, directory);
  return thrum_file_writer_put(writer, end, sizeof end, error);
}

static void compute_checksums(thrum_zip_source *members, int count) {
  thrum_crc32_table table;
  thrum_crc32_prepare(&table);
  for (int n = 0; n < count; n++) {
    thrum_zip_source *member = &members[n];
    member->crc = 0;
    if (member->head_size > 0)
      member->crc = thrum_crc32(&table, 0, member->head, member->head_size);
    member->crc = thrum_crc32(&table, member->crc, member->data, (size_t)member->data_size);
  }
}

thrum_status thrum_zip_write(const char *path, thrum_zip_source *members, int count,
                             thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  thrum_status status = THRUM_OK;
  compute_checksums(members, count);
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  for (int n = 0; n < count && status >= 0; n++)
    status = write_member(&writer, &members[n], error);
  THRUM_THEN(status, write_directory(&writer, members, count, error));

  // the target keeps its old contents unless all was written
  return thrum_file_writer_end(&writer, status, error);
}
