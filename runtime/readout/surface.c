/* Surfaces: planning, laying out, and u = U q in single precision (thrum/surface.h).
 * Cost of the positions: 12 bytes of U for each vertex and mode, read once, in ascending order.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/readout/surface_private.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/mix_numbers.h"

#define SURFACE_MAGIC UINT64_C(0x7468726d73663031)

/* The header; behind it, each at a multiple of 64: rest (blocks x 48), rows (blocks x rank x 48),
 * triangles. */
struct thrum_surface {
  uint64_t magic;
  int64_t rank;
  int64_t vertex_count;
  int64_t triangle_count;
  uint64_t spectrum; /* of the model whose coordinates move it */
};

/* Tells the coordinates of one model from those of another: each has omega2, whatever it is stepped
 * by, and a model that was cut or scaled has others. */
static uint64_t spectrum_of(const thrum_model *model) {
  return thrum_mix_numbers((uint64_t)model->rank, model->omega2, model->omega2 ? model->rank : 0);
}

static int64_t block_count(int64_t vertices) {
  return (vertices + (THRUM_SURFACE_BLOCK - 1)) / THRUM_SURFACE_BLOCK;
}

static size_t rest_offset(void) {
  return thrum_round_up(sizeof(thrum_surface));
}

static size_t rows_offset(int64_t vertices) {
  return rest_offset() + (size_t)block_count(vertices) * THRUM_SURFACE_LANES * sizeof(float);
}

static size_t triangles_offset(int64_t vertices, int64_t rank) {
  return rows_offset(vertices) +
         (size_t)(block_count(vertices) * rank) * THRUM_SURFACE_LANES * sizeof(float);
}

static const void *at(const thrum_surface *surface, size_t offset) {
  return (const unsigned char *)surface + offset;
}

static int64_t shown(const thrum_model *model, const thrum_surface_def *def) {
  return def->vertices || def->positions ? def->vertex_count : model->vertex_count;
}

static thrum_status refuse_index(thrum_error *error, const char *what, int64_t where, int64_t value,
                                 int64_t count) {
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "entry %lld of the surface's %s is %lld, which is outside 0..%lld",
                         (long long)where, what, (long long)value, (long long)count - 1);
}

