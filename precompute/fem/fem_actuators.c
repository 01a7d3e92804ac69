/* Actuators of the full-order body, see fem_actuators.h.
 *
 * A volume is the integral of -sum_a w_a (x_a - o_a) n_a over its faces, n = x,1 x x,2 outwards of
 * the body: a cubic polynomial of the nodes, which six points of a triangle integrate exactly for
 * faces of six nodes. A strain of level a changes the energy 1/2 (E - a E0) : C : (E - a E0) by -a
 * E : S0 and a constant, S0 = C : E0. A tendon has the length of its straight parts. Cost: linear
 * in faces, tets and guides.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/fem_actuators.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "precompute/fem/fem_tet.h"

/* --- points of a face ------------------------------------------------------------------------- */

/* Shape functions and slopes at l_1, l_2. */
static void fill_point(int nodes, double l1, double l2, thrum_face_point *point) {
  const double l[3] = {1 - l1 - l2, l1, l2};
  static const double by[3][2] = {{-1, -1}, {1, 0}, {0, 1}};
  for (int a = 0; a < 3; a++) {
    point->shape[a] = nodes == 3 ? l[a] : l[a] * (2 * l[a] - 1);
    for (int s = 0; s < 2; s++)
      point->slope[a][s] = nodes == 3 ? by[a][s] : (4 * l[a] - 1) * by[a][s];
  }
  for (int e = 0; e < 3 && nodes == 6; e++) {
    const int a = e, b = (e + 1) % 3;
    point->shape[3 + e] = 4 * l[a] * l[b];
    for (int s = 0; s < 2; s++)
      point->slope[3 + e][s] = 4 * (l[a] * by[b][s] + l[b] * by[a][s]);
  }
}

/* Flat faces need the middle alone; the six points are exact to degree 4. Source: Strang & Fix
 * 1973, An analysis of the finite element method; Dunavant 1985, doi:10.1002/nme.1620210612. */
int thrum_face_points(int nodes, thrum_face_point points[THRUM_FACE_POINTS]) {
  if (nodes == 3) {
    fill_point(3, 1.0 / 3, 1.0 / 3, &points[0]);
    points[0].weight = 0.5;
    return 1;
  }
  const double root = sqrt(10), corner = sqrt(38 - 44 * sqrt(2.0 / 5));
  const double places[2] = {(8 - root + corner) / 18, (8 - root - corner) / 18};
  const double inner = sqrt(213125 - 53320 * root);
  const double weights[2] = {(620 + inner) / 3720, (620 - inner) / 3720};
  for (int group = 0; group < 2; group++)
    for (int n = 0; n < 3; n++) {
      thrum_face_point *point = &points[3 * group + n];
      const double at = places[group], other = 1 - 2 * at;
      fill_point(6, n == 1 ? other : at, n == 2 ? other : at, point);
      point->weight = 0.5 * weights[group];
    }
  return THRUM_FACE_POINTS;
}

/* --- surfaces --------------------------------------------------------------------------------- */

/* Where a vertex is. */
static void vertex_at(const thrum_fem *fem, const double *u, int64_t v, double at[3]) {
  for (int axis = 0; axis < 3; axis++)
    at[axis] = fem->vertices[3 * v + axis] + (u ? u[3 * v + axis] : 0);
}

/* Where a node of a surface is, a mean by its terms. */
static void node_at(const thrum_fem *fem, const thrum_actuator_surface *s, const double *u,
                    int64_t node, double at[3]) {
  if (node < fem->vertex_count) {
    vertex_at(fem, u, node, at);
    return;
  }
  const int64_t m = node - fem->vertex_count, first = m > 0 ? s->mean_ends[m - 1] : 0;
  const double share = 1 / (double)(s->mean_ends[m] - first);
  at[0] = at[1] = at[2] = 0;
  for (int64_t n = first; n < s->mean_ends[m]; n++) {
    double one[3];
    node_at(fem, s, u, s->mean_nodes[n], one);
    for (int axis = 0; axis < 3; axis++)
      at[axis] += share * one[axis];
  }
}

