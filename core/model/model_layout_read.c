/* Finding the arrays of a model in the bytes of a model file (docs/model_format.md): they are bound
 * in the order of the one list of thrum/model.h, and everything is checked. Nothing is copied, no
 * alignment is assumed. Cost: two passes over the file, one for CRC-32 and one for values.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/model/model_layout.h"

thrum_status thrum_layout_read(const void *file, size_t file_size, thrum_layout *layout,
                               thrum_error *error) {
  // the members of the archive by their arrays
  thrum_archive_member found[THRUM_ARRAY_COUNT] = {{NULL, 0}};
  thrum_status status = thrum_archive_find(file, file_size, &thrum_model_list, found, error);
  if (status != THRUM_OK)
    return status;

  // arrays in the order of the list, so that sizes are known before they are used
  thrum_layout read = {{0}, {NULL}};
  unsigned char bound[THRUM_SIZE_COUNT] = {0};
  for (int a = 0; a < THRUM_ARRAY_COUNT; a++) {
    // `format` is the first: with it in place the version and the set of arrays are judged, before
    // any shape is
    if (found[a].data != NULL)
      status = thrum_archive_bind(&thrum_model_list, a, found[a], read.size, bound, &read.data[a],
                                  error);
    if (status == THRUM_OK && a == THRUM_ARRAY_format) {
      thrum_layout present = read;
      for (int b = a + 1; b < THRUM_ARRAY_COUNT; b++)
        present.data[b] = found[b].data;
      status = thrum_layout_check_presence(&present, error);
    }
    if (status != THRUM_OK)
      return status;
  }

  // the sizes must agree with each other, and the values be in range
  status = thrum_layout_check_sizes(&read, error);
  if (status == THRUM_OK)
    status = thrum_layout_check_values(&read, error);
  if (status == THRUM_OK)
    *layout = read;
  return status;
}
