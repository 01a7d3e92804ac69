/* Stress of solid elements, see solid_stress.h. With the strains B s of the products s of an
 * element and its enhanced strains M a, both times the root of the elasticity, a is what makes
 * |B s + M a|^2 least, so that B s + M a = (1 - Q Q^T) B s with M = Q R, and the stress is linear
 * in s. Cost: a matrix of up to 48 x 28 an element, made once, and its product a reading.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/solid_stress.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/fem/lapack_status.h"

enum { STRESSES = 6, FIT_MAX = 8 };

/* --- from points to nodes --------------------------------------------------------------------- */

/* The form of the same kind that has its corners alone. */
static thrum_solid_form linear_form(thrum_solid_form form) {
  return thrum_solid_form_of(thrum_solid_forms[form].kind, false);
}

/* The corners' values that fit values at the points best, by the weights of these: (N^T W N)^-1 N^T
 * W. A tetrahedron of one point has its value everywhere. */
static thrum_status fit_corners(const thrum_solid_table *table, thrum_solid_form form,
                                double fit[FIT_MAX][THRUM_SOLID_POINTS_MAX], thrum_error *error) {
  const thrum_solid_form linear = linear_form(form);
  const int corners = thrum_solid_forms[linear].nodes;
  double normal[FIT_MAX * FIT_MAX] = {0}, right[FIT_MAX * THRUM_SOLID_POINTS_MAX];
  for (int p = 0; p < table->points; p++) {
    double shape[THRUM_SOLID_NODES_MAX];
    thrum_solid_shape_at(linear, table->place[p], shape, NULL);
    for (int c = 0; c < corners; c++) {
      right[p * corners + c] = table->weight[p] * shape[c];
      for (int d = 0; d < corners; d++)
        normal[c * corners + d] += table->weight[p] * shape[c] * shape[d];
    }
  }
  if (table->points == 1) {
    for (int c = 0; c < corners; c++)
      fit[c][0] = 1;
    return THRUM_OK;
  }
  THRUM_TRY(thrum_lapack_status(
      LAPACKE_dposv(LAPACK_COL_MAJOR, 'U', corners, table->points, normal, corners, right, corners),
      THRUM_SINGULAR, "the points of an element fit no stress", error));
  for (int p = 0; p < table->points; p++)
    for (int c = 0; c < corners; c++)
      fit[c][p] = right[p * corners + c];
  return THRUM_OK;
}

/* What each point gives each node of a form; a middle node has the mean of its edge. */
static thrum_status make_to_nodes(const thrum_solid_elements *e, thrum_solid_form form,
                                  double *to_nodes, thrum_error *error) {
  double fit[FIT_MAX][THRUM_SOLID_POINTS_MAX];
  const thrum_solid_table *table = &e->tables[form];
  const thrum_solid_topology *shape = &thrum_solid_shapes[thrum_solid_forms[form].kind];
  THRUM_TRY(fit_corners(table, form, fit, error));
  for (int n = 0; n < table->nodes; n++)
    for (int p = 0; p < table->points; p++) {
      const int *ends = n < shape->corners ? NULL : shape->edge[n - shape->corners];
      to_nodes[n * THRUM_SOLID_POINTS_MAX + p] =
          ends ? (fit[ends[0]][p] + fit[ends[1]][p]) / 2 : fit[n][p];
    }
  return THRUM_OK;
}

/* --- planning --------------------------------------------------------------------------------- */

/* Pairs by vertex and region: `last` has the latest pair of each vertex, and pairs of one vertex
 * are chained until they are numbered. */
static void number_pairs(thrum_solid_stresses *s, int32_t *first) {
  const thrum_solid_elements *e = &s->fem->solids;
  const int64_t vertices = s->fem->vertex_count;

  // region after region, each vertex once: counted, then placed
  for (int pass = 0; pass < 2; pass++) {
    for (int32_t region = 0; region < s->fem->region_count; region++)
      for (int64_t n = 0, k = 0; n < e->count; n++)
        for (const int64_t end = e->ends[n]; k < end; k++) {
          const int32_t v = e->nodes[k];
          int32_t *seen = first + vertices + 1 + v;
          if (e->region[n] != region)
            continue;
          const bool fresh = *seen != region + 1;
          *seen = region + 1;
          if (pass == 0) {
            first[v + 1] += fresh;
            continue;
          }
          if (fresh) {
            s->vertex[first[v]] = v;
            s->region[first[v]++] = region;
          }
          s->slot[k] = first[v] - 1;
          s->weight[s->slot[k]] += e->volume[n];
        }
    memset(first + vertices + 1, 0, (size_t)vertices * sizeof *first);
    for (int64_t v = 0; v < vertices && pass == 0; v++)
      first[v + 1] += first[v];
    s->count = pass == 0 ? first[vertices] : s->count;
  }
  for (int64_t n = 0; n < s->count; n++)
    s->weight[n] = 1 / s->weight[n];
}

static thrum_status make_matrices(thrum_solid_stresses *s, thrum_error *error) {
  const thrum_solid_elements *e = &s->fem->solids;
  s->begin = thrum_scope_allocate(&s->memory, e->count + 1, sizeof *s->begin);
  THRUM_TRY(s->memory.status);
  for (int64_t n = 0; n < e->count; n++) {
    const int64_t size = (int64_t)STRESSES * e->tables[e->form[n]].points *
                         thrum_solid_products(thrum_solid_node_count(e, n));
    s->begin[n + 1] = s->begin[n] + (thrum_solid_has_rows(e, n) ? size : 0);
  }
  s->matrix = thrum_scope_allocate(&s->memory, s->begin[e->count], sizeof *s->matrix);
  THRUM_TRY(s->memory.status);
  for (int64_t n = 0; n < e->count; n++)
    if (s->begin[n + 1] > s->begin[n])
      THRUM_TRY(thrum_solid_stress_matrix(e, n, s->fem->lambda, s->fem->mu, s->matrix + s->begin[n],
                                          error));
  return THRUM_OK;
}