/* The nodes of face f, and where they are at u. */
static const int32_t *face_nodes(const thrum_fem *fem, const thrum_actuator_surface *s,
                                 const double *u, int64_t f, double nodes[THRUM_FACE_NODES][3]) {
  const int32_t *face = s->faces + f * s->nodes;
  for (int a = 0; a < s->nodes; a++)
    node_at(fem, s, u, face[a], nodes[a]);
  return face;
}

/* Adds a vector at a node. */
static void add_at(const thrum_fem *fem, const thrum_actuator_surface *s, int64_t node,
                   const double vector[3], double by, double *field) {
  if (node < fem->vertex_count) {
    for (int axis = 0; axis < 3; axis++)
      field[3 * node + axis] += by * vector[axis];
    return;
  }
  const int64_t m = node - fem->vertex_count, first = m > 0 ? s->mean_ends[m - 1] : 0;
  const double share = by / (double)(s->mean_ends[m] - first);
  for (int64_t n = first; n < s->mean_ends[m]; n++)
    add_at(fem, s, s->mean_nodes[n], vector, share, field);
}

/* A face at a point: place from the origin, each axis times its weight, edges along both
 * coordinates, and their product n. */
typedef struct face_at {
  double weighed[3], edge[2][3], normal[3];
} face_at;

static face_at face_at_point(const thrum_actuator_surface *s, double nodes[][3],
                             const thrum_face_point *point) {
  face_at at = {{0}, {{0}}, {0}};
  for (int a = 0; a < s->nodes; a++)
    for (int axis = 0; axis < 3; axis++) {
      at.weighed[axis] += point->shape[a] * (nodes[a][axis] - s->origin[axis]) * s->weight[axis];
      for (int e = 0; e < 2; e++)
        at.edge[e][axis] += point->slope[a][e] * nodes[a][axis];
    }
  thrum_cross3(at.edge[0], at.edge[1], at.normal);
  return at;
}

static double volume_at(const thrum_fem *fem, const thrum_actuator_surface *s, const double *u,
                        double by, double *gradient) {
  thrum_face_point points[THRUM_FACE_POINTS];
  const int count = thrum_face_points(s->nodes, points);
  double sum = 0;
  for (int64_t f = 0; f < s->face_count; f++) {
    double nodes[THRUM_FACE_NODES][3];
    const int32_t *face = face_nodes(fem, s, u, f, nodes);
    for (int p = 0; p < count; p++) {
      const face_at at = face_at_point(s, nodes, &points[p]);
      sum -= points[p].weight * thrum_dot3(at.weighed, at.normal);
      if (!gradient)
        continue;
      double first[3], second[3];
      thrum_cross3(at.edge[1], at.weighed, first);
      thrum_cross3(at.weighed, at.edge[0], second);
      for (int a = 0; a < s->nodes; a++) {
        double pull[3];
        for (int axis = 0; axis < 3; axis++)
          pull[axis] = s->weight[axis] * points[p].shape[a] * at.normal[axis] +
                       points[p].slope[a][0] * first[axis] + points[p].slope[a][1] * second[axis];
        add_at(fem, s, face[a], pull, -by * points[p].weight, gradient);
      }
    }
  }
  return sum;
}

/* Adds `by` times the integral of each shape function times n. */
static void push_faces(const thrum_fem *fem, const thrum_actuator_surface *s, const double *u,
                       double by, double *loads) {
  thrum_face_point points[THRUM_FACE_POINTS];
  const int count = thrum_face_points(s->nodes, points);
  for (int64_t f = 0; f < s->face_count; f++) {
    double nodes[THRUM_FACE_NODES][3];
    const int32_t *face = face_nodes(fem, s, u, f, nodes);
    for (int p = 0; p < count; p++) {
      const face_at at = face_at_point(s, nodes, &points[p]);
      for (int a = 0; a < s->nodes; a++)
        add_at(fem, s, face[a], at.normal, by * points[p].weight * points[p].shape[a], loads);
    }
  }
}

/* --- a matrix --------------------------------------------------------------------------------- */

/* Adds a number to an entry, given once for each of both triangles, where the pattern has it. */
static void add_entry(thrum_sparse *matrix, int64_t i, int64_t j, double value) {
  if (i < j)
    return;
  int64_t low = matrix->begin[j], high = matrix->begin[j + 1];
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (matrix->row[middle] < i)
      low = middle + 1;
    else
      high = middle;
  }
  if (low < matrix->begin[j + 1] && matrix->row[low] == i)
    matrix->value[low] += value;
}

