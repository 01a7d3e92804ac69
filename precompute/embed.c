/* Binding a surface to a mesh, and W_v = sum_c N_c(w_v) U_c in double precision, rounded once to
 * single; see precompute/embed.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/embed.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "io/npz.h"
#include "mesh/tet_tree.h"
#include "platform/allocate.h"
#include "precompute/curved_place.h"

/* Nearer than this part of the mesh's extent is on its surface, but for rounding. */
#define ON_SURFACE 1e-9

static const int32_t format[2] = {THRUM_EMBEDDING_FORMAT_MAJOR, THRUM_EMBEDDING_FORMAT_MINOR};

/* The arrays of the embedding that is being made, before they are const. */
typedef struct embed_arrays {
  uint8_t *meta;
  double *omega2, *positions, *weights;
  int32_t *triangles, *tet;
  float *basis;
} embed_arrays;

void thrum_embed_free(thrum_embed *embed) {
  thrum_scope_free(&embed->memory);
  *embed = (thrum_embed){.report = {.farthest = -1}};
}

static void *copy(thrum_scope *memory, const void *data, int64_t count, size_t size) {
  void *made = thrum_scope_allocate(memory, count, size);
  if (made != NULL && count > 0)
    memcpy(made, data, (size_t)count * size);
  return made;
}

static embed_arrays allocate(const thrum_model *model, const thrum_surface_mesh *surface,
                             const char *meta, thrum_scope *memory) {
  const int64_t count = surface->vertex_count, rank = model->rank;
  return (embed_arrays){
      .meta = meta ? copy(memory, meta, (int64_t)strlen(meta), 1) : NULL,
      .omega2 = copy(memory, model->omega2, rank, sizeof(double)),
      .positions = copy(memory, surface->vertices, 3 * count, sizeof(double)),
      .triangles = copy(memory, surface->triangles, 3 * surface->triangle_count, sizeof(int32_t)),
      .weights = thrum_scope_allocate(memory, 4 * count, sizeof(double)),
      .tet = thrum_scope_allocate(memory, count, sizeof(int32_t)),
      .basis = thrum_scope_allocate(memory, 3 * count, (size_t)rank * sizeof(float))};
}

static thrum_status bind_vertex(const thrum_tet_tree *tree, const thrum_curved_places *curved,
                                int64_t v, embed_arrays *a, thrum_embed_report *report,
                                thrum_error *error) {
  // the nearest tetrahedron and the weights of its corners, or the place in a curved element
  thrum_tet_place place = thrum_tet_tree_find(tree, a->positions + 3 * v);
  if (curved)
    thrum_curved_place(curved, a->positions + 3 * v, &place);
  bool finite = isfinite(place.distance);
  for (int c = 0; c < 4; c++) {
    finite = finite && isfinite(place.weights[c]);
    report->weight_max = fmax(report->weight_max, fabs(place.weights[c]));
  }

  // far outside, the weights overflow
  if (!finite)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "vertex %lld of the surface is too far from the mesh to be embedded",
                           (long long)v + 1);

  memcpy(a->weights + 4 * v, place.weights, sizeof place.weights);
  a->tet[v] = place.tet;

  // the farthest vertex outside is reported
  report->outside += place.distance > ON_SURFACE * report->extent;
  if (place.distance > ON_SURFACE * report->extent && place.distance > report->distance_max) {
    report->distance_max = place.distance;
    report->farthest = v;
  }
  return THRUM_OK;
}

static thrum_status bind_all(const thrum_model *model, int64_t count,
                             const thrum_embed_progress *progress, embed_arrays *a,
                             thrum_embed_report *report, thrum_error *error) {
  thrum_tet_tree *tree = NULL;
  thrum_curved_places *curved = NULL;
  thrum_status status =
      thrum_tet_tree_make(model->vertices, model->tets, model->tet_count, &tree, error);
  THRUM_THEN(status, thrum_curved_places_make(model, &curved, error));
  for (int64_t v = 0; v < count && status >= 0; v++) {
    status = bind_vertex(tree, curved, v, a, report, error);
    if (progress != NULL && v % 1024 == 0)
      progress->tell(progress->context, (double)v / (double)count);
  }
  thrum_tet_tree_free(tree);
  thrum_curved_places_free(curved);
  return status;
}

