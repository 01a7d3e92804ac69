/* Embedded surfaces from bytes: finding the arrays of a surface file (docs/embedding.md), checking
 * them, and what of them a surface for display takes. See thrum/embedding.h. Nothing here
 * allocates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/readout/embedding_private.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#define PRESENCE_REQUIRED 1
#define PRESENCE_OPTIONAL 0

static const thrum_array_info array_table[THRUM_EMBEDDING_ARRAY_COUNT] = {
#define X(type, name, rows, columns, presence, meaning)                                            \
  {#name,                                                                                          \
   THRUM_DESCR_##type,                                                                             \
   sizeof(thrum_##type),                                                                           \
   THRUM_EMBEDDING_SIZE_##columns == THRUM_EMBEDDING_SIZE_1 ? 1 : 2,                               \
   THRUM_EMBEDDING_SIZE_##rows,                                                                    \
   THRUM_EMBEDDING_SIZE_##columns,                                                                 \
   THRUM_EMBEDDING_SIZE_##columns == THRUM_EMBEDDING_SIZE_1 ? "(" #rows ",)"                       \
                                                            : "(" #rows ", " #columns ")",         \
   PRESENCE_##presence},
    THRUM_EMBEDDING_ARRAYS(X)
#undef X
};

static const char *const size_names[THRUM_EMBEDDING_SIZE_basis_rows + 1] = {
#define X(name, meaning) #name,
    THRUM_EMBEDDING_SIZES(X)
#undef X
        "basis_rows"};

#define AFTER(name) [THRUM_EMBEDDING_SIZE_##name - THRUM_EMBEDDING_SIZE_COUNT]
static const thrum_derived_size derived_sizes[] = {
    AFTER(basis_rows) = {3, THRUM_EMBEDDING_SIZE_vertex_count}, AFTER(1) = {1, -1},
    AFTER(2) = {2, -1}, AFTER(3) = {3, -1}, AFTER(4) = {4, -1}};
#undef AFTER

const thrum_array_list thrum_embedding_list = {array_table,
                                               THRUM_EMBEDDING_ARRAY_COUNT,
                                               THRUM_EMBEDDING_SIZE_COUNT,
                                               THRUM_EMBEDDING_SIZE_basis_rows + 1,
                                               size_names,
                                               derived_sizes};

static thrum_status check_version(const unsigned char *format, thrum_error *error) {
  int32_t version[2];
  memcpy(version, format, sizeof version);

  // a later minor version adds arrays, which this program leaves alone
  if (version[0] != THRUM_EMBEDDING_FORMAT_MAJOR)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "array 'surface_format' says version %" PRId32 ".%" PRId32
                           ", this program reads version %d",
                           version[0], version[1], THRUM_EMBEDDING_FORMAT_MAJOR);
  if (version[1] < 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "array 'surface_format' holds a negative version");
  return THRUM_OK;
}

thrum_status thrum_embedding_read(const void *file, size_t file_size,
                                  thrum_embedding_layout *layout, thrum_error *error) {
  // the members of the archive; without the first array it is a file of something else
  thrum_archive_member found[THRUM_EMBEDDING_ARRAY_COUNT] = {{NULL, 0}};
  thrum_status status = thrum_archive_find(file, file_size, &thrum_embedding_list, found, error);
  if (status == THRUM_OK && found[THRUM_EMBEDDING_ARRAY_surface_format].data == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "array 'surface_format' is missing: is it a file of `thrum embed`?");

  // arrays in the order of the list, so that sizes are known before they are used
  unsigned char bound[THRUM_EMBEDDING_SIZE_COUNT] = {0};
  thrum_embedding_layout read = {{0}, {NULL}};
  for (int a = 0; a < THRUM_EMBEDDING_ARRAY_COUNT && status == THRUM_OK; a++) {
    if (found[a].data != NULL)
      status = thrum_archive_bind(&thrum_embedding_list, a, found[a], read.size, bound,
                                  &read.data[a], error);
    else if (array_table[a].required)
      return thrum_error_set(error, THRUM_MISSING, "array '%s' is missing", array_table[a].name);

    // another version may well lack what this one requires
    if (status == THRUM_OK && a == THRUM_EMBEDDING_ARRAY_surface_format)
      status = check_version(read.data[a], error);
  }

  if (status == THRUM_OK)
    *layout = read;
  return status;
}

void thrum_embedding_fill(const thrum_embedding_layout *layout, thrum_embedding *embedding) {
#define X(name, meaning) embedding->name = layout->size[THRUM_EMBEDDING_SIZE_##name];
  THRUM_EMBEDDING_SIZES(X)
#undef X
#define X(type, name, rows, columns, presence, meaning)                                            \
  embedding->name = (const thrum_##type *)(const void *)layout->data[THRUM_EMBEDDING_ARRAY_##name];
  THRUM_EMBEDDING_ARRAYS(X)
#undef X
}

thrum_status thrum_embedding_view(const void *file, size_t file_size, thrum_embedding *embedding,
                                  thrum_error *error) {
  if (file == NULL || embedding == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "thrum_embedding_view: no file or no embedding");

  // every array must be fit for use in place
  thrum_embedding_layout layout;
  THRUM_TRY(thrum_embedding_read(file, file_size, &layout, error));
  for (int a = 0; a < THRUM_EMBEDDING_ARRAY_COUNT; a++)
    if ((uintptr_t)layout.data[a] % array_table[a].item != 0)
      return thrum_error_set(error, THRUM_MISALIGNED,
                             "array '%s' is not aligned to its entries: align the buffer to 64 "
                             "bytes, or use thrum_embedding_load",
                             array_table[a].name);

  // the entries are checked as after loading
  thrum_embedding viewed;
  thrum_embedding_fill(&layout, &viewed);
  THRUM_TRY(thrum_embedding_check(&viewed, error));
  *embedding = viewed;
  return THRUM_OK;
}

static thrum_status refuse_value(const char *array, int64_t at, double value, thrum_error *error) {
  return thrum_error_set(error, THRUM_BAD_VALUE, "entry %" PRId64 " of array '%s' is %g", at, array,
                         value);
}

static thrum_status check_doubles(const char *array, const double *values, int64_t count,
                                  thrum_error *error) {
  for (int64_t n = 0; n < count; n++)
    if (!isfinite(values[n]))
      return refuse_value(array, n, values[n], error);
  return THRUM_OK;
}

static thrum_status check_indices(const char *array, const int32_t *values, int64_t count,
                                  int64_t below, thrum_error *error) {
  for (int64_t n = 0; n < count; n++)
    if (values[n] < 0 || values[n] >= below)
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "entry %" PRId64 " of array '%s' is %" PRId32
                             ", which is outside 0..%" PRId64,
                             n, array, values[n], below - 1);
  return THRUM_OK;
}

static thrum_status check_sizes(const thrum_embedding *e, thrum_error *error) {
  if (e->rank < 1 || e->rank > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "the surface has rank %" PRId64 "; it may be 1 to %d", e->rank,
                           THRUM_RANK_MAX);
  if (e->vertex_count < 1 || e->vertex_count >= INT32_MAX || e->triangle_count < 1 ||
      e->triangle_count >= INT32_MAX)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "the surface has %" PRId64 " vertices and %" PRId64
                           " triangles; it may have 1 to 2^31 - 2",
                           e->vertex_count, e->triangle_count);
  return THRUM_OK;
}

thrum_status thrum_embedding_check(const thrum_embedding *e, thrum_error *error) {
  if (e == NULL || !e->omega2 || !e->positions || !e->triangles || !e->basis || !e->tet ||
      !e->weights)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "there is no embedding, or it lacks an array");

  // sizes first: the values below are counted by them
  THRUM_TRY(check_sizes(e, error));
  THRUM_TRY(check_doubles("omega2", e->omega2, e->rank, error));
  THRUM_TRY(check_doubles("positions", e->positions, 3 * e->vertex_count, error));
  THRUM_TRY(
      check_indices("triangles", e->triangles, 3 * e->triangle_count, e->vertex_count, error));
  for (int64_t n = 0; n < 3 * e->vertex_count * e->rank; n++)
    if (!isfinite(e->basis[n]))
      return refuse_value("basis", n, (double)e->basis[n], error);
  THRUM_TRY(check_indices("tet", e->tet, e->vertex_count, INT32_MAX, error));
  return check_doubles("weights", e->weights, 4 * e->vertex_count, error);
}

thrum_status thrum_embedding_fits(const thrum_embedding *embedding, const thrum_model *model,
                                  thrum_error *error) {
  if (embedding == NULL || model == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the embedding or the model is NULL");
  if (embedding->rank < model->rank ||
      memcmp(embedding->omega2, model->omega2, (size_t)model->rank * sizeof *model->omega2) != 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the surface is embedded in another model (omega2 differs): embed it "
                           "again with `thrum embed`");
  return THRUM_OK;
}

thrum_surface_def thrum_embedding_surface(const thrum_embedding *embedding) {
  return (thrum_surface_def){.vertex_count = embedding->vertex_count,
                             .triangles = embedding->triangles,
                             .triangle_count = embedding->triangle_count,
                             .positions = embedding->positions,
                             .rows = embedding->basis,
                             .row_rank = embedding->rank};
}
