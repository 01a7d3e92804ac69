/* Faces of elements, see solid_face.h. Quadrilaterals have nine Gauss points, triangles seven of
 * degree 5 (Radon 1948, doi:10.1007/BF01525334). Both are exact where a face is flat and its edges
 * are straight with middle nodes in the middle. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/solid_face.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/solid_shape.h"

typedef struct face_point {
  double share[4], slope[4][2]; /* of the corners of the face, and by its two directions */
  double weight;
} face_point;

/* Point p of seven: the centre and two orbits of three. */
static void triangle_point(int p, face_point *at) {
  static const double near[2] = {0.47014206410511508977, 0.10128650732345633880};
  static const double weight[2] = {0.13239415278850618074, 0.12593918054482715260};
  static const double slope[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
  const double share = p == 6 ? 1.0 / 3 : near[p / 3];
  for (int k = 0; k < 3; k++)
    at->share[k] = p < 6 && k == p % 3 ? 1 - 2 * share : share;
  memcpy(at->slope, slope, sizeof slope);
  at->weight = (p == 6 ? 0.225 : weight[p / 3]) / 2;
}

/* Point p of nine. */
static void quadrilateral_point(int p, face_point *at) {
  static const double place[3] = {-0.77459666924148338, 0, 0.77459666924148338};
  static const double weight[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
  static const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int k = 0; k < 4; k++) {
    const double x = 1 + corner[k][0] * place[p % 3], y = 1 + corner[k][1] * place[p / 3];
    at->share[k] = x * y / 4;
    at->slope[k][0] = corner[k][0] * y / 4;
    at->slope[k][1] = corner[k][1] * x / 4;
  }
  at->weight = weight[p % 3] * weight[p / 3];
}

static int sides_of(const int face[4]) {
  return face[3] < 0 ? 3 : 4;
}

int thrum_solid_face_nodes(thrum_solid_form form, int face, int nodes[THRUM_SOLID_FACE_NODES_MAX]) {
  const thrum_solid kind = thrum_solid_forms[form].kind;
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  const int *corner = shape->face[face], sides = sides_of(corner);
  memcpy(nodes, corner, sizeof *nodes * (size_t)sides);
  if (thrum_solid_forms[form].nodes == shape->corners)
    return sides;
  for (int k = 0; k < sides; k++)
    nodes[sides + k] = shape->corners + thrum_solid_edge(kind, corner[k], corner[(k + 1) % sides]);
  return 2 * sides;
}

double thrum_solid_face_shares(thrum_solid_form form, int face, double (*places)[3],
                               double shares[THRUM_SOLID_FACE_NODES_MAX]) {
  const thrum_solid kind = thrum_solid_forms[form].kind;
  const int *corner = thrum_solid_shapes[kind].face[face], sides = sides_of(corner);
  int nodes[THRUM_SOLID_FACE_NODES_MAX];
  const int count = thrum_solid_face_nodes(form, face, nodes);
  double whole = 0;
  memset(shares, 0, sizeof *shares * (size_t)count);
  for (int p = 0; p < (sides == 3 ? 7 : 9); p++) {
    face_point at;
    if (sides == 3)
      triangle_point(p, &at);
    else
      quadrilateral_point(p, &at);

    // the place in the element, and how it moves in the two directions of the face
    double place[3] = {0}, along[2][3] = {{0}};
    for (int k = 0; k < sides; k++)
      for (int c = 0; c < 3; c++) {
        const double natural = thrum_solid_corners[kind][corner[k]][c];
        place[c] += at.share[k] * natural;
        along[0][c] += at.slope[k][0] * natural;
        along[1][c] += at.slope[k][1] * natural;
      }
    double value[THRUM_SOLID_NODES_MAX], slopes[THRUM_SOLID_NODES_MAX][3], edge[2][3] = {{0}};
    thrum_solid_shape_at(form, place, value, slopes);

    // the two edges of the map span the area around the point
    for (int k = 0; k < count; k++)
      for (int d = 0; d < 2; d++)
        for (int c = 0; c < 3; c++)
          edge[d][c] += thrum_dot3(slopes[nodes[k]], along[d]) * places[nodes[k]][c];
    double normal[3];
    thrum_cross3(edge[0], edge[1], normal);
    const double area = at.weight * sqrt(thrum_dot3(normal, normal));
    whole += area;
    for (int k = 0; k < count; k++)
      shares[k] += area * value[nodes[k]];
  }
  return whole;
}
