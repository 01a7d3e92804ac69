/* Rigid modes of a free body and its springs, see rigid_modes.h. O(n).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/rigid_modes.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"
#include "runtime/base/vec3.h"

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
  double *mass = thrum_allocate(fem->vertex_count, sizeof *mass, "the rigid modes", error);
  if (!mass)
    return THRUM_OUT_OF_MEMORY;
  thrum_fem_vertex_mass(fem, THRUM_MASS_CONSISTENT, mass);

  // their mean place
  double total = 0;
  centre[0] = centre[1] = centre[2] = *size = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    total += mass[v];
    for (int c = 0; c < 3; c++)
      centre[c] += mass[v] * fem->vertices[3 * v + c];
  }
  for (int c = 0; c < 3; c++)
    centre[c] /= total;

  // the farthest vertex along an axis makes the rotations as large as the translations
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    *size = fmax(*size, fabs(fem->vertices[c] - centre[c % 3]));
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
  double *work = thrum_allocate(n, sizeof *work, "the rigid modes", error);
  if (!work)
    return THRUM_OUT_OF_MEMORY;
  const double norm = thrum_sparse_norm(stiffness, work);
  *residual = 0;
  for (int i = 0; i < THRUM_RIGID_COUNT; i++) {
    const double *mode = modes + i * n;
    thrum_sparse_product(stiffness, mode, 1, work);
    *residual =
        fmax(*residual, cblas_dnrm2((int)n, work, 1) / (norm * cblas_dnrm2((int)n, mode, 1)));
  }
  free(work);
  return THRUM_OK;
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

void thrum_support_springs_add(const thrum_fem *fem, thrum_sparse *stiffness,
                               thrum_support_springs *springs) {
  // three vertices far apart: from the origin, from the first one, and from the line of both
  const double *x = fem->vertices;
  const int64_t first = farthest(fem, x, NULL), second = farthest(fem, x + 3 * first, NULL);
  double line[3], arm[3], normal[3];
  thrum_subtract3(x + 3 * second, x + 3 * first, line);
  const int64_t third = farthest(fem, x + 3 * first, line);
  thrum_subtract3(x + 3 * third, x + 3 * first, arm);
  thrum_cross3(line, arm, normal);

  // the first is held in space, the second across the line, the third across the plane
  double all[3][3], across[3][3], plane[3][3];
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      all[c][d] = c == d;
      across[c][d] = (c == d) - line[c] * line[d] / thrum_dot3(line, line);
      plane[c][d] = normal[c] * normal[d] / thrum_dot3(normal, normal);
    }

  // a pattern without one of these entries has them nowhere: the three vertices differ
  memset(springs, 0, sizeof *springs);
  for (int i = 0; i < 18; i++)
    springs->entry[i] = -1;
  attach(fem, first, all, stiffness, springs, 0);
  attach(fem, second, across, stiffness, springs, 6);
  attach(fem, third, plane, stiffness, springs, 12);
}

void thrum_support_springs_remove(const thrum_support_springs *springs, thrum_sparse *stiffness) {
  for (int i = 0; i < 18; i++)
    if (springs->entry[i] >= 0)
      stiffness->value[springs->entry[i]] = springs->value[i];
}
