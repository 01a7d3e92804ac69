/* Writes .npz files (docs/model_format.md): each array is a stored zip member whose data begins at
 * a multiple of 64 in the file. Model files have their arrays in the order of the list in
 * thrum/model.h.
 *
 *   local record (30) | name | 0xD935 record of zeros | .npy header (128) | data | ...
 *   central records (46 + name) | end record (22)
 *
 * Sizes are planned before anything is written, so that 4 GiB is refused in time; nothing depends
 * on the clock, so that equal models give equal files. Cost: one pass of CRC-32, one of writing.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/npz.h"

#include <stdio.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/crc32.h"
#include "io/file.h"
#include "io/npy_file.h"

#define LOCAL_SIZE 30u
#define CENTRAL_SIZE 46u
#define END_SIZE 22u
#define EXTRA_HEAD 4u
#define EXTRA_PADDING 0xD935u
#define ZIP_VERSION 20u
#define DOS_DATE 0x0021u /* 1 January 1980, the first day that zip knows */
#define NAME_MAX_SIZE 32u
#define FILE_LIMIT UINT64_C(0xFFFFFFFF)

/* The indices of a model's arrays, the absent ones too. */
enum {
#define X(type, name, rows, columns, presence, meaning) MODEL_ARRAY_##name,
  THRUM_MODEL_ARRAYS(X)
#undef X
      MODEL_ARRAYS
};
_Static_assert((int)MODEL_ARRAYS <= THRUM_NPZ_ARRAYS_MAX,
               "a plan has room for every array of a model");

/* A member of the file to come. */
typedef struct planned_member {
  char name[NAME_MAX_SIZE];
  size_t name_size;
  uint32_t offset; /* of the local record */
  size_t extra;    /* bytes of the local extra field */
  unsigned char header[THRUM_NPY_HEADER_MAX];
  size_t header_size;
  const void *data;
  uint64_t data_size;
  uint32_t crc;
} planned_member;

typedef struct file_plan {
  planned_member members[THRUM_NPZ_ARRAYS_MAX];
  int count;
  uint64_t directory; /* offset */
  uint64_t directory_size;
} file_plan;

static void put16(unsigned char *p, uint32_t value) {
  p[0] = (unsigned char)(value & 0xFFu);
  p[1] = (unsigned char)(value >> 8 & 0xFFu);
}

static void put32(unsigned char *p, uint32_t value) {
  put16(p, value & 0xFFFFu);
  put16(p + 2, value >> 16);
}

/* Returns the size of the extra record, at least its own head, that ends where the .npy header must
 * begin. */
static size_t padding(uint64_t position) {
  size_t needed = (size_t)((THRUM_ALIGNMENT - position % THRUM_ALIGNMENT) % THRUM_ALIGNMENT);
  return needed < EXTRA_HEAD ? needed + THRUM_ALIGNMENT : needed;
}

static void plan_member(const thrum_npz_array *array, uint64_t offset, planned_member *member) {
  memset(member, 0, sizeof *member);
  snprintf(member->name, sizeof member->name, "%s.npy", array->name);
  member->name_size = strlen(member->name);
  member->offset = (uint32_t)offset;
  member->header_size = thrum_npy_header(member->header, array->descr, array->rows, array->columns);
  member->extra = padding(offset + LOCAL_SIZE + member->name_size);
  member->data = array->data;
  member->data_size = array->size;
}

/* Lays all members out; refuses files that 32-bit offsets cannot address. */
static thrum_status plan_file(const thrum_npz_array *arrays, int count, file_plan *plan,
                              thrum_error *error) {
  uint64_t at = 0, directory_size = 0;
  for (plan->count = 0; plan->count < count; plan->count++) {
    planned_member *member = &plan->members[plan->count];
    plan_member(&arrays[plan->count], at, member);

    // each size is far below 2^63 and `at` below 2^32, so the sum is exact
    at += LOCAL_SIZE + member->name_size + member->extra + member->header_size + member->data_size;
    directory_size += CENTRAL_SIZE + member->name_size;

    // the directory behind the members must be addressable too
    if (at + directory_size + END_SIZE >= FILE_LIMIT)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "the file would reach 4 GiB with array '%s', more than an .npz "
                             "without zip64 can hold: use a smaller rank or mesh",
                             arrays[plan->count].name);
  }

  plan->directory = at;
  plan->directory_size = directory_size;
  return THRUM_OK;
}

static uint32_t member_size(const planned_member *member) {
  return (uint32_t)(member->header_size + member->data_size);
}

/* Writes the fields that local and central records share, from `version needed` to the length of
 * the name. */
static void put_common(unsigned char *p, const planned_member *member) {
  put16(p, ZIP_VERSION);
  put16(p + 2, 0); // flags
  put16(p + 4, 0); // stored
  put16(p + 6, 0); // time
  put16(p + 8, DOS_DATE);
  put32(p + 10, member->crc);
  put32(p + 14, member_size(member));
  put32(p + 18, member_size(member));
  put16(p + 22, (uint32_t)member->name_size);
}

