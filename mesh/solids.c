/* Solid elements, see solids.h. Cost: constant.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/solids.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "core/base/vec3.h"

const thrum_solid_topology thrum_solid_shapes[THRUM_SOLID_KINDS] = {
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

const thrum_solid_form_shape thrum_solid_forms[THRUM_FORMS] = {
    {"tetrahedra of four nodes", THRUM_SOLID_TET, 4},
    {"tetrahedra of ten nodes", THRUM_SOLID_TET, 10},
    {"wedges of six nodes", THRUM_SOLID_WEDGE, 6},
    {"wedges of 15 nodes", THRUM_SOLID_WEDGE, 15},
    {"hexahedra of eight nodes", THRUM_SOLID_HEXAHEDRON, 8},
    {"hexahedra of 20 nodes", THRUM_SOLID_HEXAHEDRON, 20},
    {"solid-shell wedges", THRUM_SOLID_WEDGE, 6},
    {"solid-shell hexahedra", THRUM_SOLID_HEXAHEDRON, 8},
    {"tetrahedra of ten nodes with mean dilatation", THRUM_SOLID_TET, 10},
};

thrum_solid_form thrum_solid_form_of(thrum_solid kind, bool quadratic) {
  if (kind == THRUM_SOLID_HEXAHEDRON)
    return quadratic ? THRUM_FORM_HEX20 : THRUM_FORM_HEX8;
  if (kind == THRUM_SOLID_WEDGE)
    return quadratic ? THRUM_FORM_WEDGE15 : THRUM_FORM_WEDGE6;
  return quadratic ? THRUM_FORM_TET10 : THRUM_FORM_TET4;
}

thrum_solid_words thrum_solid_count_words(const uint8_t *forms, int64_t count) {
  thrum_solid_words words = {""};
  long long counts[THRUM_FORMS] = {0};
  size_t length = 0;
  for (int64_t s = 0; s < count; s++)
    counts[forms[s]]++;
  for (int form = 0; form < THRUM_FORMS; form++)
    if (counts[form] > 0)
      length +=
          (size_t)snprintf(words.text + length, sizeof words.text - length, "%s%lld %s",
                           length > 0 ? ", " : "", counts[form], thrum_solid_forms[form].name);
  return words;
}

/* The corners that edges lead to from each corner, in an order that spans a positive volume. */
static const int neighbours[THRUM_SOLID_KINDS][8][3] = {
    [THRUM_SOLID_TET] = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}},
    [THRUM_SOLID_WEDGE] = {{1, 2, 3}, {2, 0, 4}, {0, 1, 5}, {5, 4, 0}, {3, 5, 1}, {4, 3, 2}},
    [THRUM_SOLID_HEXAHEDRON] = {
        {1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}}};

double thrum_solid_shape_measure(thrum_solid kind, const double *vertices, const int32_t *nodes) {
  static const double regular[THRUM_SOLID_KINDS] = {[THRUM_SOLID_TET] = 0.70710678118654752,
                                                    [THRUM_SOLID_WEDGE] = 0.86602540378443865,
                                                    [THRUM_SOLID_HEXAHEDRON] = 1};
  double least = INFINITY;
  for (int c = 0; c < thrum_solid_shapes[kind].corners; c++) {
    double edges[3][3], lengths = 1;
    for (int e = 0; e < 3; e++) {
      thrum_subtract3(vertices + 3 * (int64_t)nodes[neighbours[kind][c][e]],
                      vertices + 3 * (int64_t)nodes[c], edges[e]);
      lengths *= sqrt(thrum_dot3(edges[e], edges[e]));
    }
    least = fmin(least, thrum_triple3(edges[0], edges[1], edges[2]) / (lengths * regular[kind]));
  }
  return least;
}

static bool has_corner(const int face[4], int corner) {
  return face[0] == corner || face[1] == corner || face[2] == corner || face[3] == corner;
}

/* Adds the cone from `top` over three corners that go round counterclockwise from outside. */
static void add_cone(int top, int a, int b, int c, int tets[][4], int *count) {
  const int tet[4] = {top, a, b, c};
  memcpy(tets[(*count)++], tet, sizeof tet);
}

int thrum_solid_cut(thrum_solid kind, const int64_t *numbers, int tets[THRUM_SOLID_TETS_MAX][4]) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
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

