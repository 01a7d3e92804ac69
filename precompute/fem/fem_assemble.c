/* Assembly of stiffness and mass of the free components, design 1: the block of corners a and b is
 *   K_ab = vol [(g_a.S g_b) 1 + lambda (F g_a)(F g_b)^T + mu (F g_b)(F g_a)^T + mu (g_a.g_b) F
 * F^T], M_ab = rho vol/20 (1 + [a = b]) 1, or lumped rho vol/4 [a = b] 1. Two passes over the
 * vertices: one counts and lists the neighbours, one adds the blocks of the tets around a vertex
 * into its columns; no search, no duplicate, O(tets) in all.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_tet.h"

static int ascending(const void *left, const void *right) {
  const int32_t a = *(const int32_t *)left, b = *(const int32_t *)right;
  return (a > b) - (a < b);
}

// the neighbours of v with a higher number, ascending; mark[w] == v says that w is listed
static int64_t neighbours(const thrum_fem *fem, int64_t v, int32_t *mark, int32_t *list) {
  int64_t count = 0;
  for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
    const int32_t *corner = fem->tets + fem->incident[e] / 4 * 4;
    for (int a = 0; a < 4; a++)
      if (corner[a] > v && mark[corner[a]] != v) {
        mark[corner[a]] = (int32_t)v;
        list[count++] = corner[a];
      }
  }
  qsort(list, (size_t)count, sizeof *list, ascending);
  return count;
}

static int64_t free_of(const thrum_fem *fem, int64_t v) {
  return (fem->dof[3 * v] >= 0) + (fem->dof[3 * v + 1] >= 0) + (fem->dof[3 * v + 2] >= 0);
}

// one pass over the vertices: without `rows` it fills begin, with rows it fills them
static void walk_pattern(const thrum_fem *fem, int64_t *begin, int64_t *rows, int32_t *mark,
                         int32_t *list) {
  for (int64_t v = 0; v < fem->vertex_count; v++)
    mark[v] = -1;

  // how many free components the vertex and its neighbours below have
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    const int64_t count = neighbours(fem, v, mark, list);
    int64_t below = free_of(fem, v);
    for (int64_t i = 0; i < count; i++)
      below += free_of(fem, list[i]);

    // each of the vertex's free components is a column
    for (int axis = 0; axis < 3; axis++) {
      const int32_t column = fem->dof[3 * v + axis];
      if (column < 0)
        continue;
      // a column holds what is left of its own vertex, then every neighbour
      begin[column + 1] = begin[column] + below--;
      int64_t next = begin[column];
      for (int d = axis; rows && d < 3; d++)
        if (fem->dof[3 * v + d] >= 0)
          rows[next++] = fem->dof[3 * v + d];
      for (int64_t i = 0; rows && i < 3 * count; i++) {
        const int32_t row = fem->dof[3 * (int64_t)list[i / 3] + i % 3];
        if (row >= 0)
          rows[next++] = row;
      }
    }
  }
}

thrum_status thrum_fem_pattern(const thrum_fem *fem, thrum_sparse *stiffness, thrum_error *error) {
  const int64_t n = fem->free_count;
  thrum_status status = THRUM_OUT_OF_MEMORY;
  int32_t *mark = thrum_allocate(fem->vertex_count, sizeof *mark, "the assembly", error);
  int32_t *list = thrum_allocate(fem->vertex_count, sizeof *list, "the assembly", error);
  int64_t *begin = thrum_allocate(n + 1, sizeof *begin, "the assembly", error);

  // the first walk counts the entries, the second one writes their rows
  if (mark && list && begin) {
    begin[0] = 0;
    walk_pattern(fem, begin, NULL, mark, list);
    status = thrum_sparse_create(n, begin[n], stiffness, error);
    if (status >= 0)
      walk_pattern(fem, stiffness->begin, stiffness->row, mark, list);
  }

  free(mark);
  free(list);
  free(begin);
  return status;
}

static double dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// block[c][d] of corners a (rows) and b (columns)
static void stiffness_block(thrum_tet *tet, int a, int b, double block[3][3]) {
  double fa[3], fb[3], sb[3];
  thrum_product_vector(tet->deformation, tet->gradient[a], fa);
  thrum_product_vector(tet->deformation, tet->gradient[b], fb);
  thrum_product_vector(tet->stress, tet->gradient[b], sb);
  const double geometric = dot(tet->gradient[a], sb);
  const double shear = tet->mu * dot(tet->gradient[a], tet->gradient[b]);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++)
      block[c][d] = tet->volume * ((c == d ? geometric : 0) + tet->lambda * fa[c] * fb[d] +
                                   tet->mu * fb[c] * fa[d] +
                                   shear * dot(tet->deformation[c], tet->deformation[d]));
}

// adds the tets around v to the columns of v; slot[row] is the row's place in the first of them,
// and the j-th column of v is the first one without its first j entries
static void fill_vertex(const thrum_fem *fem, int64_t v, const double *u, thrum_sparse *stiffness,
                        int32_t *slot) {
  // the columns of the vertex are its free components
  int32_t column[3];
  int columns = 0, axes[3];
  for (int axis = 0; axis < 3; axis++)
    if (fem->dof[3 * v + axis] >= 0) {
      axes[columns] = axis;
      column[columns++] = fem->dof[3 * v + axis];
    }
  if (columns == 0)
    return;

  // where each row stands in the first column
  const int64_t first = stiffness->begin[column[0]];
  for (int64_t e = first; e < stiffness->begin[column[0] + 1]; e++)
    slot[stiffness->row[e]] = (int32_t)(e - first);

  // each tet at the vertex adds its blocks, from the diagonal downwards
  for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
    const int64_t t = fem->incident[e] / 4;
    thrum_tet tet;
    thrum_tet_deform(fem, t, u, &tet);
    for (int a = 0; a < 4; a++) {
      const int64_t w = fem->tets[4 * t + a];
      if (w < v)
        continue;
      double block[3][3];
      stiffness_block(&tet, a, (int)(fem->incident[e] % 4), block);
      for (int c = 0; c < 3; c++) {
        const int32_t row = fem->dof[3 * w + c];
        for (int j = 0; j < columns && row >= column[j]; j++)
          stiffness->value[stiffness->begin[column[j]] + slot[row] - j] += block[c][axes[j]];
      }
    }
  }
}

thrum_status thrum_fem_stiffness(const thrum_fem *fem, const double *u, thrum_sparse *stiffness,
                                 thrum_error *error) {
  int32_t *slot = thrum_allocate(fem->free_count, sizeof *slot, "the assembly", error);
  if (!slot)
    return THRUM_OUT_OF_MEMORY;
  memset(stiffness->value, 0, sizeof(double) * (size_t)stiffness->begin[stiffness->size]);
  for (int64_t v = 0; v < fem->vertex_count; v++)
    fill_vertex(fem, v, u, stiffness, slot);
  free(slot);
  return THRUM_OK;
}

// entries of a stiffness column that a mass matrix shares: rows of the same axis
static int64_t mass_column(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                           int64_t column, const double *couple, thrum_sparse *mass, int64_t next) {
  const int32_t component = fem->component[column];
  for (int64_t e = pattern->begin[column]; e < pattern->begin[column + 1]; e++) {
    const int64_t row = pattern->row[e];
    const bool kept =
        kind == THRUM_MASS_LUMPED ? row == column : fem->component[row] % 3 == component % 3;
    if (!kept)
      continue;
    if (mass->row) {
      mass->row[next] = row;
      mass->value[next] = couple[fem->component[row] / 3];
    }
    next++;
  }
  return next;
}

// couple[w] = mass between v and each neighbour w >= v
static void couple_vertex(const thrum_fem *fem, thrum_mass kind, int64_t v, double *couple) {
  for (int pass = 0; pass < 2; pass++)
    for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
      const int64_t t = fem->incident[e] / 4;
      const double weight = fem->density[fem->tet_region[t]] * fem->volume[t];
      for (int a = 0; a < 4; a++) {
        const int64_t w = fem->tets[4 * t + a];
        if (pass == 0)
          couple[w] = 0;
        else if (kind == THRUM_MASS_LUMPED)
          couple[w] += w == v ? weight / 4 : 0;
        else
          couple[w] += weight / (w == v ? 10 : 20);
      }
    }
}

thrum_status thrum_fem_mass(const thrum_fem *fem, thrum_mass kind, const thrum_sparse *pattern,
                            thrum_sparse *mass, thrum_error *error) {
  const int64_t n = fem->free_count;
  double *couple = thrum_allocate(fem->vertex_count, sizeof *couple, "the assembly", error);
  if (!couple)
    return THRUM_OUT_OF_MEMORY;

  // count first, then fill
  thrum_sparse made = {.size = n};
  int64_t entries = 0;
  for (int64_t column = 0; column < n; column++)
    entries = mass_column(fem, kind, pattern, column, couple, &made, entries);

  // columns of one vertex share its couplings to its neighbours
  thrum_status status = thrum_sparse_create(n, entries, &made, error);
  if (status >= 0) {
    int64_t vertex = -1;
    for (int64_t column = 0; column < n; column++) {
      if (fem->component[column] / 3 != vertex) {
        vertex = fem->component[column] / 3;
        couple_vertex(fem, kind, vertex, couple);
      }
      made.begin[column + 1] =
          mass_column(fem, kind, pattern, column, couple, &made, made.begin[column]);
    }
    *mass = made;
  }

  free(couple);
  return status;
}

void thrum_fem_vertex_mass(const thrum_fem *fem, double *mass) {
  memset(mass, 0, sizeof *mass * (size_t)fem->vertex_count);
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int a = 0; a < 4; a++)
      mass[fem->tets[4 * t + a]] += fem->density[fem->tet_region[t]] * fem->volume[t] / 4;
}

double thrum_fem_energy(const thrum_fem *fem, const double *u, double *force) {
  double energy = 0;
  if (force)
    memset(force, 0, sizeof *force * (size_t)(3 * fem->vertex_count));
  for (int64_t t = 0; t < fem->tet_count; t++) {
    thrum_tet tet;
    thrum_tet_deform(fem, t, u, &tet);
    energy += tet.energy;

    // force on corner a: vol F S g_a
    for (int a = 0; force && a < 4; a++) {
      double *at = force + 3 * (int64_t)fem->tets[4 * t + a];
      double traction[3];
      thrum_product_vector(tet.stress, tet.gradient[a], traction);
      for (int c = 0; c < 3; c++)
        at[c] += tet.volume *
                 (tet.deformation[c][0] * traction[0] + tet.deformation[c][1] * traction[1] +
                  tet.deformation[c][2] * traction[2]);
    }
  }

  return energy;
}
