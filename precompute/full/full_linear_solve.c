/* Sparse linear systems: Cholesky, alone or shared by several processes, or conjugate gradients
 * with symmetric Gauss-Seidel as preconditioner, (D + L) D^-1 (D + L^T), which is positive definite
 * where A is and needs no memory and no setup. Where a direction of negative curvature turns up A
 * is not positive definite.
 *
 * Cost: Cholesky O(n^2) once and O(n^(4/3)) a solve for a solid; an iteration of the other O(n).
 * Source: Saad 2003, Iterative methods for sparse linear systems, doi:10.1137/1.9780898718003.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/full/full_linear_solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

#define ITERATIONS_MAX 20000

thrum_status full_linear_make(thrum_full_solver solver, const thrum_full_shared *shared,
                              double tolerance, const thrum_sparse *matrix, full_linear *linear,
                              thrum_error *error) {
  full_linear made = {.solver = solver, .tolerance = tolerance, .matrix = matrix};
  const bool factored = solver == THRUM_FULL_CHOLESKY;
  thrum_status status = THRUM_OK;
  if (factored && shared != NULL) {
    made.shared = shared;
    status = shared->plan(shared->context, matrix, &made.system, error);
  } else if (factored) {
    status = thrum_factor_plan(matrix, &made.factor, error);
  } else {
    status =
        thrum_reserve(&made.work, 4 * matrix->size, sizeof *made.work, "the linear solver", error);
  }
  if (status >= 0)
    *linear = made;
  return status;
}

void full_linear_free(full_linear *linear) {
  if (linear->shared != NULL)
    linear->shared->end(linear->system);
  thrum_factor_free(linear->factor);
  free(linear->work);
  *linear = (full_linear){0};
}

thrum_status full_linear_prepare(full_linear *linear, thrum_error *error) {
  linear->ready = false;
  linear->factorisations++;
  thrum_status status = THRUM_OK;
  if (linear->shared != NULL)
    status = linear->shared->compute(linear->system, linear->matrix, error);
  else if (linear->solver == THRUM_FULL_CHOLESKY)
    status = thrum_factor_compute(linear->matrix, linear->factor, error);
  linear->ready = status >= 0;
  return status;
}

/* z = (D + L^T)^-1 D (D + L)^-1 r, by the columns of the lower triangle. */
static void precondition(const thrum_sparse *a, const double *r, double *z) {
  memcpy(z, r, (size_t)a->size * sizeof *z);
  for (int64_t j = 0; j < a->size; j++) {
    z[j] /= a->value[a->begin[j]];
    for (int64_t e = a->begin[j] + 1; e < a->begin[j + 1]; e++)
      z[a->row[e]] -= a->value[e] * z[j];
  }
  for (int64_t j = a->size - 1; j >= 0; j--) {
    double sum = 0;
    for (int64_t e = a->begin[j] + 1; e < a->begin[j + 1]; e++)
      sum += a->value[e] * z[a->row[e]];
    z[j] -= sum / a->value[a->begin[j]];
  }
}

static double dot(int64_t n, const double *x, const double *y) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++)
    sum += x[i] * y[i];
  return sum;
}

static thrum_status conjugate_gradients(full_linear *linear, const double *b, double *x,
                                        thrum_error *error) {
  const thrum_sparse *a = linear->matrix;
  const int64_t n = a->size;
  double *r = linear->work, *z = r + n, *p = z + n, *ap = p + n;

  // a matrix that is positive definite has a positive diagonal
  for (int64_t j = 0; j < n; j++)
    if (!(a->value[a->begin[j]] > 0))
      return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");

  // from zero, whose residual is the right-hand side
  memset(x, 0, (size_t)n * sizeof *x);
  memcpy(r, b, (size_t)n * sizeof *r);
  const double whole = sqrt(dot(n, b, b));
  precondition(a, r, z);
  memcpy(p, z, (size_t)n * sizeof *p);
  double rz = dot(n, r, z);

  // until the residual is small beside the right-hand side
  for (int k = 0; k < ITERATIONS_MAX; k++) {
    if (sqrt(dot(n, r, r)) <= linear->tolerance * whole)
      return THRUM_OK;

    // along a direction of negative curvature there is no minimum
    thrum_sparse_product(a, p, 1, ap);
    const double curvature = dot(n, p, ap);
    if (!(curvature > 0))
      return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");
    const double length = rz / curvature;

    // to the minimum along the direction
    for (int64_t i = 0; i < n; i++) {
      x[i] += length * p[i];
      r[i] -= length * ap[i];
    }

    // the next direction is conjugate to all before
    precondition(a, r, z);
    const double next = dot(n, r, z);
    for (int64_t i = 0; i < n; i++)
      p[i] = z[i] + next / rz * p[i];
    rz = next;
    linear->iterations++;
  }

  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "conjugate gradients did not converge in %d iterations", ITERATIONS_MAX);
}

thrum_status full_linear_solve(full_linear *linear, const double *b, double *x,
                               thrum_error *error) {
  if (linear->shared != NULL)
    return linear->shared->solve(linear->system, b, x, error);
  if (linear->solver == THRUM_FULL_CHOLESKY)
    return thrum_factor_solve(linear->factor, b, 1, x, error);
  return conjugate_gradients(linear, b, x, error);
}