/* Adds cones from `top` over a face without it, cut by the diagonal from its smallest node. */
static void add_face(int top, const int *face, int sides, const int64_t *numbers, int tets[][4],
                     int *count) {
  int first = 0;
  for (int c = 0; c < sides; c++) {
    if (face[c] == top)
      return;
    first = numbers[face[c]] < numbers[face[first]] ? c : first;
  }
  for (int half = 1; half < sides - 1; half++)
    add_cone(top, face[first], face[(first + half) % sides], face[(first + half + 1) % sides], tets,
             count);
}

/* The middle nodes of the edges before and behind a corner of a face, and the one of the third edge
 * there, which is not of the face. */
static void corner_middles(const thrum_solid_topology *shape, thrum_solid kind, int corner,
                           int middles[3]) {
  int f = 0, at = 0;
  while (!has_corner(shape->face[f], corner))
    f++;
  const int *face = shape->face[f], sides = face[3] < 0 ? 3 : 4;
  while (face[at] != corner)
    at++;
  const int before = face[(at + sides - 1) % sides], behind = face[(at + 1) % sides];
  middles[0] = shape->corners + thrum_solid_edge(kind, before, corner);
  middles[1] = shape->corners + thrum_solid_edge(kind, corner, behind);
  for (int e = 0; e < shape->edges; e++) {
    const int *ends = shape->edge[e];
    const int other = ends[0] == corner ? ends[1] : ends[1] == corner ? ends[0] : -1;
    if (other >= 0 && other != before && other != behind)
      middles[2] = shape->corners + e;
  }
}

int thrum_solid_cut_middles(thrum_solid kind, const int64_t *numbers,
                            int tets[THRUM_SOLID_MIDDLE_TETS_MAX][4]) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  int top = shape->corners, count = 0;
  for (int n = shape->corners; n < shape->corners + shape->edges; n++)
    top = numbers[n] < numbers[top] ? n : top;

  // a tet at each corner, whose inner face is one of what is left
  for (int c = 0; c < shape->corners; c++) {
    int m[3] = {0, 0, 0};
    corner_middles(shape, kind, c, m);
    add_cone(c, m[0], m[1], m[2], tets, &count);
    const int inner[3] = {m[0], m[2], m[1]};
    add_face(top, inner, 3, numbers, tets, &count);
  }

  // and what is left has a face within each face
  for (int f = 0; f < shape->faces; f++) {
    const int *face = shape->face[f], sides = face[3] < 0 ? 3 : 4;
    int middles[4];
    for (int c = 0; c < sides; c++)
      middles[c] = shape->corners + thrum_solid_edge(kind, face[c], face[(c + 1) % sides]);
    add_face(top, middles, sides, numbers, tets, &count);
  }
  return count;
}

/* Corners of an element that is reflected. */
static int mirrored_corner(thrum_solid kind, int corner) {
  static const int places[THRUM_SOLID_KINDS][8] = {
      [THRUM_SOLID_TET] = {0, 2, 1, 3},
      [THRUM_SOLID_PYRAMID] = {0, 3, 2, 1, 4},
      [THRUM_SOLID_WEDGE] = {3, 4, 5, 0, 1, 2},
      [THRUM_SOLID_HEXAHEDRON] = {4, 5, 6, 7, 0, 1, 2, 3}};
  return places[kind][corner];
}

int thrum_solid_mirrored(thrum_solid kind, int n) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  if (n < shape->corners)
    return mirrored_corner(kind, n);
  const int *edge = shape->edge[n - shape->corners];
  return shape->corners +
         thrum_solid_edge(kind, mirrored_corner(kind, edge[0]), mirrored_corner(kind, edge[1]));
}

int thrum_solid_edge(thrum_solid kind, int from, int to) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  for (int e = 0; e < shape->edges; e++)
    if ((shape->edge[e][0] == from && shape->edge[e][1] == to) ||
        (shape->edge[e][0] == to && shape->edge[e][1] == from))
      return e;
  return -1;
}

int thrum_solid_diagonal(thrum_solid kind, int from, int to) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  for (int f = 0; f < shape->faces; f++)
    if (shape->face[f][3] >= 0 && has_corner(shape->face[f], from) &&
        has_corner(shape->face[f], to))
      return f;
  return -1;
}

bool thrum_solid_around(thrum_solid kind, int face, int edge) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  return face < 0 || (has_corner(shape->face[face], shape->edge[edge][0]) &&
                      has_corner(shape->face[face], shape->edge[edge][1]));
}
