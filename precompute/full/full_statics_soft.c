/* The modes of least stiffness of a body at an equilibrium, K x = lambda M x: inverse iteration of
 * a few vectors at a time with factors that the search has already, and Rayleigh's quotients. Where
 * K is not positive definite, K + shift M is, from a shift on that is found by trial, and the
 * eigenvalues are those less the shift. Several vectors, since square columns have two modes of one
 * eigenvalue.
 *
 * Cost: three solves an iteration, about ten iterations far from a critical load and two near one.
 * Source: Bathe & Wilson 1976, Numerical methods in finite element analysis, chapter 12 (ISBN
 * 978-0-13-627190-1).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/fem/lapack_status.h"
#include "precompute/full/full_statics.h"

#define VECTORS 3
#define ITERATIONS_MAX 60
#define SHIFT_FIRST 1e-3 /* of the softest stiffness at rest */
#define SHIFT_LAST 1e9

thrum_status full_soft_make(const thrum_full *full, full_soft *soft, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  full_soft made = {.count = n < VECTORS ? (int)n : VECTORS};
  THRUM_TRY(thrum_reserve(&made.memory, 2 * made.count * n, sizeof *made.memory,
                          "the softest modes", error));
  made.vectors = made.memory;
  made.next = made.memory + made.count * n;

  // any start with a share of every mode will do, as long as it is the same each time
  uint64_t random = 1;
  for (int64_t i = 0; i < made.count * n; i++) {
    random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    made.vectors[i] = (double)(random >> 11) * 0x1p-53 - 0.5;
  }
  *soft = made;
  return THRUM_OK;
}

void full_soft_free(full_soft *soft) {
  free(soft->memory);
  *soft = (full_soft){0};
}

/* Makes the vectors orthonormal in M, one after the other and twice, against rounding. */
static void orthonormalise(thrum_full *full, int count, double *vectors) {
  const int64_t n = full->body.fem.free_count;
  for (int k = 0; k < 2 * count; k++) {
    double *x = vectors + k / 2 * n;
    for (int j = 0; j < k / 2; j++) {
      thrum_sparse_product(&full->body.mass, vectors + j * n, 1, full->product);
      const double share = full_dot(full, full->product, x);
      for (int64_t i = 0; i < n; i++)
        x[i] -= share * vectors[j * n + i];
    }
    thrum_sparse_product(&full->body.mass, x, 1, full->product);
    const double length = sqrt(full_dot(full, full->product, x));
    for (int64_t i = 0; i < n && length > 0; i++)
      x[i] /= length;
  }
}

/* Turns orthonormal vectors so that the tangent is diagonal in them; the least eigenvalue. */
static thrum_status turn(thrum_full *full, full_soft *soft, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  const int count = soft->count;
  double small[VECTORS * VECTORS], values[VECTORS];
  for (int j = 0; j < count; j++) {
    thrum_sparse_product(&full->tangent, soft->vectors + j * n, 1, full->product);
    for (int i = 0; i < count; i++)
      small[j * count + i] = full_dot(full, full->product, soft->vectors + i * n);
  }
  THRUM_TRY(thrum_lapack_status(
      LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', count, small, count, values), THRUM_NOT_CONVERGED,
      "the softest modes of the tangent were not found", error));

  // each new vector is a sum of the old ones
  for (int j = 0; j < count; j++)
    for (int64_t i = 0; i < n; i++) {
      double sum = 0;
      for (int k = 0; k < count; k++)
        sum += small[j * count + k] * soft->vectors[k * n + i];
      soft->next[j * n + i] = sum;
    }
  memcpy(soft->vectors, soft->next, (size_t)(count * n) * sizeof *soft->next);
  soft->least = values[0];
  return isfinite(values[0]) ? THRUM_OK
                             : thrum_error_set(error, THRUM_NOT_FINITE,
                                               "the softest modes of the tangent are not finite");
}

/* Inverse iteration with the prepared system, K + shift M. */
static thrum_status iterate(thrum_full *full, full_soft *soft, double shift, double scale,
                            double tolerance, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  double last = INFINITY;
  for (int k = 0; k < ITERATIONS_MAX; k++) {
    for (int j = 0; j < soft->count; j++) {
      thrum_sparse_product(&full->body.mass, soft->vectors + j * n, 1, full->product);
      THRUM_TRY(full_linear_solve(&full->linear, full->product, soft->next + j * n, error));
    }
    memcpy(soft->vectors, soft->next, (size_t)(soft->count * n) * sizeof *soft->next);
    orthonormalise(full, soft->count, soft->vectors);
    THRUM_TRY(turn(full, soft, error));

    // far below the stiffness at rest, digits of the eigenvalue are those of rounding
    const double size = fmax(fabs(soft->least + shift), 1e-6 * scale);
    if (fabs(soft->least - last) <= tolerance * size)
      return THRUM_OK;
    last = soft->least;
  }
  return THRUM_OK;
}

/* The stiffness at rest of the softest vector, which sets the scale of shifts. */
static double scale_of(thrum_full *full, full_soft *soft) {
  orthonormalise(full, soft->count, soft->vectors);
  thrum_sparse_product(&full->body.stiffness, soft->vectors, 1, full->product);
  const double rest = full_dot(full, full->product, soft->vectors);
  return rest > 0 && isfinite(rest) ? rest : 1;
}

thrum_status full_soft_look(thrum_full *full, full_soft *soft, bool ready, double tolerance,
                            thrum_error *error) {
  const double scale = scale_of(full, soft);
  thrum_status status = THRUM_SINGULAR;
  if (ready)
    status = iterate(full, soft, 0, scale, tolerance, error);

  // where the tangent is not positive definite, a shift by some of the mass makes it so
  double shift = ready ? SHIFT_FIRST * scale : 0;
  while (status == THRUM_SINGULAR && shift < SHIFT_LAST * scale) {
    status = full_assemble(full, full->place, 1, shift, 0, error);
    THRUM_THEN(status, full_linear_prepare(&full->linear, error));
    THRUM_THEN(status, iterate(full, soft, shift, scale, tolerance, error));
    shift = shift > 0 ? 10 * shift : SHIFT_FIRST * scale;
  }
  return status;
}