/* The nodes of a tetrahedron and their weights at barycentric coordinates; returns how many. */
static int node_weights(const thrum_model *model, int64_t tet, const double place[4],
                        int32_t nodes[10], double weights[10]) {
  memcpy(nodes, model->tets + 4 * tet, 4 * sizeof *nodes);
  memcpy(weights, place, 4 * sizeof *weights);
  if (!model->midsides)
    return 4;
  memcpy(nodes + 4, model->midsides + 6 * tet, 6 * sizeof *nodes);
  thrum_quadratic_shape(place, weights);
  return THRUM_QUADRATIC_NODES;
}

/* W of one vertex. */
static thrum_status make_rows(const thrum_model *model, int64_t v, embed_arrays *a,
                              thrum_error *error) {
  const int64_t rank = model->rank;
  int32_t nodes[THRUM_QUADRATIC_NODES];
  double w[THRUM_QUADRATIC_NODES];
  const int count = node_weights(model, a->tet[v], a->weights + 4 * v, nodes, w);

  // the weighted sum of the nodes' rows of the basis
  for (int64_t axis = 0; axis < 3; axis++)
    for (int64_t i = 0; i < rank; i++) {
      // from -0, so that a row taken whole keeps all its bits
      double sum = -0.0;
      for (int c = 0; c < count; c++)
        sum += w[c] == 0 ? -0.0 : w[c] * model->basis[(3 * (int64_t)nodes[c] + axis) * rank + i];
      if (!(fabs(sum) <= (double)FLT_MAX))
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "vertex %lld of the surface moves by %g in mode %lld, beyond the "
                               "range of single precision",
                               (long long)v + 1, sum, (long long)i + 1);
      a->basis[(3 * v + axis) * rank + i] = (float)sum;
    }
  return THRUM_OK;
}

static thrum_embedding as_embedding(const thrum_model *model, const thrum_surface_mesh *surface,
                                    const char *meta, const embed_arrays *a) {
  return (thrum_embedding){.rank = model->rank,
                           .vertex_count = surface->vertex_count,
                           .triangle_count = surface->triangle_count,
                           .meta_bytes = meta ? (int64_t)strlen(meta) : 0,
                           .surface_format = format,
                           .meta = a->meta,
                           .omega2 = a->omega2,
                           .positions = a->positions,
                           .triangles = a->triangles,
                           .basis = a->basis,
                           .tet = a->tet,
                           .weights = a->weights};
}

thrum_status thrum_embed_make(const thrum_model *model, const thrum_surface_mesh *surface,
                              const char *meta, const thrum_embed_progress *progress,
                              thrum_embed *embed, thrum_error *error) {
  if (!model->tets || !model->vertices || !model->basis)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or no basis, so nothing can be embedded in it: "
                           "precompute it from a mesh");

  // every vertex is bound to a tetrahedron, and gets its rows
  thrum_scope memory = thrum_scope_begin("the surface", error);
  embed_arrays a = allocate(model, surface, meta, &memory);
  thrum_embed_report report = {.extent = thrum_box3_longest(model->vertices, model->vertex_count),
                               .farthest = -1};
  thrum_status status = memory.status;
  THRUM_THEN(status, bind_all(model, surface->vertex_count, progress, &a, &report, error));
  for (int64_t v = 0; v < surface->vertex_count && status >= 0; v++)
    status = make_rows(model, v, &a, error);

  // the arrays are the embedding's, or freed
  if (status < 0)
    thrum_scope_free(&memory);
  else
    *embed = (thrum_embed){as_embedding(model, surface, meta, &a), report, memory};
  return status;
}

thrum_status thrum_embed_save(const char *path, const thrum_embedding *embedding,
                              thrum_error *error) {
  THRUM_TRY(thrum_embedding_check(embedding, error));

  // the list of thrum/embedding.h, whose sizes are names here; it begins with this writer's version
#define X(name, meaning) const int64_t name = embedding->name;
  THRUM_EMBEDDING_SIZES(X)
#undef X
  const int64_t basis_rows = 3 * vertex_count;
  thrum_npz_array arrays[] = {
#define X(type, name, rows, columns, presence, meaning)                                            \
  THRUM_NPZ_ARRAY(type, name, rows, columns, embedding->name),
      THRUM_EMBEDDING_ARRAYS(X)
#undef X
  };
  arrays[0].data = format;

  // arrays that are absent leave no gap
  int count = 0;
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++)
    if (arrays[n].data != NULL)
      arrays[count++] = arrays[n];
  return thrum_npz_write(path, arrays, count, error);
}
