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

#include "io/npy_file.h"
#include "io/zip_write.h"

/* The indices of a model's arrays, the absent ones too. */
enum {
#define X(type, name, rows, columns, presence, meaning) MODEL_ARRAY_##name,
  THRUM_MODEL_ARRAYS(X)
#undef X
      MODEL_ARRAYS
};
_Static_assert((int)MODEL_ARRAYS <= THRUM_NPZ_ARRAYS_MAX,
               "a plan has room for every array of a model");

/* The members of the file to come, and the headers that begin them. */
typedef struct file_plan {
  thrum_zip_source members[THRUM_NPZ_ARRAYS_MAX];
  unsigned char headers[THRUM_NPZ_ARRAYS_MAX][THRUM_NPY_HEADER_MAX];
  int count;
} file_plan;

/* Lays all members out; refuses files that 32-bit offsets cannot address. */
static thrum_status plan_file(const thrum_npz_array *arrays, int count, file_plan *plan,
                              thrum_error *error) {
  memset(plan, 0, sizeof *plan);
  for (plan->count = 0; plan->count < count; plan->count++) {
    const thrum_npz_array *array = &arrays[plan->count];
    thrum_zip_source *member = &plan->members[plan->count];
    unsigned char *header = plan->headers[plan->count];
    snprintf(member->name, sizeof member->name, "%s.npy", array->name);
    member->head = header;
    member->head_size = thrum_npy_header(header, array->descr, array->rows, array->columns);
    member->data = array->data;
    member->data_size = array->size;
    member->aligned = true;
  }
  return thrum_zip_plan(plan->members, count, "an .npz", error);
}

thrum_status thrum_npz_write(const char *path, const thrum_npz_array *arrays, int count,
                             thrum_error *error) {
  if (count > THRUM_NPZ_ARRAYS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "thrum_npz_write: %d arrays", count);
  file_plan plan;
  THRUM_TRY(plan_file(arrays, count, &plan, error));
  return thrum_zip_write(path, plan.members, plan.count, error);
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
  const int64_t modulus_rows = 2 * region_count, guide_axes = 3 * guide_count;
  (void)meta_bytes;

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
  return thrum_zip_write(path, plan.members, plan.count, error);
}