/* The block of two vertices. */
static void add_block(const thrum_fem *fem, int64_t v, int64_t w, double block[3][3],
                      thrum_sparse *matrix) {
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      const int32_t i = fem->dof[3 * v + c], j = fem->dof[3 * w + d];
      if (i >= 0 && j >= 0)
        add_entry(matrix, i, j, block[c][d]);
    }
}

/* (a x) as a matrix times `by`, added: entry (c, d) of it is sum_e epsilon_cde a_e. */
static void add_turn(const double a[3], double by, double block[3][3]) {
  for (int c = 0; c < 3; c++) {
    const int d = (c + 1) % 3, e = (c + 2) % 3;
    block[c][d] += by * a[e];
    block[d][c] -= by * a[e];
  }
}

/* Second derivative of (weighed . normal) by nodes a and b. */
static void curve_of(const thrum_actuator_surface *s, const thrum_face_point *point,
                     const face_at *at, int a, int b, double block[3][3]) {
  double to_a[3][3] = {{0}}, to_b[3][3] = {{0}};
  for (int axis = 0; axis < 3; axis++)
    memset(block[axis], 0, 3 * sizeof(double));

  // n by node b, and n by node a
  add_turn(at->edge[1], point->slope[b][0], to_b);
  add_turn(at->edge[0], -point->slope[b][1], to_b);
  add_turn(at->edge[1], point->slope[a][0], to_a);
  add_turn(at->edge[0], -point->slope[a][1], to_a);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      block[c][d] +=
          s->weight[c] * point->shape[a] * to_b[c][d] + s->weight[d] * point->shape[b] * to_a[d][c];

  // and n by both
  add_turn(at->weighed,
           point->slope[a][0] * point->slope[b][1] - point->slope[a][1] * point->slope[b][0],
           block);
}

static void add_surface_stiffness(const thrum_fem *fem, const thrum_actuator_surface *s,
                                  const double *u, double by, thrum_sparse *stiffness) {
  thrum_face_point points[THRUM_FACE_POINTS];
  const int count = thrum_face_points(s->nodes, points);
  for (int64_t f = 0; f < s->face_count; f++) {
    double nodes[THRUM_FACE_NODES][3];
    const int32_t *face = face_nodes(fem, s, u, f, nodes);
    for (int p = 0; p < count; p++) {
      const face_at at = face_at_point(s, nodes, &points[p]);
      for (int a = 0; a < s->nodes; a++)
        for (int b = 0; b < s->nodes; b++) {
          if (face[a] >= fem->vertex_count || face[b] >= fem->vertex_count)
            continue;
          double block[3][3];
          curve_of(s, &points[p], &at, a, b, block);
          for (int c = 0; c < 9; c++)
            block[c / 3][c % 3] *= -by * points[p].weight;
          add_block(fem, face[a], face[b], block, stiffness);
        }
    }
  }
}

/* --- strains ---------------------------------------------------------------------------------- */

/* Whether a tet strains, and its stress S0. */
static bool strains(const thrum_fem *fem, const thrum_actuator *actuator, int64_t t,
                    double stress[3][3]) {
  const int32_t region = fem->tet_region[t];
  double strain[3][3];
  if (actuator->region >= 0 && region != actuator->region)
    return false;
  memcpy(strain, actuator->strain, sizeof strain);
  thrum_stress(fem->lambda[region], fem->mu[region], strain, stress);
  return true;
}

/* The displacement gradient at a point. */
static void gradient_at(const thrum_fem *fem, int64_t t, double (*shape)[3], const double *u,
                        double gradient[3][3]) {
  memset(gradient, 0, 9 * sizeof(double));
  for (int a = 0; u && a < fem->node_count; a++)
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        gradient[c][d] += u[3 * (int64_t)fem->nodes[fem->node_count * t + a] + c] * shape[a][d];
}

