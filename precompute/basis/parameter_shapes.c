/* A mode psi of K psi = w^2 M psi gains x = K^-1 (K_g - w^2 M_g) psi beside the modes where a
 * modulus or a density of region g grows, but for how much of other modes that has. Of all x the
 * directions with most strain energy beside the modes are kept, as of modal derivatives. With y = K
 * x all products are those of vectors, and the part in the modes is A = psi^T y / w^2. After R. L.
 * Fox, M. P. Kapoor 1968, doi:10.2514/3.5008. Cost: a solve for each of up to three modes and three
 * parameters of each region.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/parameter_shapes.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/fem/lapack_status.h"

#define NOTHING 1e-8 /* of the largest strain energy: what is left of a shape that modes show */

enum { MODES_MOST = 3, PARAMETERS = 3 }; /* modes that are followed; lambda, mu and density */

int64_t thrum_parameter_shape_count(int64_t regions, int64_t modes) {
  return 2 * (regions - 1) * (modes < MODES_MOST ? modes : MODES_MOST);
}

/* K or M of one region and parameter, of a change of all of its value. */
static thrum_status region_matrix(thrum_fem *fem, thrum_mass kind, int64_t g, int parameter,
                                  thrum_sparse *pattern, thrum_sparse *mass, thrum_error *error) {
  double *const values[] = {fem->lambda, fem->mu, fem->density};
  double *kept = NULL;
  const int64_t regions = fem->region_count;
  THRUM_TRY(thrum_reserve(&kept, PARAMETERS * regions, sizeof *kept, "the regions", error));
  for (int n = 0; n < PARAMETERS; n++)
    for (int64_t m = 0; m < regions; m++) {
      kept[n * regions + m] = values[n][m];
      if (n != parameter || m != g)
        values[n][m] = 0;
    }
  const thrum_status status = parameter == 2 ? thrum_fem_mass(fem, kind, pattern, mass, error)
                                             : thrum_fem_stiffness(fem, NULL, pattern, error);
  for (int n = 0; n < PARAMETERS; n++)
    memcpy(values[n], kept + n * regions, (size_t)regions * sizeof *kept);
  free(kept);
  return status;
}

/* What drives the shapes of one parameter: y, n x some. */
static thrum_status put_drive(thrum_fem *fem, thrum_mass kind, int64_t g, int parameter,
                              thrum_sparse *pattern, int64_t some, const double *psi,
                              const double *omega2, double *y, thrum_error *error) {
  thrum_sparse mass = {0};
  THRUM_TRY(region_matrix(fem, kind, g, parameter, pattern, &mass, error));
  thrum_sparse_product(parameter == 2 ? &mass : pattern, psi, some, y);

  // slow modes move most, as of derivatives
  for (int64_t i = 0; i < some; i++) {
    const double by = omega2[0] / omega2[i];
    cblas_dscal((int)fem->free_count, parameter == 2 ? -omega2[i] * by : by,
                y + i * fem->free_count, 1);
  }
  thrum_sparse_free(&mass);
  return THRUM_OK;
}

typedef struct shapes_work {
  int64_t n, modes, columns;
  double *y, *x;  /* n x columns */
  double *inside; /* modes x columns */
  double *gram;   /* columns x columns */
  double *values; /* columns */
} shapes_work;

/* The directions of the shapes beside the modes, those of most strain energy last. */
static thrum_status find_directions(const shapes_work *w, const double *psi, const double *omega2,
                                    thrum_error *error) {
  const int n = (int)w->n, k = (int)w->modes, c = (int)w->columns;
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k, c, n, 1, psi, n, w->y, n, 0, w->inside,
              k);
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, c, c, n, 1, w->x, n, w->y, n, 0, w->gram, c);
  for (int a = 0; a < c; a++)
    for (int b = 0; b < c; b++)
      for (int i = 0; i < k; i++)
        w->gram[b * c + a] -= w->inside[a * k + i] * w->inside[b * k + i] / omega2[i];
  for (int a = 0; a < c; a++)
    for (int i = 0; i < k; i++)
      w->inside[a * k + i] /= omega2[i];
  return thrum_lapack_status(LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', c, w->gram, c, w->values),
                             THRUM_NOT_CONVERGED, "the shapes of the parameters did not converge",
                             error);
}

thrum_status thrum_parameter_shapes(thrum_fem *fem, thrum_mass kind, thrum_factor *factor,
                                    int64_t modes, const double *psi, const double *omega2,
                                    int64_t count, double *shapes, int64_t *found,
                                    thrum_error *error) {
  const int64_t n = fem->free_count, some = modes < MODES_MOST ? modes : MODES_MOST;
  const int64_t all = PARAMETERS * fem->region_count;
  shapes_work w = {.n = n, .modes = modes, .columns = all * some};
  thrum_sparse pattern = {0};
  thrum_scope memory = thrum_scope_begin("the shapes of the parameters", error);
  w.y = thrum_scope_allocate(&memory, n * w.columns, sizeof(double));
  w.x = thrum_scope_allocate(&memory, n * w.columns, sizeof(double));
  w.inside = thrum_scope_allocate(&memory, modes * w.columns, sizeof(double));
  w.gram = thrum_scope_allocate(&memory, w.columns * w.columns, sizeof(double));
  w.values = thrum_scope_allocate(&memory, w.columns, sizeof(double));
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_fem_pattern(fem, &pattern, error));
  for (int64_t g = 0; g < all && status >= 0; g++)
    status = put_drive(fem, kind, g / PARAMETERS, (int)(g % PARAMETERS), &pattern, some, psi,
                       omega2, w.y + g * some * n, error);
  THRUM_THEN(status, thrum_factor_solve(factor, w.y, w.columns, w.x, error));
  THRUM_THEN(status, find_directions(&w, psi, omega2, error));

  // y is free for x less its part in the modes
  *found = 0;
  if (status >= 0) {
    memcpy(w.y, w.x, (size_t)(n * w.columns) * sizeof *w.y);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)n, (int)w.columns, (int)modes, -1,
                psi, (int)n, w.inside, (int)modes, 1, w.y, (int)n);
  }
  for (int64_t c = w.columns - 1; c >= 0 && *found < count && status >= 0; c--, ++*found) {
    if (!(w.values[c] > NOTHING * w.values[w.columns - 1]))
      break;
    cblas_dgemv(CblasColMajor, CblasNoTrans, (int)n, (int)w.columns, 1, w.y, (int)n,
                w.gram + c * w.columns, 1, 0, w.x, 1);
    thrum_fem_scatter(fem, w.x, shapes + *found * 3 * fem->vertex_count);
  }
  thrum_sparse_free(&pattern);
  thrum_scope_free(&memory);
  return status;
}
