/* The parts that the page makes of a scene file that is dropped: of models with their whole meshes
 * what links and coupled bodies need, the surfaces of obstacles, and which body lies in something.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <string.h>

/* The model that bridge_open_model read last, with all of its mesh, as one of the page's; it stays
 * where it is. Bodies of it have no surface. Returns its number, or a status below 0. */
int32_t EXPORT(bridge_keep_model)(void) {
  const thrum_model *model = bridge_opened_model();
  if (model == NULL)
    return thrum_error_set(&bridge_error, THRUM_INVALID_ARGUMENT, "no model file was opened");
  const bridge_model made = {.model = *model};
  const int32_t number = bridge_model_add(&made);
  if (number >= 0)
    bridge_keep_opened();
  return number;
}

/* The group of this name in a model: returns its 0-based vertices, and numbers has their count; or
 * NULL. */
const int32_t *EXPORT(bridge_group)(int32_t model, const char *name) {
  const bridge_model *of = bridge_model_at(model);
  const int32_t *vertices = NULL;
  int64_t count = 0;
  if (of == NULL || thrum_model_group(&of->model, name, &vertices, &count, &bridge_error) < 0)
    return NULL;
  bridge_number[0] = (double)count;
  return vertices;
}

/* Writes the numbers of the inertia of a model's shape, 9 + 9 rank (rank + 1). */
int32_t EXPORT(bridge_inertia)(int32_t model, double *out) {
  const bridge_model *of = bridge_model_at(model);
  thrum_inertia *inertia = NULL;
  if (of == NULL)
    return thrum_error_set(&bridge_error, THRUM_INVALID_ARGUMENT, "there is no such model");
  THRUM_TRY(thrum_inertia_create(&of->model, 0, NULL, &inertia, &bridge_error));
  thrum_inertia_numbers(inertia, out);
  thrum_inertia_destroy(inertia);
  return THRUM_OK;
}

/* Links bodies of whole models. numbers: place 3, other place 3 (NaN: not given), axis 3,
 * stiffness, length (below 0: as it is). Vertices are NULL where there is no list. Returns the
 * link's number, or a status below 0; bridge_link_made has what was made. */
int32_t EXPORT(bridge_weigh_link)(int32_t kind, int32_t body, int32_t other,
                                  const int32_t *vertices, int32_t count,
                                  const int32_t *other_vertices, int32_t other_count) {
  const double *n = bridge_number;
  thrum_scene_link_def def = thrum_default_scene_link_def();
  def.kind = (thrum_link_kind)kind;
  def.body = body;
  def.other = other;
  def.vertices = vertices;
  def.count = count;
  def.other_vertices = other_vertices;
  def.other_count = other_count;
  memcpy(def.place, n, sizeof def.place);
  memcpy(def.other_place, n + 3, sizeof def.other_place);
  memcpy(def.axis, n + 6, sizeof def.axis);
  def.stiffness = n[9];
  def.length = n[10];
  int32_t number;
  const thrum_status status = thrum_scene_add_link(bridge_scene, &def, &number, &bridge_error);
  return status == THRUM_OK ? number : (int32_t)status;
}

/* Fills the numbers with a link as it was made: place 3, other place 3, length, both sides at rest,
 * 12 each, and the addresses of their rows, which are 0 for the world. */
int32_t EXPORT(bridge_link_made)(int32_t number) {
  thrum_scene_link_def made;
  THRUM_TRY(thrum_scene_link_made(bridge_scene, number, &made, &bridge_error));
  double *n = bridge_number;
  memcpy(n, made.place, sizeof made.place);
  memcpy(n + 3, made.other_place, sizeof made.other_place);
  n[6] = made.length;
  memcpy(n + 7, made.sides[0].rest, sizeof made.sides[0].rest);
  memcpy(n + 19, made.sides[1].rest, sizeof made.sides[1].rest);
  for (int side = 0; side < 2; side++)
    n[31 + side] = (double)(uintptr_t)made.sides[side].rows;
  return THRUM_OK;
}

/* Makes the surface of an obstacle that is touched by its faces. numbers: half sides 3, radius,
 * height, spacing; heights: rows x columns of a height field, or NULL. Fills the numbers with the
 * count and the address of its vertices (x 3) and of its triangles (x 3), valid until the scene is
 * begun anew. */
int32_t EXPORT(bridge_make_solid)(int32_t shape, int32_t rows, int32_t columns,
                                  const double *heights) {
  double *n = bridge_number;
  thrum_scene_solid_def def = thrum_default_scene_solid_def();
  def.shape = (thrum_solid_shape)shape;
  memcpy(def.half, n, sizeof def.half);
  def.radius = n[3];
  def.height = n[4];
  def.spacing[0] = def.spacing[1] = n[5];
  def.heights = heights;
  def.rows = rows;
  def.columns = columns;

  // the scene keeps the surface
  int32_t number;
  thrum_scene_solid solid;
  THRUM_TRY(thrum_scene_add_solid(bridge_scene, &def, &number, &bridge_error));
  THRUM_TRY(thrum_scene_solid_get(bridge_scene, number, &solid, &bridge_error));
  n[0] = (double)solid.vertex_count;
  n[1] = (double)(uintptr_t)solid.vertices;
  n[2] = (double)solid.triangle_count;
  n[3] = (double)(uintptr_t)solid.triangles;
  return THRUM_OK;
}

/* numbers: the body that lies deepest in something (-1: none does), the body, the obstacle and the
 * solid that it is in (-1: another), how deep [m], and the diagonal of its box [m]. */
int32_t EXPORT(bridge_find_overlap)(void) {
  thrum_scene_overlap deepest;
  THRUM_TRY(thrum_scene_find_overlap(bridge_scene, &deepest, &bridge_error));
  double *n = bridge_number;
  n[0] = deepest.body;
  n[1] = deepest.other;
  n[2] = deepest.obstacle;
  n[3] = deepest.solid;
  n[4] = deepest.depth;
  n[5] = deepest.diagonal;
  return THRUM_OK;
}
