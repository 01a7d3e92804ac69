/* The skin of a mesh or an embedded surface as one kind of arrays.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/export/render_mesh.h"

#include <string.h>

#include "core/base/quadratic_tet.h"
#include "driver/export/embedded_surface.h"
#include "driver/model/display_surface.h"
#include "mesh/formats/surface_read.h"

void render_mesh_free(render_mesh *shown) {
  thrum_scope_free(&shown->memory);
  *shown = (render_mesh){0};
}

/* Room for what is to be shown; an empty one when there is none. */
static thrum_status allocate(int64_t vertices, int64_t triangles, int64_t rank, render_mesh *shown,
                             thrum_error *error) {
  render_mesh made = {.rank = rank,
                      .vertex_count = vertices,
                      .triangle_count = triangles,
                      .memory = thrum_scope_begin("the surface", error)};
  made.positions = thrum_scope_allocate(&made.memory, 3 * vertices, sizeof *made.positions);
  made.basis = thrum_scope_allocate(&made.memory, 3 * vertices, (size_t)rank * sizeof *made.basis);
  made.fixed = thrum_scope_allocate(&made.memory, vertices, sizeof *made.fixed);
  made.triangles = thrum_scope_allocate(&made.memory, 3 * triangles, sizeof *made.triangles);
  const thrum_status status = made.memory.status;
  if (status < 0)
    render_mesh_free(&made);
  else
    *shown = made;
  return status;
}

static thrum_status make_skin(const thrum_model *model, render_mesh *shown, thrum_error *error) {
  display_surface skin = {0};
  const int64_t rank = model->rank;
  thrum_status status = display_surface_make(model, &skin, error);
  THRUM_THEN(status, allocate(skin.vertex_count, skin.triangle_count, rank, shown, error));

  // rows of the basis are copied in single precision, which drawing needs
  for (int64_t v = 0; v < skin.vertex_count && status >= 0; v++) {
    const int64_t from = skin.vertices[v];
    memcpy(shown->positions + 3 * v, model->vertices + 3 * from, 3 * sizeof *shown->positions);
    for (int64_t n = 0; n < 3 * rank; n++)
      shown->basis[3 * v * rank + n] = (float)model->basis[3 * from * rank + n];
    shown->fixed[v] = model->fixed != NULL ? model->fixed[from] : 0;
  }

  if (status >= 0)
    memcpy(shown->triangles, skin.triangles,
           3 * (size_t)skin.triangle_count * sizeof *skin.triangles);

  display_surface_free(&skin);
  return status;
}

/* A vertex is held where all nodes that it follows are. */
static uint8_t held(const thrum_model *model, int32_t tet, const double *weights) {
  uint8_t bits = 7;
  for (int c = 0; c < 4; c++)
    if (weights[c] != 0)
      bits &= model->fixed[model->tets[4 * (int64_t)tet + c]];
  for (int e = 0; e < THRUM_QUADRATIC_EDGES && model->midsides != NULL; e++)
    if (weights[thrum_quadratic_edges[e][0]] != 0 && weights[thrum_quadratic_edges[e][1]] != 0)
      bits &= model->fixed[model->midsides[6 * (int64_t)tet + e]];
  return bits;
}

/* `path` is for messages. */
static thrum_status take_embedding(const thrum_model *model, const thrum_embedding *e,
                                   const char *path, render_mesh *shown, thrum_error *error) {
  thrum_error reason = {0};
  thrum_status status = thrum_embedding_fits(e, model, &reason);

  // an embedding in another mesh may have the same rank, so its tetrahedra are checked too
  for (int64_t v = 0; v < e->vertex_count && status >= 0; v++)
    if (e->rank != model->rank || e->tet[v] >= model->tet_count)
      status = thrum_error_set(&reason, THRUM_BAD_VALUE,
                               "the surface is embedded in another model: embed it again");

  if (status < 0)
    return thrum_error_set(error, status, "%.150s: %s", path, reason.message);

  // rest positions, basis and triangles are in the file; held vertices come from the mesh
  THRUM_TRY(allocate(e->vertex_count, e->triangle_count, e->rank, shown, error));
  const size_t count = 3 * (size_t)e->vertex_count;
  memcpy(shown->positions, e->positions, count * sizeof *e->positions);
  memcpy(shown->basis, e->basis, count * (size_t)e->rank * sizeof *e->basis);
  memcpy(shown->triangles, e->triangles, 3 * (size_t)e->triangle_count * sizeof *e->triangles);
  for (int64_t v = 0; v < e->vertex_count && model->fixed != NULL; v++)
    shown->fixed[v] = held(model, e->tet[v], e->weights + 4 * v);
  return THRUM_OK;
}

thrum_status render_mesh_make(const thrum_model *model, const char *surface, render_mesh *shown,
                              thrum_error *error) {
  if (model->vertices == NULL || model->tets == NULL || model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no mesh or no basis, so it has no surface");
  if (surface == NULL)
    return make_skin(model, shown, error);

  // a plain surface is embedded on the way
  thrum_status status;
  if (thrum_surface_mesh_is_named(surface)) {
    thrum_embed embed = {0};
    status = embedded_surface_make(model, "", surface, 1, true, &embed, error);
    if (status >= 0)
      embedded_surface_warn(&embed.report, surface);
    THRUM_THEN(status, take_embedding(model, &embed.embedding, surface, shown, error));
    thrum_embed_free(&embed);
    return status;
  }

  const thrum_embedding *loaded = NULL;
  status = thrum_embedding_load(surface, &loaded, error);
  THRUM_THEN(status, take_embedding(model, loaded, surface, shown, error));
  thrum_embedding_destroy(loaded);
  return status;
}