static thrum_status check_def(const thrum_model *model, const thrum_surface_def *def,
                              thrum_error *error) {
  if (!model || !def)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or the def is NULL");

  // rows for all coordinates would lose those that follow
  if (model->shape)
    return thrum_error_set(error, THRUM_MISSING,
                           "a condensed model is shown by its shape model: "
                           "thrum_condensed_shape_model");

  // a surface of its own, or vertices of the mesh
  if (def->positions || def->rows) {
    if (!def->positions || !def->rows || def->vertices)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "positions and rows come together, and without vertices");
    if (def->row_rank < model->rank || def->row_rank > THRUM_RANK_MAX)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "the surface's rows have %lld columns, the model has rank %lld",
                             (long long)def->row_rank, (long long)model->rank);
  } else if (!model->basis || !model->vertices)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so it has nothing to show: precompute it from "
                           "a mesh");

  // counts that 32-bit indices can reach
  if ((def->vertices || def->positions) && (def->vertex_count < 1 || def->vertex_count > INT32_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the surface is given %lld vertices; it needs 1 to 2^31 - 1",
                           (long long)def->vertex_count);
  if (def->triangles && (def->triangle_count < 1 || def->triangle_count > INT32_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the surface is given %lld triangles; it needs 1 to 2^31 - 1",
                           (long long)def->triangle_count);

  // every index lies within what it refers to
  const int64_t count = shown(model, def);
  for (int64_t n = 0; def->vertices && n < count; n++)
    if (def->vertices[n] < 0 || def->vertices[n] >= model->vertex_count)
      return refuse_index(error, "vertices", n, def->vertices[n], model->vertex_count);
  for (int64_t n = 0; def->triangles && n < 3 * def->triangle_count; n++)
    if (def->triangles[n] < 0 || def->triangles[n] >= count)
      return refuse_index(error, "triangles", n, def->triangles[n], count);
  return THRUM_OK;
}

thrum_status thrum_surface_size(const thrum_model *model, const thrum_surface_def *def,
                                size_t *size, thrum_error *error) {
  THRUM_TRY(check_def(model, def, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  const int64_t triangles = def->triangles ? def->triangle_count : 0;
  *size = triangles_offset(shown(model, def), model->rank) +
          thrum_round_up((size_t)triangles * 3 * sizeof(int32_t));
  return THRUM_OK;
}

/* Source of the rest positions and the rows: the model, or the def itself. */
typedef struct source {
  const double *positions; /* count x 3 */
  const double *basis;     /* 3 count x columns; NULL: rows */
  const float *rows;
  int64_t count, columns;
} source;

static source find_source(const thrum_model *model, const thrum_surface_def *def) {
  return def->positions
             ? (source){def->positions, NULL, def->rows, def->vertex_count, def->row_rank}
             : (source){model->vertices, model->basis, NULL, model->vertex_count, model->rank};
}

/* Can every number of the rows and of the rest positions be a float? */
static thrum_status check_range(const source *from, thrum_error *error) {
  const int64_t coordinates = 3 * from->count;
  for (int64_t n = 0; n < coordinates * from->columns; n++) {
    const double value = from->basis ? from->basis[n] : (double)from->rows[n];
    if (!(fabs(value) <= FLT_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the basis holds %g, beyond the range of single precision", value);
  }
  for (int64_t n = 0; n < coordinates; n++)
    if (!(fabs(from->positions[n]) <= FLT_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "a rest position is %g, beyond the range of single precision",
                             from->positions[n]);
  return THRUM_OK;
}

/* Vertex `vertex` of the source to place `place` of the surface. */
static void fill_vertex(const source *from, int64_t rank, int64_t vertex, int64_t place,
                        float *rest, float *rows) {
  const int64_t block = place / THRUM_SURFACE_BLOCK;
  for (int64_t axis = 0; axis < 3; axis++) {
    const int64_t lane = axis * THRUM_SURFACE_BLOCK + place % THRUM_SURFACE_BLOCK;
    const int64_t row = (3 * vertex + axis) * from->columns;
    float *to = rows + block * rank * THRUM_SURFACE_LANES + lane;
    rest[block * THRUM_SURFACE_LANES + lane] = (float)from->positions[3 * vertex + axis];
    for (int64_t i = 0; i < rank; i++)
      to[i * THRUM_SURFACE_LANES] = from->basis ? (float)from->basis[row + i] : from->rows[row + i];
  }
}

thrum_status thrum_surface_init(void *memory, size_t memory_size, const thrum_model *model,
                                const thrum_surface_def *def, const thrum_surface **surface,
                                thrum_error *error) {
  // what cannot be made is refused before the memory is touched
  size_t size;
  THRUM_TRY(thrum_surface_size(model, def, &size, error));
  const source from = find_source(model, def);
  THRUM_TRY(check_range(&from, error));
  if (!memory || !surface)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or surface is NULL");
  THRUM_TRY(thrum_alignment_check("surface", memory, memory_size, size, error));

  // a header, the rest positions, the rows of the basis, and the triangles
  memset(memory, 0, size);
  const int64_t count = shown(model, def), triangles = def->triangles ? def->triangle_count : 0;
  const thrum_surface header = {SURFACE_MAGIC, model->rank, count, triangles, spectrum_of(model)};
  memcpy(memory, &header, sizeof header);

  unsigned char *bytes = memory;
  float *rest = (float *)(void *)(bytes + rest_offset());
  float *rows = (float *)(void *)(bytes + rows_offset(count));
  for (int64_t n = 0; n < count; n++)
    fill_vertex(&from, model->rank, def->vertices ? def->vertices[n] : n, n, rest, rows);
  if (triangles > 0)
    memcpy(bytes + triangles_offset(count, model->rank), def->triangles,
           (size_t)triangles * 3 * sizeof(int32_t));

  *surface = memory;
  return THRUM_OK;
}

int64_t thrum_surface_vertex_count(const thrum_surface *surface) {
  return surface ? surface->vertex_count : 0;
}

int64_t thrum_surface_triangle_count(const thrum_surface *surface) {
  return surface ? surface->triangle_count : 0;
}

static thrum_status check(const thrum_surface *surface, thrum_error *error) {
  if (!surface || surface->magic != SURFACE_MAGIC)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the surface was not made by thrum_surface_init");
  return THRUM_OK;
}

thrum_status thrum_surface_fits(const thrum_surface *surface, const thrum_model *model,
                                thrum_error *error) {
  THRUM_TRY(check(surface, error));
  if (!model)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model is NULL");
  if (surface->rank != model->rank || surface->spectrum != spectrum_of(model))
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "the surface was made of another model (of rank %lld; this one has rank "
                           "%lld): make it of this model",
                           (long long)surface->rank, (long long)model->rank);
  return THRUM_OK;
}

static thrum_status check_output(const thrum_surface *surface, const double *q, int64_t first,
                                 int64_t count, const float *out, int64_t stride,
                                 thrum_error *error) {
  const int64_t all = surface->vertex_count;
  if (!q || !out || stride < 3)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "q or out is NULL, or the stride is below 3");

  // written so that no sum can overflow
  if (first < 0 || count < 0 || first > all || count > all - first)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld vertices from %lld do not lie in the surface's 0..%lld",
                           (long long)count, (long long)first, (long long)all - 1);

  // coordinates are read in single precision
  for (int64_t i = 0; i < surface->rank; i++)
    if (!(fabs(q[i]) <= FLT_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "entry %lld of q is %g, not in the range of single precision",
                             (long long)i, q[i]);
  return THRUM_OK;
}

thrum_status thrum_surface_positions(const thrum_surface *surface, thrum_surface_output output,
                                     const double *q, int64_t first, int64_t count, float *out,
                                     int64_t stride, thrum_error *error) {
  thrum_status status = check(surface, error);
  if (status == THRUM_OK)
    status = check_output(surface, q, first, count, out, stride, error);
  if (status != THRUM_OK || count == 0)
    return status;

  // q is rounded once, so that all machines multiply the same numbers
  const int64_t rank = surface->rank, end = first + count;
  const float *rest = at(surface, rest_offset());
  const float *rows = at(surface, rows_offset(surface->vertex_count));
  thrum_surface_kernel *const kernel = thrum_surface_kernel_best();
  float q_single[THRUM_RANK_MAX], position[THRUM_SURFACE_LANES];
  for (int64_t i = 0; i < rank; i++)
    q_single[i] = (float)q[i];
  for (int64_t block = first / THRUM_SURFACE_BLOCK; block < block_count(end); block++) {
    // the rest position is added last: the sum of small numbers comes first
    memset(position, 0, sizeof position);
    kernel(rank, rows + block * rank * THRUM_SURFACE_LANES, q_single, position);
    if (output == THRUM_SURFACE_POSITIONS)
      for (int s = 0; s < THRUM_SURFACE_LANES; s++)
        position[s] += rest[block * THRUM_SURFACE_LANES + s];

    // a range may begin and end within a block
    const int64_t base = block * THRUM_SURFACE_BLOCK;
    const int64_t from = base < first ? first - base : 0;
    const int64_t to = end - base < THRUM_SURFACE_BLOCK ? end - base : THRUM_SURFACE_BLOCK;
    float *vertex = out + (base + from - first) * stride;
    for (int64_t v = from; v < to; v++, vertex += stride) {
      vertex[0] = position[v];
      vertex[1] = position[THRUM_SURFACE_BLOCK + v];
      vertex[2] = position[2 * THRUM_SURFACE_BLOCK + v];
    }
  }
  return THRUM_OK;
}

/* Adds twice the area vector of the triangle (a, b, c) to each of its vertices. */
static void add_triangle(const float *positions, int64_t position_stride, const int32_t triangle[3],
                         float *normals, int64_t normal_stride) {
  const float *a = positions + triangle[0] * position_stride;
  const float *b = positions + triangle[1] * position_stride;
  const float *c = positions + triangle[2] * position_stride;
  const float e[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const float f[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const float area[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2],
                         e[0] * f[1] - e[1] * f[0]};
  for (int s = 0; s < 3; s++)
    for (int axis = 0; axis < 3; axis++)
      normals[triangle[s] * normal_stride + axis] += area[axis];
}

thrum_status thrum_surface_normals(const thrum_surface *surface, const float *positions,
                                   int64_t position_stride, float *normals, int64_t normal_stride,
                                   thrum_error *error) {
  THRUM_TRY(check(surface, error));
  if (surface->triangle_count == 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "the surface was made without triangles, which normals need");
  if (!positions || !normals || position_stride < 3 || normal_stride < 3)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "positions or normals is NULL, or a stride is below 3");

  // each triangle adds its area vector to its corners
  const int32_t *triangle = at(surface, triangles_offset(surface->vertex_count, surface->rank));
  for (int64_t v = 0; v < surface->vertex_count; v++)
    memset(normals + v * normal_stride, 0, 3 * sizeof *normals);
  for (int64_t t = 0; t < surface->triangle_count; t++)
    add_triangle(positions, position_stride, triangle + 3 * t, normals, normal_stride);

  // unit length; a vertex without an area has no normal
  for (int64_t v = 0; v < surface->vertex_count; v++) {
    float *normal = normals + v * normal_stride;
    // lengths in double: areas of small triangles squared are below the range of floats
    const double x = normal[0], y = normal[1], z = normal[2], length = sqrt(x * x + y * y + z * z);
    if (length > 0 && isfinite(length)) {
      normal[0] = (float)(x / length);
      normal[1] = (float)(y / length);
      normal[2] = (float)(z / length);
    } else {
      memset(normal, 0, 3 * sizeof *normal);
    }
  }
  return THRUM_OK;
}
