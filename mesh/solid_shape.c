/* Shape functions and points of solids, see solid_shape.h: trilinear and serendipity hexahedra,
 * wedges of 6 and 15 nodes, tetrahedra (Zienkiewicz, Taylor, Zhu 2013, The Finite Element Method,
 * chapter 6). SPDX-License-Identifier: Apache-2.0 */
#include "mesh/solid_shape.h"

#include <math.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"

const double thrum_solid_corners[THRUM_SOLID_KINDS][8][3] = {
    [THRUM_SOLID_TET] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    [THRUM_SOLID_WEDGE] = {{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
    [THRUM_SOLID_HEXAHEDRON] = {{-1, -1, -1},
                                {1, -1, -1},
                                {1, 1, -1},
                                {-1, 1, -1},
                                {-1, -1, 1},
                                {1, -1, 1},
                                {1, 1, 1},
                                {-1, 1, 1}}};

void thrum_solid_node_place(thrum_solid kind, int node, double place[3]) {
  const double(*corner)[3] = thrum_solid_corners[kind];
  const thrum_solid_topology *shape = &thrum_solid_shapes[kind];
  if (node < shape->corners) {
    memcpy(place, corner[node], 3 * sizeof *place);
    return;
  }
  const int *ends = shape->edge[node - shape->corners];
  for (int d = 0; d < 3; d++)
    place[d] = (corner[ends[0]][d] + corner[ends[1]][d]) / 2;
}

/* --- hexahedra -------------------------------------------------------------------------------- */

/* A product of one factor for each direction, and its slopes. */
static void product_of(const double f[3], const double df[3], double *shape, double slopes[3]) {
  *shape = f[0] * f[1] * f[2];
  for (int d = 0; d < 3; d++)
    slopes[d] = df[d] * f[(d + 1) % 3] * f[(d + 2) % 3];
}

static void hexahedron_shape(bool quadratic, const double x[3], double *shape,
                             double (*slopes)[3]) {
  for (int n = 0; n < (quadratic ? 20 : 8); n++) {
    double at[3], f[3], df[3], sum = -2;
    thrum_solid_node_place(THRUM_SOLID_HEXAHEDRON, n, at);
    for (int d = 0; d < 3; d++) {
      // a middle node is where the direction of its edge has (1 - x^2)
      f[d] = at[d] == 0 ? 1 - x[d] * x[d] : (1 + at[d] * x[d]) / 2;
      df[d] = at[d] == 0 ? -2 * x[d] : at[d] / 2;
      sum += at[d] * x[d];
    }
    product_of(f, df, &shape[n], slopes[n]);

    // corners of the quadratic one vanish in the middle of their edges, too
    if (!quadratic || n >= 8)
      continue;
    for (int d = 0; d < 3; d++)
      slopes[n][d] = slopes[n][d] * sum + shape[n] * at[d];
    shape[n] *= sum;
  }
}

/* --- wedges ----------------------------------------------------------------------------------- */

/* The slopes of the three coordinates of a triangle by r and s. */
static const double triangle_slopes[3][2] = {{-1, -1}, {1, 0}, {0, 1}};

static void wedge_shape(bool quadratic, const double x[3], double *shape, double (*slopes)[3]) {
  const double l[3] = {1 - x[0] - x[1], x[0], x[1]}, z = x[2];
  const int(*edge)[2] = thrum_solid_shapes[THRUM_SOLID_WEDGE].edge;
  for (int n = 0; n < (quadratic ? 15 : 6); n++) {
    // a function g(l_i, l_j) h(z), or for quadratic corners l_i (2 l_i - 1) h - l_i (1 - z^2) / 2
    const int corner = n < 6 ? n : edge[n - 6][0], i = corner % 3;
    const bool along = n >= 12;
    const int j = n >= 6 && !along ? edge[n - 6][1] % 3 : -1;
    const double end = corner < 3 ? -1 : 1;
    const double h = along ? 1 - z * z : (1 + end * z) / 2, dh = along ? -2 * z : end / 2;
    double g = l[i], dg[2] = {triangle_slopes[i][0], triangle_slopes[i][1]};
    for (int d = 0; d < 2; d++) {
      if (j >= 0)
        dg[d] = 4 * (triangle_slopes[i][d] * l[j] + l[i] * triangle_slopes[j][d]);
      else if (quadratic && n < 6)
        dg[d] *= 4 * l[i] - 1;
    }
    if (j >= 0)
      g = 4 * l[i] * l[j];
    else if (quadratic && n < 6)
      g = l[i] * (2 * l[i] - 1);

    shape[n] = g * h;
    slopes[n][0] = dg[0] * h;
    slopes[n][1] = dg[1] * h;
    slopes[n][2] = g * dh;
    if (!quadratic || n >= 6)
      continue;
    shape[n] -= l[i] * (1 - z * z) / 2;
    slopes[n][0] -= triangle_slopes[i][0] * (1 - z * z) / 2;
    slopes[n][1] -= triangle_slopes[i][1] * (1 - z * z) / 2;
    slopes[n][2] += l[i] * z;
  }
}

/* --- tetrahedra ------------------------------------------------------------------------------- */

static void tetrahedron_shape(bool quadratic, const double x[3], double *shape,
                              double (*slopes)[3]) {
  const double place[4] = {1 - x[0] - x[1] - x[2], x[0], x[1], x[2]};
  if (quadratic) {
    thrum_quadratic_shape(place, shape);
    thrum_quadratic_slopes(place, slopes);
    return;
  }
  memcpy(shape, place, sizeof place);
  for (int n = 0; n < 4; n++)
    for (int d = 0; d < 3; d++)
      slopes[n][d] = n == 0 ? -1 : n == d + 1;
}

void thrum_solid_shape_at(thrum_solid_form form, const double place[3], double *shape,
                          double (*slopes)[3]) {
  const thrum_solid_form_shape *of = &thrum_solid_forms[form];
  const bool quadratic = of->nodes > thrum_solid_shapes[of->kind].corners;
  double values[THRUM_SOLID_NODES_MAX], steep[THRUM_SOLID_NODES_MAX][3];
  double *n = shape ? shape : values, (*dn)[3] = slopes ? slopes : steep;
  if (of->kind == THRUM_SOLID_HEXAHEDRON)
    hexahedron_shape(quadratic, place, n, dn);
  else if (of->kind == THRUM_SOLID_WEDGE)
    wedge_shape(quadratic, place, n, dn);
  else
    tetrahedron_shape(quadratic, place, n, dn);
}

double thrum_solid_map(int nodes, double (*places)[3], double (*slopes)[3], double jacobian[3][3],
                       double gradients[3][3]) {
  memset(jacobian, 0, 9 * sizeof(double));
  for (int n = 0; n < nodes; n++)
    for (int i = 0; i < 3; i++)
      for (int c = 0; c < 3; c++)
        jacobian[i][c] += slopes[n][i] * places[n][c];

  // the gradients are the rows of the inverse, which are cross products over the determinant
  double cross[3][3];
  for (int i = 0; i < 3; i++)
    thrum_cross3(jacobian[(i + 1) % 3], jacobian[(i + 2) % 3], cross[i]);
  const double det = thrum_dot3(jacobian[0], cross[0]);
  if (!(det > 0) || !isfinite(1 / det))
    return det;
  for (int i = 0; i < 3; i++)
    for (int c = 0; c < 3; c++)
      gradients[i][c] = cross[i][c] / det;
  return det;
}

/* --- points ----------------------------------------------------------------------------------- */

/* Gauss points of order 1 to 3 on -1 to 1. */
static const double gauss_place[3][3] = {{0},
                                         {-0.57735026918962576, 0.57735026918962576},
                                         {-0.77459666924148338, 0, 0.77459666924148338}};
static const double gauss_weight[3][3] = {{2}, {1, 1}, {5.0 / 9, 8.0 / 9, 5.0 / 9}};

static void add_point(thrum_solid_table *t, double x, double y, double z, double weight) {
  double *place = t->place[t->points];
  place[0] = x;
  place[1] = y;
  place[2] = z;
  t->weight[t->points++] = weight;
}

static void hexahedron_points(int order, thrum_solid_table *t) {
  const double *x = gauss_place[order - 1], *w = gauss_weight[order - 1];
  for (int k = 0; k < order; k++)
    for (int j = 0; j < order; j++)
      for (int i = 0; i < order; i++)
        add_point(t, x[i], x[j], x[k], w[i] * w[j] * w[k]);
}

/* Triangles of three points, exact to degree 2, times two; or of six, to degree 4 (Dunavant 1985,
 * doi:10.1002/nme.1620210612), times three. */
static void wedge_points(bool quadratic, thrum_solid_table *t) {
  static const double a[2] = {0.44594849091596489, 0.091576213509770743};
  static const double w[2] = {0.22338158967801147, 0.10995174365532187};
  const int order = quadratic ? 3 : 2;
  for (int k = 0; k < order; k++)
    for (int ring = 0; ring < (quadratic ? 2 : 1); ring++)
      for (int corner = 0; corner < 3; corner++) {
        const double near = quadratic ? a[ring] : 1.0 / 6, far = 1 - 2 * near;
        const double share = quadratic ? w[ring] / 2 : 1.0 / 6;
        add_point(t, corner == 1 ? far : near, corner == 2 ? far : near, gauss_place[order - 1][k],
                  share * gauss_weight[order - 1][k]);
      }
}

static void tetrahedron_points(bool quadratic, thrum_solid_table *t) {
  int count = 0;
  const thrum_quadratic_point *rule =
      quadratic ? thrum_quadratic_rule(true, &count) : thrum_quadratic_rule_of_four(&count);
  for (int p = 0; p < count; p++)
    add_point(t, rule[p].place[1], rule[p].place[2], rule[p].place[3], rule[p].weight / 6);
}

void thrum_solid_table_make(thrum_solid_form form, thrum_solid_table *table) {
  const thrum_solid_form_shape *of = &thrum_solid_forms[form];
  const bool quadratic = of->nodes > thrum_solid_shapes[of->kind].corners;
  *table = (thrum_solid_table){.nodes = of->nodes};
  if (of->kind == THRUM_SOLID_HEXAHEDRON)
    hexahedron_points(quadratic ? 3 : 2, table);
  else if (of->kind == THRUM_SOLID_WEDGE)
    wedge_points(quadratic, table);
  else
    tetrahedron_points(quadratic, table);
  for (int p = 0; p < table->points; p++)
    thrum_solid_shape_at(form, table->place[p], table->shape[p], table->slopes[p]);
}