static double work_at(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                      double by, double *gradient) {
  double sum = 0;
  for (int64_t t = 0; t < fem->tet_count; t++) {
    double stress[3][3], shape[THRUM_FEM_NODES_MAX][3], g[3][3];
    if (!strains(fem, actuator, t, stress))
      continue;
    for (int p = 0; p < fem->point_count; p++) {
      const double weight = fem->weight[t * fem->point_count + p];
      thrum_fem_shape_gradients(fem, t, p, shape);
      gradient_at(fem, t, shape, u, g);
      double pushed[3][3];

      // S0 : E = S0 : (G + 1/2 G^T G), and the stress (1 + G) S0
      for (int c = 0; c < 3; c++)
        for (int d = 0; d < 3; d++) {
          pushed[c][d] = stress[c][d];
          for (int e = 0; e < 3; e++)
            pushed[c][d] += g[c][e] * stress[e][d];
          sum += 0.5 * weight * g[c][d] * (stress[c][d] + pushed[c][d]);
        }
      for (int a = 0; gradient && a < fem->node_count; a++)
        for (int c = 0; c < 3; c++)
          gradient[3 * (int64_t)fem->nodes[fem->node_count * t + a] + c] +=
              by * weight * thrum_dot3(pushed[c], shape[a]);
    }
  }
  return sum;
}

static void add_strain_stiffness(const thrum_fem *fem, const thrum_actuator *actuator, double by,
                                 thrum_sparse *stiffness) {
  for (int64_t t = 0; t < fem->tet_count; t++) {
    double stress[3][3], shape[THRUM_FEM_NODES_MAX][3];
    if (!strains(fem, actuator, t, stress))
      continue;
    for (int p = 0; p < fem->point_count; p++) {
      const double weight = by * fem->weight[t * fem->point_count + p];
      thrum_fem_shape_gradients(fem, t, p, shape);
      for (int a = 0; a < fem->node_count; a++)
        for (int b = 0; b < fem->node_count; b++) {
          double block[3][3] = {{0}}, sum = 0;
          for (int c = 0; c < 3; c++)
            sum += shape[a][c] * thrum_dot3(stress[c], shape[b]);
          for (int c = 0; c < 3; c++)
            block[c][c] = weight * sum;
          const int32_t *node = fem->nodes + fem->node_count * t;
          add_block(fem, node[a], node[b], block, stiffness);
        }
    }
  }
}

/* --- tendons ---------------------------------------------------------------------------------- */

static void guide_at(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                     int64_t n, double at[3]) {
  if (actuator->guides[n] >= 0)
    vertex_at(fem, u, actuator->guides[n], at);
  else
    memcpy(at, actuator->places + 3 * n, 3 * sizeof *at);
}

/* A straight part: its direction; returns its length. */
static double part_of(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                      int64_t n, double direction[3]) {
  double from[3], to[3];
  guide_at(fem, actuator, u, n, from);
  guide_at(fem, actuator, u, n + 1, to);
  thrum_subtract3(to, from, direction);
  const double length = sqrt(thrum_dot3(direction, direction));
  for (int axis = 0; axis < 3; axis++)
    direction[axis] /= length;
  return length;
}

static double length_at(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                        double by, double *gradient) {
  double sum = 0, direction[3];
  for (int64_t n = 0; n + 1 < actuator->guide_count; n++) {
    sum += part_of(fem, actuator, u, n, direction);
    for (int end = 0; gradient && end < 2; end++) {
      const int64_t v = actuator->guides[n + end];
      for (int axis = 0; v >= 0 && axis < 3; axis++)
        gradient[3 * v + axis] += (end ? by : -by) * direction[axis];
    }
  }
  return sum;
}

static void add_tendon_stiffness(const thrum_fem *fem, const thrum_actuator *actuator,
                                 const double *u, double by, thrum_sparse *stiffness) {
  for (int64_t n = 0; n + 1 < actuator->guide_count; n++) {
    double d[3];
    const double length = part_of(fem, actuator, u, n, d);
    for (int a = 0; a < 2; a++)
      for (int b = 0; b < 2; b++) {
        const int64_t v = actuator->guides[n + a], w = actuator->guides[n + b];
        double block[3][3];
        for (int c = 0; c < 9; c++)
          block[c / 3][c % 3] =
              (a == b ? by : -by) / length * ((c / 3 == c % 3 ? 1 : 0) - d[c / 3] * d[c % 3]);
        if (v >= 0 && w >= 0)
          add_block(fem, v, w, block, stiffness);
      }
  }
}

