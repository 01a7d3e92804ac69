/* The surface of a model's mesh. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/display_surface.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_faces.h"
#include "platform/allocate.h"

void display_surface_free(display_surface *skin) {
  free(skin->vertices);
  free(skin->triangles);
  *skin = (display_surface){0};
}

/* Numbers the vertices that triangles use, and the triangles by these numbers. */
static thrum_status number_vertices(int64_t all, display_surface *skin, thrum_error *error) {
  int32_t *place = NULL;
  THRUM_TRY(thrum_reserve(&skin->vertices, all, sizeof *skin->vertices, "the surface", error));
  THRUM_TRY(thrum_reserve(&place, all, sizeof *place, "the surface", error));

  // mark the vertices that triangles use
  for (int64_t n = 0; n < 3 * skin->triangle_count; n++)
    place[skin->triangles[n]] = 1;

  // the marked ones get consecutive numbers in the order of the mesh
  for (int64_t v = 0; v < all; v++) {
    if (place[v] == 0)
      continue;
    place[v] = (int32_t)skin->vertex_count;
    skin->vertices[skin->vertex_count++] = (int32_t)v;
  }

  // and the triangles take those numbers
  for (int64_t n = 0; n < 3 * skin->triangle_count; n++)
    skin->triangles[n] = place[skin->triangles[n]];
  free(place);
  return THRUM_OK;
}

static void add_triangle(int32_t a, int32_t b, int32_t c, display_surface *skin) {
  int32_t *corners = skin->triangles + 3 * skin->triangle_count++;
  corners[0] = a;
  corners[1] = b;
  corners[2] = c;
}

/* A face of six nodes is shown as four triangles: one at each corner, and that between them. */
static void add_four(const thrum_mesh *mesh, int64_t tet, const int32_t corners[3],
                     display_surface *skin) {
  int32_t middle[3];
  for (int k = 0; k < 3; k++)
    middle[k] = thrum_mesh_middle_node(mesh, tet, corners[k], corners[(k + 1) % 3]);
  for (int k = 0; k < 3; k++)
    add_triangle(corners[k], middle[k], middle[(k + 2) % 3], skin);
  add_triangle(middle[0], middle[1], middle[2], skin);
}

thrum_status display_surface_make(const thrum_model *model, display_surface *skin,
                                  thrum_error *error) {
  if (model->vertices == NULL || model->tets == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no mesh, so it has no surface");
  display_surface made = {0};

  // the finder of faces reads vertices and tets alone, and changes none
  thrum_mesh mesh = {.vertex_count = model->vertex_count, .tet_count = model->tet_count};
  memcpy(&mesh.vertices, &model->vertices, sizeof mesh.vertices);
  memcpy(&mesh.tets, &model->tets, sizeof mesh.tets);
  memcpy(&mesh.midsides, &model->midsides, sizeof mesh.midsides);
  thrum_mesh_faces faces = {0};
  int64_t shared[3];
  THRUM_TRY(thrum_mesh_find_faces(&mesh, &faces, shared, error));

  // a face of one tetrahedron alone is on the surface; its parity gives the order of corners
  const int64_t parts = mesh.midsides != NULL ? 4 : 1;
  thrum_status status = thrum_reserve(&made.triangles, 3 * parts * faces.count,
                                      sizeof *made.triangles, "the surface", error);
  for (int64_t n = 0; n < faces.count && status >= 0; n++) {
    const thrum_mesh_face *face = &faces.faces[n];
    if (face->other >= 0)
      continue;
    const int32_t corners[3] = {face->vertices[0], face->vertices[face->even ? 1 : 2],
                                face->vertices[face->even ? 2 : 1]};
    if (mesh.midsides != NULL)
      add_four(&mesh, face->tet, corners, &made);
    else
      add_triangle(corners[0], corners[1], corners[2], &made);
  }

  // triangles then refer to the vertices of the surface, not to those of the mesh
  free(faces.faces);
  THRUM_THEN(status, number_vertices(model->vertex_count, &made, error));
  if (status < 0)
    display_surface_free(&made);
  else
    *skin = made;
  return status;
}

void display_surface_corners(const display_surface *skin, int32_t *corners) {
  for (int64_t n = 0; n < 3 * skin->triangle_count; n++)
    corners[n] = skin->vertices[skin->triangles[n]];
}
