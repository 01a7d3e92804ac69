/* Solid elements, see solids.h. Cost: constant.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/solids.h"

#include <string.h>

const thrum_solid_shape thrum_solid_shapes[THRUM_SOLID_KINDS] = {
    {"tetrahedra",
     4,
     6,
     4,
     {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}},
     {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}}},
    {"pyramids",
     5,
     8,
     5,
     {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
     {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}}},
    {"wedges",
     6,
     9,
     5,
     {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
     {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
    {"hexahedra",
     8,
     12,
     6,
     {{0, 1},
      {1, 2},
      {2, 3},
      {3, 0},
      {4, 5},
      {5, 6},
      {6, 7},
      {7, 4},
      {0, 4},
      {1, 5},
      {2, 6},
      {3, 7}},
     {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}},
};

static bool has_corner(const int face[4], int corner) {
  return face[0] == corner || face[1] == corner || face[2] == corner || face[3] == corner;
}

/* Adds the cone from `top` over three corners that go round counterclockwise from outside. */
static void add_cone(int top, int a, int b, int c, int tets[THRUM_SOLID_TETS_MAX][4], int *count) {
  const int tet[4] = {top, a, b, c};
  memcpy(tets[(*count)++], tet, sizeof tet);
}

int thrum_solid_cut(thrum_solid kind, const int64_t *numbers, int tets[THRUM_SOLID_TETS_MAX][4]) {
  const thrum_solid_shape *shape = &thrum_solid_shapes[kind];
  int top = 0, count = 0;

  // a tetrahedron stays as it is, in the order of its file
  if (kind == THRUM_SOLID_TET) {
    add_cone(0, 1, 2, 3, tets, &count);
    return count;
  }
  for (int c = 1; c < shape->corners; c++)
    top = numbers[c] < numbers[top] ? c : top;

  for (int f = 0; f < shape->faces; f++) {
    const int *face = shape->face[f];
    if (has_corner(face, top))
      continue;
    if (face[3] < 0) {
      add_cone(top, face[0], face[1], face[2], tets, &count);
      continue;
    }

    // two triangles, which meet at the smallest corner of the face
    int first = 0;
    for (int c = 1; c < 4; c++)
      first = numbers[face[c]] < numbers[face[first]] ? c : first;
    for (int half = 1; half < 3; half++)
      add_cone(top, face[first], face[(first + half) % 4], face[(first + half + 1) % 4], tets,
               &count);
  }
  return count;
}

int thrum_solid_edge(thrum_solid kind, int from, int to) {
  const thrum_solid_shape *shape = &thrum_solid_shapes[kind];
  for (int e = 0; e < shape->edges; e++)
    if ((shape->edge[e][0] == from && shape->edge[e][1] == to) ||
        (shape->edge[e][0] == to && shape->edge[e][1] == from))
      return e;
  return -1;
}

int thrum_solid_diagonal(thrum_solid kind, int from, int to) {
  const thrum_solid_shape *shape = &thrum_solid_shapes[kind];
  for (int f = 0; f < shape->faces; f++)
    if (shape->face[f][3] >= 0 && has_corner(shape->face[f], from) &&
        has_corner(shape->face[f], to))
      return f;
  return -1;
}

bool thrum_solid_around(thrum_solid kind, int face, int edge) {
  const thrum_solid_shape *shape = &thrum_solid_shapes[kind];
  return face < 0 || (has_corner(shape->face[face], shape->edge[edge][0]) &&
                      has_corner(shape->face[face], shape->edge[edge][1]));
}