/* --- all kinds -------------------------------------------------------------------------------- */

double thrum_fem_actuator_rest(const thrum_fem *fem, const thrum_actuator *actuator) {
  if (actuator->kind == THRUM_ACTUATOR_STRAIN)
    return 0;
  return actuator->kind == THRUM_ACTUATOR_TENDON
             ? length_at(fem, actuator, NULL, 1, NULL)
             : volume_at(fem, &actuator->surface, NULL, 1, NULL);
}

double thrum_fem_actuator(const thrum_fem *fem, const thrum_actuator *actuator, const double *u,
                          double by, double *gradient) {
  const double rest = thrum_fem_actuator_rest(fem, actuator);
  if (actuator->kind == THRUM_ACTUATOR_STRAIN)
    return work_at(fem, actuator, u, by, gradient);
  return actuator->kind == THRUM_ACTUATOR_TENDON
             ? rest - length_at(fem, actuator, u, -by, gradient)
             : volume_at(fem, &actuator->surface, u, by, gradient) - rest;
}

void thrum_fem_actuator_stiffness(const thrum_fem *fem, const thrum_actuator *actuator,
                                  const double *u, double by, thrum_sparse *stiffness) {
  if (actuator->kind == THRUM_ACTUATOR_STRAIN)
    add_strain_stiffness(fem, actuator, by, stiffness);
  else if (actuator->kind == THRUM_ACTUATOR_TENDON)
    add_tendon_stiffness(fem, actuator, u, -by, stiffness);
  else
    add_surface_stiffness(fem, &actuator->surface, u, by, stiffness);
}

/* --- what acts -------------------------------------------------------------------------------- */

/* The energy of one at its measure, and its slope. */
static double energy_at(const thrum_fem *fem, int64_t k, double measure, double *slope) {
  const struct thrum_fem_acting *acting = fem->acting;
  const thrum_actuator *one = &acting->actuators[k];
  const double level = acting->levels[k], volume = acting->rest[k];
  *slope = -level;
  if (one->kind != THRUM_ACTUATOR_GAS)
    return -level * measure;

  // a gas whose volume is gone has no energy
  const double inside = one->outside + level, now = volume + measure;
  *slope = now > 0 ? one->outside - inside * volume / now : NAN;
  return now > 0 ? one->outside * measure - inside * volume * log1p(measure / volume) : NAN;
}

static bool is_idle(const thrum_fem *fem, int64_t k) {
  return fem->acting->levels[k] == 0 && fem->acting->actuators[k].kind != THRUM_ACTUATOR_GAS;
}

double thrum_fem_acting_energy(const thrum_fem *fem, const double *u, double *force) {
  double sum = 0, slope;
  for (int64_t k = 0; fem->acting && k < fem->acting->count; k++) {
    if (is_idle(fem, k))
      continue;
    const thrum_actuator *one = &fem->acting->actuators[k];
    const double measure = thrum_fem_actuator(fem, one, u, 0, NULL);
    sum += energy_at(fem, k, measure, &slope);
    if (force)
      thrum_fem_actuator(fem, one, u, slope, force);
  }
  return sum;
}

void thrum_fem_acting_loads(const thrum_fem *fem, const double *u, double *loads) {
  double slope;
  for (int64_t k = 0; fem->acting && k < fem->acting->count; k++) {
    if (is_idle(fem, k))
      continue;
    const thrum_actuator *one = &fem->acting->actuators[k];
    energy_at(fem, k, thrum_fem_actuator(fem, one, u, 0, NULL), &slope);
    if (one->surface.face_count > 0)
      push_faces(fem, &one->surface, u, slope, loads);
    else
      thrum_fem_actuator(fem, one, u, -slope, loads);
  }
}

void thrum_fem_acting_stiffness(const thrum_fem *fem, const double *u, thrum_sparse *stiffness) {
  double slope;
  for (int64_t k = 0; fem->acting && k < fem->acting->count; k++) {
    if (is_idle(fem, k))
      continue;
    const thrum_actuator *one = &fem->acting->actuators[k];
    energy_at(fem, k, thrum_fem_actuator(fem, one, u, 0, NULL), &slope);
    thrum_fem_actuator_stiffness(fem, one, u, slope, stiffness);
  }
}
