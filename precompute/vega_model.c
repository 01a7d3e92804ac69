/* A model of a .cub file alone: S^T L S = diag(omega^2) with S orthogonal, and V(S q) of its
 * polynomial (design 1 and 2). Cost: that of a change of basis, r^5.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/vega_model.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/polynomial/change_of_basis.h"
#include "precompute/vega_reduced.h"

#define AS_IT_IS 1e-11 /* as of an imported basis: up to this the file's bits stay */

void thrum_vega_model_free(thrum_vega_model *made) {
  thrum_scope_free(&made->memory);
  *made = (thrum_vega_model){0};
}

/* Is the linear part diagonal already, ascending? */
static bool is_diagonal(const thrum_imported_basis *read) {
  const int64_t r = read->rank;
  double largest = 0, off = 0;
  bool ascending = true;
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++) {
      const double entry = fabs(read->linear[i * r + j]);
      largest = i == j ? fmax(largest, entry) : largest;
      off = i == j ? off : fmax(off, entry);
      if (i == j && i > 0 && read->linear[i * r + i] < read->linear[(i - 1) * r + i - 1])
        ascending = false;
    }
  return ascending && off <= AS_IT_IS * largest;
}

/* Turns the coordinates; `change` is rank x rank. */
static thrum_status turn(const thrum_imported_basis *read, double *change, thrum_vega_model *made,
                         thrum_error *error) {
  const int64_t r = read->rank;
  memcpy(change, read->linear, sizeof *change * (size_t)(r * r));
  const int info = LAPACKE_dsyevd(LAPACK_ROW_MAJOR, 'V', 'U', (int)r, change, (int)r, made->omega2);
  THRUM_TRY(thrum_lapack_status(info, THRUM_NOT_CONVERGED,
                                "the frequencies of the polynomial did not converge", error));
  thrum_eigen_canonicalise(r, r, made->omega2, 1e-14 * made->omega2[r - 1], change, r, 1);
  made->changed = true;
  return thrum_polynomial_change_basis(r, change, read->c3, read->c4, made->c3, made->c4, error);
}

static thrum_status fill(const char *path, thrum_imported_basis *read, thrum_vega_model *made,
                         thrum_error *error) {
  const int64_t r = read->rank, count3 = thrum_c3_count(r), count4 = thrum_c4_count(r);
  made->memory = thrum_scope_begin("the polynomial", error);
  double *change = thrum_scope_allocate(&made->memory, r * r, sizeof *change);
  made->omega2 = thrum_scope_allocate(&made->memory, r, sizeof *made->omega2);
  made->c3 = thrum_scope_allocate(&made->memory, count3, sizeof *made->c3);
  made->c4 = thrum_scope_allocate(&made->memory, count4, sizeof *made->c4);
  thrum_status status = made->memory.status;

  // a polynomial of Thrum's own comes back with its bits
  if (status >= 0 && is_diagonal(read)) {
    for (int64_t i = 0; i < r; i++)
      made->omega2[i] = read->linear[i * r + i];
    memcpy(made->c3, read->c3, sizeof *made->c3 * (size_t)count3);
    memcpy(made->c4, read->c4, sizeof *made->c4 * (size_t)count4);
  } else if (status >= 0) {
    status = turn(read, change, made, error);
  }

  // without stiffness a coordinate is a rigid motion, or the file is no polynomial of a body
  if (status >= 0 && !(made->omega2[0] > 0))
    status = thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: the stiffness has the eigenvalue %g, which must be above 0",
                             path, made->omega2[0]);
  made->defect = read->defect;
  static const int32_t format[2] = {THRUM_MODEL_FORMAT_MAJOR, THRUM_MODEL_FORMAT_MINOR};
  made->model = (thrum_model){.rank = r,
                              .format = format,
                              .omega2 = made->omega2,
                              .c3_count = count3,
                              .c3 = made->c3,
                              .c4_count = count4,
                              .c4 = made->c4};
  return status;
}

thrum_status thrum_vega_model_read(const char *path, thrum_vega_model *made, thrum_error *error) {
  thrum_imported_basis read = {0};
  thrum_vega_model result = {0};
  thrum_status status = thrum_vega_cubic_read(path, &read, error);
  THRUM_THEN(status, fill(path, &read, &result, error));
  thrum_imported_basis_free(&read);
  if (status < 0)
    thrum_vega_model_free(&result);
  else
    *made = result;
  return status;
}