static thrum_status fill(thrum_solid_stresses *s, thrum_error *error) {
  const thrum_solid_elements *e = &s->fem->solids;
  const int64_t nodes = e->ends[e->count - 1];
  int32_t *first = thrum_scope_allocate(&s->memory, 2 * s->fem->vertex_count + 1, sizeof *first);
  s->vertex = thrum_scope_allocate(&s->memory, nodes, sizeof *s->vertex);
  s->region = thrum_scope_allocate(&s->memory, nodes, sizeof *s->region);
  s->slot = thrum_scope_allocate(&s->memory, nodes, sizeof *s->slot);
  s->weight = thrum_scope_allocate(&s->memory, nodes, sizeof *s->weight);
  s->to_nodes = thrum_scope_allocate(
      &s->memory, (int64_t)THRUM_FORMS * THRUM_SOLID_NODES_MAX * THRUM_SOLID_POINTS_MAX,
      sizeof *s->to_nodes);
  THRUM_TRY(s->memory.status);
  number_pairs(s, first);
  for (int form = 0; form < THRUM_FORMS; form++)
    THRUM_TRY(make_to_nodes(e, (thrum_solid_form)form,
                            s->to_nodes + form * THRUM_SOLID_NODES_MAX * THRUM_SOLID_POINTS_MAX,
                            error));
  return make_matrices(s, error);
}

thrum_status thrum_solid_stresses_make(const thrum_fem *fem, thrum_solid_stresses *made,
                                       thrum_error *error) {
  thrum_solid_stresses s = {.memory = thrum_scope_begin("the stresses", error), .fem = fem};
  const thrum_status status = fill(&s, error);
  if (status < 0)
    thrum_scope_free(&s.memory);
  else
    *made = s;
  return status;
}

void thrum_solid_stresses_free(thrum_solid_stresses *stress) {
  thrum_scope_free(&stress->memory);
  *stress = (thrum_solid_stresses){0};
}

/* --- reading ---------------------------------------------------------------------------------- */

/* F S F^T / J in the order of the output; NaN where J is not positive. */
static void push(const thrum_tet *tet, double second[3][3], double cauchy[STRESSES]) {
  static const int axes[STRESSES][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
  double cross[3];
  thrum_cross3(tet->deformation[0], tet->deformation[1], cross);
  const double ratio = thrum_dot3(cross, tet->deformation[2]);
  for (int c = 0; c < STRESSES; c++) {
    double sum = 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        sum += tet->deformation[axes[c][0]][i] * second[i][j] * tet->deformation[axes[c][1]][j];
    cauchy[c] = ratio > 0 ? sum / ratio : NAN;
  }
}

/* Stress at the points of an element. */
static void read_points(const thrum_solid_stresses *s, int64_t n, const double *u,
                        double point[THRUM_SOLID_POINTS_MAX][STRESSES]) {
  const thrum_solid_elements *e = &s->fem->solids;
  const int nodes = thrum_solid_node_count(e, n), count = thrum_solid_products(nodes);
  double products[THRUM_SOLID_PRODUCTS_MAX] = {0};
  const bool rows = thrum_solid_has_rows(e, n);
  if (rows)
    thrum_fem_solid_products(s->fem, n, u, products);
  for (int p = 0; p < e->tables[e->form[n]].points; p++) {
    thrum_tet tet;
    double second[3][3];
    thrum_fem_solid_at(s->fem, n, p, u, &tet);
    memcpy(second, tet.stress, sizeof second);
    for (int k = 0; k < STRESSES && rows; k++) {
      const double *row = s->matrix + s->begin[n] + (STRESSES * p + k) * count;
      double sum = 0;
      for (int i = 0; i < count; i++)
        sum += row[i] * products[i];
      const int *axes = thrum_solid_strain_axes[k];
      second[axes[0]][axes[1]] = second[axes[1]][axes[0]] = sum;
    }
    push(&tet, second, point[p]);
  }
}

void thrum_solid_stresses_read(const thrum_solid_stresses *stress, const double *u,
                               double *cauchy) {
  const thrum_solid_elements *e = &stress->fem->solids;
  double point[THRUM_SOLID_POINTS_MAX][STRESSES];
  memset(cauchy, 0, (size_t)(STRESSES * stress->count) * sizeof *cauchy);
  for (int64_t n = 0, k = 0; n < e->count; n++) {
    const double *to_nodes =
        stress->to_nodes + e->form[n] * THRUM_SOLID_NODES_MAX * THRUM_SOLID_POINTS_MAX;
    read_points(stress, n, u, point);
    for (int a = 0; a < thrum_solid_node_count(e, n); a++, k++) {
      double *at = cauchy + STRESSES * (int64_t)stress->slot[k];
      const double share = e->volume[n] * stress->weight[stress->slot[k]];
      for (int p = 0; p < e->tables[e->form[n]].points; p++)
        for (int c = 0; c < STRESSES; c++)
          at[c] += share * to_nodes[a * THRUM_SOLID_POINTS_MAX + p] * point[p][c];
    }
  }
}
