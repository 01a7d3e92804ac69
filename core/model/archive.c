/* The arrays of a list in an .npz in memory; see archive.h. Cost: one pass over the file, for
 * CRC-32.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/model/archive.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "core/base/npy.h"
#include "core/model/zip.h"

#define SUFFIX ".npy"
#define SUFFIX_SIZE 4u

// [a-z][a-z0-9_]*.npy
static int name_is_good(const char *name, size_t size) {
  if (size <= SUFFIX_SIZE || memcmp(name + size - SUFFIX_SIZE, SUFFIX, SUFFIX_SIZE) != 0)
    return 0;
  if (name[0] < 'a' || name[0] > 'z')
    return 0;
  for (size_t i = 1; i < size - SUFFIX_SIZE; i++) {
    char c = name[i];
    if (!((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'))
      return 0;
  }
  return 1;
}

static int array_of_name(const thrum_array_list *list, const char *name, size_t size) {
  for (int a = 0; a < list->count; a++) {
    const char *known = list->arrays[a].name;
    if (strlen(known) == size - SUFFIX_SIZE && memcmp(known, name, size - SUFFIX_SIZE) == 0)
      return a;
  }
  return -1;
}

// whether an earlier central record carries the same name; those were checked on the way here
static int name_came_before(const thrum_zip *zip, const thrum_zip_member *member) {
  const unsigned char *record = zip->bytes + zip->directory;
  for (size_t i = 0; i + 1 < zip->index; i++) {
    size_t size = (size_t)record[28] | (size_t)record[29] << 8;
    if (size == member->name_size && memcmp(record + 46, member->name, size) == 0)
      return 1;
    record += 46 + size;
  }
  return 0;
}

// walks the whole archive, so that unknown members are checked too
thrum_status thrum_archive_find(const void *file, size_t file_size, const thrum_array_list *list,
                                thrum_archive_member *found, thrum_error *error) {
  thrum_zip zip;
  thrum_zip_member member;
  thrum_status status = thrum_zip_open(file, file_size, &zip, error);

  // one member after the other, in the order of the file
  while (status == THRUM_OK) {
    status = thrum_zip_next(&zip, &member, error);
    if (status != THRUM_OK || member.name == NULL)
      return status;

    // a name must be good and new
    char text[48];
    thrum_zip_name_text(text, member.name, member.name_size);
    if (!name_is_good(member.name, member.name_size))
      return thrum_error_set(error, THRUM_BAD_FORMAT,
                             "member '%s': names are lower-case letters, digits and _, then .npy; "
                             "thrum precompute writes model files",
                             text);
    if (name_came_before(&zip, &member))
      return thrum_error_set(error, THRUM_BAD_FORMAT, "member '%s' is there twice", text);

    // a member of an unknown name is left alone
    int array = array_of_name(list, member.name, member.name_size);
    if (array >= 0)
      found[array] = (thrum_archive_member){member.data, member.size};
  }
  return status;
}

int64_t thrum_archive_extent(const thrum_array_list *list, const int64_t *size, int size_id) {
  if (size_id < list->size_count)
    return size[size_id];
  const thrum_derived_size *derived = &list->derived[size_id - list->size_count];
  return derived->of < 0 ? derived->factor : derived->factor * size[derived->of];
}

size_t thrum_archive_bytes(const thrum_array_list *list, const int64_t *size, int array) {
  const thrum_array_info *info = &list->arrays[array];
  return (size_t)thrum_archive_extent(list, size, info->rows) *
         (size_t)thrum_archive_extent(list, size, info->columns) * info->item;
}

unsigned char *thrum_archive_copy(const thrum_array_list *list, const int64_t *size,
                                  const unsigned char **data, unsigned char *next) {
  for (int a = 0; a < list->count; a++) {
    if (data[a] == NULL)
      continue;
    const size_t bytes = thrum_archive_bytes(list, size, a);
    memcpy(next, data[a], bytes);
    data[a] = next;
    next += thrum_round_up(bytes);
  }
  return next;
}

// compares one dimension with its size, or binds the size when this is the first array to carry it
static int bind_extent(const thrum_array_list *list, int64_t *size, unsigned char *bound,
                       int size_id, int64_t value) {
  if (size_id < list->size_count && !bound[size_id]) {
    bound[size_id] = 1;
    size[size_id] = value;
    return 1;
  }
  return thrum_archive_extent(list, size, size_id) == value;
}

// the shape that is needed, with the value of the size that an earlier array has bound
static thrum_status refuse_shape(const thrum_npy *npy, const thrum_array_info *info,
                                 const char *where, const char *size_name, int64_t size,
                                 thrum_error *error) {
  char shape[96], value[64] = "";
  thrum_npy_shape_text(npy, shape);
  if (size_name[0] != '\0')
    snprintf(value, sizeof value, " with %s = %" PRId64, size_name, size);
  return thrum_error_set(error, THRUM_BAD_SHAPE, "%s has shape %s, %s is needed%s", where, shape,
                         info->expected, value);
}

thrum_status thrum_archive_bind(const thrum_array_list *list, int array,
                                thrum_archive_member member, int64_t *size, unsigned char *bound,
                                const unsigned char **data, thrum_error *error) {
  // the member is an .npy file of the array's type
  const thrum_array_info *info = &list->arrays[array];
  char where[64];
  snprintf(where, sizeof where, "array '%s'", info->name);
  thrum_npy npy;
  THRUM_TRY(thrum_npy_parse(member.data, member.size, where, &npy, error));
  THRUM_TRY(thrum_npy_expect(&npy, info->descr, info->item, where, error));

  // each extent binds the size of its name, or agrees with the one before
  if (npy.dims != info->dims)
    return refuse_shape(&npy, info, where, "", 0, error);
  for (int d = 0; d < info->dims; d++) {
    int size_id = d == 0 ? info->rows : info->columns;
    if (bind_extent(list, size, bound, size_id, npy.shape[d]))
      continue;
    const char *size_name = size_id < list->named_count ? list->size_names[size_id] : "";
    return refuse_shape(&npy, info, where, size_name, thrum_archive_extent(list, size, size_id),
                        error);
  }

  *data = npy.data;
  return THRUM_OK;
}
