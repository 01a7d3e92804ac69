/* Rigid modes of a free body and its springs, see rigid_modes.h. O(n).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/rigid_modes.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"

// shifts and turns about a centre, lengths in units of `size` so that the six are comparable
static void fill_motions(const thrum_fem *fem, const double centre[3], double size, double *modes) {
  const int64_t n = fem->free_count;
  memset(modes, 0, sizeof *modes * (size_t)(THRUM_RIGID_COUNT * n));

  for (int64_t v = 0; v < fem->vertex_count; v++) {
    double arm[3];
    for (int c = 0; c < 3; c++) {
      arm[c] = (fem->vertices[3 * v + c] - centre[c]) / size;
      modes[c * n + fem->dof[3 * v + c]] = 1;
    }

    // turn about axis c: e_c x arm
    for (int c = 0; c < 3; c++) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      modes[(3 + c) * n + fem->dof[3 * v + b]] = arm[a];
      modes[(3 + c) * n + fem->dof[3 * v + a]] = -arm[b];
    }
  }
}

// centre of mass and the largest distance from it along an axis
static thrum_status find_centre(const thrum_fem *fem, double centre[3], double *size,
                                thrum_error *error) {
  // the mass of each vertex
  double *mass = NULL;
  THRUM_TRY(thrum_reserve(&mass, fem->vertex_count, sizeof *mass, "the rigid modes", error));
  thrum_fem_vertex_mass(fem, THRUM_MASS_CONSISTENT, mass);

  // their mean place, and behind it the mass
  double moment[4] = {0};
  *size = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    moment[3] += mass[v];
    for (int c = 0; c < 3; c++)
      moment[c] += mass[v] * fem->vertices[3 * v + c];
  }
  thrum_ranks_sum(fem->ranks, moment, 4);
  for (int c = 0; c < 3; c++)
    centre[c] = moment[c] / moment[3];

  // the farthest vertex along an axis makes the rotations as large as the translations
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    *size = fmax(*size, fabs(fem->vertices[c] - centre[c % 3]));
  thrum_ranks_largest(fem->ranks, size, 1);
  free(mass);
  return THRUM_OK;
}

thrum_status thrum_rigid_modes(const thrum_fem *fem, const thrum_sparse *mass, double *modes,
                               double *dual, thrum_error *error) {
  const int n = (int)fem->free_count, six = THRUM_RIGID_COUNT;

  // three translations and three rotations about the centre of mass
  double centre[3], size, gram[THRUM_RIGID_COUNT * THRUM_RIGID_COUNT];
  THRUM_TRY(find_centre(fem, centre, &size, error));
  fill_motions(fem, centre, size, modes);

  // Cholesky-QR in the mass inner product, twice for rounding's sake
  for (int pass = 0; pass < 2; pass++) {
    thrum_sparse_product(mass, modes, six, dual);
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, six, six, n, 1, modes, n, dual, n, 0, gram,
                six);
    thrum_ranks_sum(fem->ranks, gram, six * six);
    THRUM_TRY(thrum_lapack_status(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', six, gram, six),
                                  THRUM_SINGULAR, "the rigid modes of the body are degenerate",
                                  error));
    cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, n, six, 1, gram,
                six, modes, n);
  }

  // the dual vectors M R of the result
  thrum_sparse_product(mass, modes, six, dual);
  return THRUM_OK;
}

thrum_status thrum_rigid_residual(const thrum_sparse *stiffness, const double *modes,
                                  double *residual, thrum_error *error) {
  const int64_t n = stiffness->size;
  double *work = NULL;
  THRUM_TRY(thrum_reserve(&work, n, sizeof *work, "the rigid modes", error));
  const double norm = thrum_sparse_norm(stiffness, work);
  thrum_status status = THRUM_OK;
  *residual = 0;
  for (int i = 0; i < THRUM_RIGID_COUNT && status >= 0; i++) {
    const double *mode = modes + i * n;
    double force = 0;
    thrum_sparse_product(stiffness, mode, 1, work);
    status = thrum_ranks_force_norm(stiffness->ranks, work, n, &force, error);
    *residual = fmax(*residual, force / (norm * thrum_ranks_norm(stiffness->ranks, mode, n)));
  }
  free(work);
  return status;
}

// the vertex farthest from `point`, or, with a direction, from the line along it
static int64_t farthest(const thrum_fem *fem, const double *point, const double *direction) {
  double most = -1;
  int64_t found = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    double arm[3], across[3];
    thrum_subtract3(fem->vertices + 3 * v, point, arm);
    if (direction)
      thrum_cross3(arm, direction, across);
    const double *from = direction ? across : arm, square = thrum_dot3(from, from);
    if (square > most) {
      most = square;
      found = v;
    }
  }
  return found;
}

// adds strength x direction (3 x 3) at a vertex, keeping what was there
static void attach(const thrum_fem *fem, int64_t vertex, double direction[3][3],
                   thrum_sparse *stiffness, thrum_support_springs *springs, int first) {
  const int32_t *dof = fem->dof + 3 * vertex;
  const double strength =
      (stiffness->value[stiffness->begin[dof[0]]] + stiffness->value[stiffness->begin[dof[1]]] +
       stiffness->value[stiffness->begin[dof[2]]]) /
      3;
  int next = first;
  for (int column = 0; column < 3; column++)
    for (int64_t e = stiffness->begin[dof[column]]; e < stiffness->begin[dof[column] + 1]; e++)
      for (int row = column; row < 3; row++)
        if (stiffness->row[e] == dof[row]) {
          springs->entry[next] = e;
          springs->value[next++] = stiffness->value[e];
          stiffness->value[e] += strength * direction[row][column];
        }
}

void thrum_support_find(const thrum_fem *fem, thrum_support *support) {
  // three vertices far apart: from the origin, from the first one, and from the line of both
  const double *x = fem->vertices;
  const int64_t first = farthest(fem, x, NULL), second = farthest(fem, x + 3 * first, NULL);
  double line[3], arm[3], normal[3];
  thrum_subtract3(x + 3 * second, x + 3 * first, line);
  const int64_t third = farthest(fem, x + 3 * first, line);
  thrum_subtract3(x + 3 * third, x + 3 * first, arm);
  thrum_cross3(line, arm, normal);

  // the first is held in space, the second across the line, the third across the plane
  *support = (thrum_support){.vertex = {first, second, third}};
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      support->direction[0][c][d] = c == d;
      support->direction[1][c][d] = (c == d) - line[c] * line[d] / thrum_dot3(line, line);
      support->direction[2][c][d] = normal[c] * normal[d] / thrum_dot3(normal, normal);
    }
}

void thrum_support_springs_add(const thrum_fem *fem, thrum_sparse *stiffness,
                               thrum_support_springs *springs) {
  thrum_support support;
  thrum_support_find(fem, &support);

  // a pattern without one of these entries has them nowhere: the three vertices differ
  memset(springs, 0, sizeof *springs);
  for (int i = 0; i < 18; i++)
    springs->entry[i] = -1;
  for (int n = 0; n < THRUM_SUPPORTS; n++)
    attach(fem, support.vertex[n], support.direction[n], stiffness, springs, 6 * n);
}

void thrum_support_springs_remove(const thrum_support_springs *springs, thrum_sparse *stiffness) {
  for (int i = 0; i < 18; i++)
    if (springs->entry[i] >= 0)
      stiffness->value[springs->entry[i]] = springs->value[i];
}
