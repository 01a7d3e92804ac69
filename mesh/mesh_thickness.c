/* Cells over the thickness, see mesh_thickness.h: a walk from tet to tet along a line.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_thickness.h"

#include <math.h>
#include <stdlib.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"

#define CROSSED_MAX (3 * THRUM_THICKNESS_CELLS_MAX)
#define SHARE 0.25 /* of the surface */

/* The neighbours of each tet, 4 t + c is that beyond the face without corner c; -1: the surface. */
static void set_neighbour(const thrum_mesh *mesh, int32_t *neighbours, const thrum_mesh_face *face,
                          int32_t tet, int32_t other) {
  for (int c = 0; c < 4; c++) {
    const int32_t v = mesh->tets[4 * (int64_t)tet + c];
    if (v != face->vertices[0] && v != face->vertices[1] && v != face->vertices[2])
      neighbours[4 * (int64_t)tet + c] = other;
  }
}

/* The normal of the face of tet t without corner c, outwards, twice its area long. */
static void outward(const thrum_mesh *mesh, int64_t t, int c, double normal[3]) {
  const double *corner[4];
  double one[3], two[3], to[3];
  for (int a = 0; a < 4; a++)
    corner[a] = mesh->vertices + 3 * (int64_t)mesh->tets[4 * t + (c + a) % 4];
  thrum_subtract3(corner[2], corner[1], one);
  thrum_subtract3(corner[3], corner[1], two);
  thrum_cross3(one, two, normal);
  thrum_subtract3(corner[0], corner[1], to);
  const double sign = thrum_dot3(normal, to) > 0 ? -1 : 1;
  for (int axis = 0; axis < 3; axis++)
    normal[axis] *= sign;
}

/* Through which face a line leaves tet t; -1: through none, by rounding. */
static int leave(const thrum_mesh *mesh, int64_t t, int entered, const double from[3],
                 const double along[3]) {
  double nearest = INFINITY;
  int through = -1;
  for (int c = 0; c < 4; c++) {
    if (c == entered)
      continue;
    double normal[3], to[3];
    outward(mesh, t, c, normal);
    const double rate = thrum_dot3(normal, along);
    thrum_subtract3(mesh->vertices + 3 * (int64_t)mesh->tets[4 * t + (c + 1) % 4], from, to);
    const double at = rate > 0 ? thrum_dot3(normal, to) / rate : INFINITY;
    if (at < nearest) {
      nearest = at;
      through = c;
    }
  }
  return through;
}

/* How many tets the line from the middle of a face of the surface crosses; *area: of the face. */
static int count_crossed(const thrum_mesh *mesh, const int32_t *neighbours,
                         const thrum_mesh_face *face, double *area) {
  int64_t t = face->tet;
  int entered = 0, crossed = 1;
  double from[3] = {0}, along[3];
  for (int c = 0; c < 4; c++)
    if (neighbours[4 * t + c] < 0) {
      const int32_t v = mesh->tets[4 * t + c];
      if (v != face->vertices[0] && v != face->vertices[1] && v != face->vertices[2])
        entered = c;
    }

  // straight in from the middle
  outward(mesh, t, entered, along);
  *area = sqrt(thrum_dot3(along, along)) / 2;
  for (int axis = 0; axis < 3; axis++) {
    along[axis] = -along[axis];
    for (int a = 0; a < 3; a++)
      from[axis] += mesh->vertices[3 * (int64_t)face->vertices[a] + axis] / 3;
  }

  for (; crossed < CROSSED_MAX; crossed++) {
    const int through = leave(mesh, t, entered, from, along);
    const int64_t next = through >= 0 ? neighbours[4 * t + through] : -1;
    if (next < 0)
      break;
    for (int c = 0; c < 4; c++)
      if (neighbours[4 * next + c] == t)
        entered = c;
    t = next;
  }
  return crossed;
}

thrum_status thrum_mesh_cells_across(const thrum_mesh *mesh, const thrum_mesh_faces *faces,
                                     double *cells, thrum_error *error) {
  int32_t *neighbours = NULL;
  THRUM_TRY(thrum_reserve(&neighbours, mesh->tet_count, 4 * sizeof *neighbours, "the mesh", error));
  for (int64_t i = 0; i < faces->count; i++) {
    const thrum_mesh_face *face = &faces->faces[i];
    set_neighbour(mesh, neighbours, face, face->tet, face->other);
    if (face->other >= 0)
      set_neighbour(mesh, neighbours, face, face->other, face->tet);
  }

  // the area by the number of tets under it
  double areas[CROSSED_MAX + 1] = {0}, whole = 0;
  for (int64_t i = 0; i < faces->count; i++) {
    if (faces->faces[i].other >= 0)
      continue;

    // the call comes first, since it is not said which side of an assignment does
    double area;
    const int under = count_crossed(mesh, neighbours, &faces->faces[i], &area);
    areas[under] += area;
    whole += area;
  }
  free(neighbours);

  int crossed = 0;
  for (double sum = 0; crossed < CROSSED_MAX && sum < SHARE * whole;)
    sum += areas[++crossed];
  *cells = crossed / 3.0;
  return THRUM_OK;
}

double thrum_bending_error(double cells) {
  return sqrt(1 + 4 / (cells * cells)) - 1;
}