static thrum_status write_member(thrum_file_writer *writer, const planned_member *member,
                                 thrum_error *error) {
  unsigned char record[LOCAL_SIZE + NAME_MAX_SIZE + THRUM_ALIGNMENT + EXTRA_HEAD] = {0};

  // the local record repeats what the directory says
  memcpy(record, "PK\3\4", 4);
  put_common(record + 4, member);
  put16(record + 28, (uint32_t)member->extra);
  memcpy(record + LOCAL_SIZE, member->name, member->name_size);

  // the extra field is padding, so that the array can be mapped at an aligned address
  unsigned char *extra = record + LOCAL_SIZE + member->name_size;
  put16(extra, EXTRA_PADDING);
  put16(extra + 2, (uint32_t)(member->extra - EXTRA_HEAD));

  THRUM_TRY(
      thrum_file_writer_put(writer, record, LOCAL_SIZE + member->name_size + member->extra, error));
  THRUM_TRY(thrum_file_writer_put(writer, member->header, member->header_size, error));
  return thrum_file_writer_put(writer, member->data, (size_t)member->data_size, error);
}

static thrum_status write_directory(thrum_file_writer *writer, const file_plan *plan,
                                    thrum_error *error) {
  for (int i = 0; i < plan->count; i++) {
    const planned_member *member = &plan->members[i];
    unsigned char record[CENTRAL_SIZE + NAME_MAX_SIZE] = {0};
    memcpy(record, "PK\1\2", 4);
    put16(record + 4, ZIP_VERSION);
    put_common(record + 6, member);
    put32(record + 42, member->offset);
    memcpy(record + CENTRAL_SIZE, member->name, member->name_size);
    THRUM_TRY(thrum_file_writer_put(writer, record, CENTRAL_SIZE + member->name_size, error));
  }

  // readers begin with the end record, which tells where the directory is
  unsigned char end[END_SIZE] = {0};
  memcpy(end, "PK\5\6", 4);
  put16(end + 8, (uint32_t)plan->count);
  put16(end + 10, (uint32_t)plan->count);
  put32(end + 12, (uint32_t)plan->directory_size);
  put32(end + 16, (uint32_t)plan->directory);
  return thrum_file_writer_put(writer, end, sizeof end, error);
}

static void compute_checksums(file_plan *plan) {
  thrum_crc32_table table;
  thrum_crc32_prepare(&table);
  for (int i = 0; i < plan->count; i++) {
    planned_member *member = &plan->members[i];
    member->crc = thrum_crc32(&table, 0, member->header, member->header_size);
    member->crc = thrum_crc32(&table, member->crc, member->data, (size_t)member->data_size);
  }
}

static thrum_status write_file(const char *path, const file_plan *plan, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  thrum_status status = THRUM_OK;
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  for (int i = 0; i < plan->count && status >= 0; i++)
    status = write_member(&writer, &plan->members[i], error);
  THRUM_THEN(status, write_directory(&writer, plan, error));

  // the target keeps its old contents unless all was written
  return thrum_file_writer_end(&writer, status, error);
}

thrum_status thrum_npz_write(const char *path, const thrum_npz_array *arrays, int count,
                             thrum_error *error) {
  if (count > THRUM_NPZ_ARRAYS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_npz_write: %d arrays", count);
  file_plan plan;
  THRUM_TRY(plan_file(arrays, count, &plan, error));
  compute_checksums(&plan);
  return write_file(path, &plan, error);
}

/* Appends an array of a list of thrum/model.h, unless it is absent. */
static void list_array(thrum_npz_array *arrays, int *count, const thrum_npz_array *array) {
  if (array->data != NULL)
    arrays[(*count)++] = *array;
}

/* The names of the sizes are those by which THRUM_MODEL_ARRAYS says shapes. */
int thrum_npz_of_model(const thrum_model *model, thrum_npz_array arrays[THRUM_NPZ_ARRAYS_MAX]) {
#define X(name, meaning) const int64_t name = model->name;
  THRUM_MODEL_SIZES(X)
#undef X

  const int64_t basis_rows = 3 * vertex_count, point_rows = 9 * point_count;
  (void)region_count, (void)meta_bytes;

  // the list names each array with its shape in terms of the sizes above
  int count = 0;
#define X(type, name, rows, columns, presence, meaning)                                            \
  list_array(arrays, &count,                                                                       \
             &(thrum_npz_array)THRUM_NPZ_ARRAY(type, name, rows, columns, model->name));
  THRUM_MODEL_ARRAYS(X)
#undef X
  return count;
}

thrum_status thrum_model_save(const char *path, const thrum_model *model, thrum_error *error) {
  if (path == NULL || model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_model_save: no path or no model");
  thrum_npz_array arrays[THRUM_NPZ_ARRAYS_MAX];
  file_plan plan;

  // the values come last, as reading all of a model that is too large for a file may take long
  THRUM_TRY(thrum_model_check_shapes(model, error));
  THRUM_TRY(plan_file(arrays, thrum_npz_of_model(model, arrays), &plan, error));
  THRUM_TRY(thrum_model_check(model, error));
  compute_checksums(&plan);
  return write_file(path, &plan, error);
}
