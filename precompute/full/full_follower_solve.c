/* Newton's correction under loads that turn with their group: (K - factor sum a b^T) delta = r,
 * with three products a b^T for each load. The matrix is not symmetric, and K need not be positive
 * definite: at rest under such a load the body alone may be unstable. It is solved by GMRES (Saad &
 * Schultz 1986, doi:10.1137/0907058) with the factors of the shifted K, which leave little to do:
 * as many iterations as there are products and negative eigenvalues, and some more.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/full/full_private.h"

#define DIRECTIONS 60 /* kept at most */
#define CLOSE 1e-11   /* residual at which it ends, relative */
#define NEAR 1e-4     /* and the largest that is still of use */

thrum_status full_follower_solver_make(thrum_full *full, const thrum_full_loading *loading,
                                       full_follower_solver *solver, thrum_error *error) {
  const int64_t n = full->body.fem.free_count, all = 3 * full->body.fem.vertex_count;
  const int64_t count = 3 * loading->follower_count;
  full_follower_solver made = {.count = count};
  THRUM_TRY(full_followers_make(loading, full->body.fem.vertices, &made.followers, error));
  const thrum_status status =
      thrum_reserve(&made.memory, (2 * count + DIRECTIONS + 2) * n + 2 * all, sizeof *made.memory,
                    "loads that turn", error);
  if (status >= 0)
    *solver = made;
  else
    full_followers_free(&made.followers);
  return status;
}

void full_follower_solver_free(full_follower_solver *solver) {
  full_followers_free(&solver->followers);
  free(solver->memory);
  *solver = (full_follower_solver){0};
}

/* out = P^-1 (K - factor sum a b^T) x */
static thrum_status apply(thrum_full *full, const full_follower_solver *solver, double factor,
                          const double *x, double *product, double *out, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  const double *a = solver->memory, *b = a + solver->count * n;
  thrum_sparse_product(&full->tangent, x, 1, product);
  for (int64_t k = 0; k < solver->count; k++) {
    const double share = factor * full_dot(full, b + k * n, x);
    for (int64_t i = 0; i < n; i++)
      product[i] -= share * a[k * n + i];
  }
  return full_linear_solve(&full->linear, product, out, error);
}

/* The products at full->place, on the free components. */
static void make_products(thrum_full *full, const full_follower_solver *solver) {
  const thrum_fem *fem = &full->body.fem;
  const int64_t n = fem->free_count, all = 3 * fem->vertex_count;
  double *a = solver->memory, *b = a + solver->count * n;
  double *fields = solver->memory + (2 * solver->count + DIRECTIONS + 2) * n;
  for (int64_t k = 0; k < solver->count; k++) {
    memset(fields, 0, (size_t)(2 * all) * sizeof *fields);
    full_followers_product(&solver->followers, full->place, k, fields, fields + all);
    thrum_fem_gather(fem, fields, a + k * n);
    thrum_fem_gather(fem, fields + all, b + k * n);
  }
}

/* The least-squares problem of GMRES, kept triangular by rotations. */
typedef struct triangle {
  double h[DIRECTIONS + 1][DIRECTIONS]; /* columns of the Hessenberg matrix */
  double c[DIRECTIONS], s[DIRECTIONS];
  double right[DIRECTIONS + 1];
} triangle;

/* Makes column j triangular; returns the residual that is left. */
static double rotate(triangle *t, int j) {
  for (int i = 0; i < j; i++) {
    const double x = t->h[i][j], y = t->h[i + 1][j];
    t->h[i][j] = t->c[i] * x + t->s[i] * y;
    t->h[i + 1][j] = t->c[i] * y - t->s[i] * x;
  }
  const double x = t->h[j][j], y = t->h[j + 1][j], length = sqrt(x * x + y * y);
  t->c[j] = length > 0 ? x / length : 1;
  t->s[j] = length > 0 ? y / length : 0;
  t->h[j][j] = length;
  t->right[j + 1] = -t->s[j] * t->right[j];
  t->right[j] *= t->c[j];
  return fabs(t->right[j + 1]);
}

/* The next direction, orthogonal to those before; its length. */
static double orthogonalise(const thrum_full *full, triangle *t, int j, const double *basis,
                            double *next) {
  const int64_t n = full->body.fem.free_count;
  for (int i = 0; i <= j; i++) {
    t->h[i][j] = full_dot(full, basis + i * n, next);
    for (int64_t k = 0; k < n; k++)
      next[k] -= t->h[i][j] * basis[i * n + k];
  }
  const double length = sqrt(full_dot(full, next, next));
  t->h[j + 1][j] = length;
  for (int64_t k = 0; k < n && length > 0; k++)
    next[k] /= length;
  return length;
}

thrum_status full_follower_solve(thrum_full *full, const full_follower_solver *solver,
                                 double factor, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  double *product = solver->memory + 2 * solver->count * n, *basis = product + n;
  triangle t;
  make_products(full, solver);

  // from zero, whose residual is P^-1 r
  THRUM_TRY(full_linear_solve(&full->linear, full->r, basis, error));
  const double whole = sqrt(full_dot(full, basis, basis));
  memset(full->delta, 0, (size_t)n * sizeof *full->delta);
  if (!(whole > 0))
    return THRUM_OK;
  for (int64_t i = 0; i < n; i++)
    basis[i] /= whole;
  t.right[0] = whole;

  // each direction adds a column
  int columns = 0;
  double left = whole;
  while (columns < DIRECTIONS && left > CLOSE * whole) {
    double *next = basis + (columns + 1) * n;
    THRUM_TRY(apply(full, solver, factor, basis + columns * n, product, next, error));
    const double length = orthogonalise(full, &t, columns, basis, next);
    left = rotate(&t, columns++);
    if (!(length > 0))
      break;
  }
  if (!(left <= NEAR * whole))
    return thrum_error_set(error, THRUM_NOT_CONVERGED, "the correction was not found");

  // back through the triangle
  for (int j = columns - 1; j >= 0; j--) {
    for (int k = j + 1; k < columns; k++)
      t.right[j] -= t.h[j][k] * t.right[k];
    t.right[j] /= t.h[j][j];
    for (int64_t i = 0; i < n; i++)
      full->delta[i] += t.right[j] * basis[j * n + i];
  }
  return THRUM_OK;
}
