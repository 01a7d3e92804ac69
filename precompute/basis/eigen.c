/* The lowest eigenpairs of K psi = omega^2 M psi by ARPACK, design 2: implicitly restarted Lanczos
 * on K^-1 M in the M inner product (shift-invert at 0), after Lehoucq, Sorensen, Yang 1998,
 * doi:10.1137/1.9780898719628. It stops at 1e-10, which takes about 2 to 3 times `count` solves
 * where rounding level takes three times that; two steps of subspace iteration, whose solves are
 * blocked and so nearly free, reach rounding level afterwards.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/eigen.h"

#include <arpack.h>
#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"

#define LANCZOS_TOLERANCE 1e-10
#define REFINEMENTS 2

typedef struct lanczos {
  int n, count, vectors; /* vectors: Lanczos vectors kept (ncv) */
  int ido, info;
  int iparam[11], ipntr[14];
  double *resid, *basis, *workd, *workl, *values;
  int *select;
  thrum_scope memory;
} lanczos;

static thrum_status lanczos_allocate(lanczos *l, thrum_error *error) {
  const int64_t n = l->n, v = l->vectors;
  l->memory = thrum_scope_begin("the modes", error);
  l->resid = thrum_scope_allocate(&l->memory, n, sizeof(double));
  l->basis = thrum_scope_allocate(&l->memory, n * v, sizeof(double));
  l->workd = thrum_scope_allocate(&l->memory, 3 * n, sizeof(double));
  l->workl = thrum_scope_allocate(&l->memory, v * (v + 8), sizeof(double));
  l->values = thrum_scope_allocate(&l->memory, v, sizeof(double));
  l->select = thrum_scope_allocate(&l->memory, v, sizeof(int));
  return l->memory.status;
}

// a fixed start vector without structure: equal input, equal modes
static void start_vector(int n, double *resid) {
  uint64_t state = 0x9e3779b97f4a7c15u;
  for (int i = 0; i < n; i++) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    resid[i] = (double)(state >> 11) / 9007199254740992.0 - 0.5;
  }
}

// also where the numbers of the matrices are too large or too small to be multiplied
static thrum_status not_converged(const lanczos *l, thrum_error *error) {
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "the %d modes did not converge (ARPACK code %d): check the material, the "
                         "scale and the quality of the mesh, or lower --modes",
                         l->count, l->info);
}

static thrum_status lanczos_iterate(lanczos *l, const thrum_sparse *mass, thrum_factor *factor,
                                    const thrum_reporter *reporter, thrum_error *error) {
  int64_t solves = 0;
  thrum_status status = THRUM_OK;

  // ARPACK says what it needs next, until it is done
  while (status >= 0) {
    dsaupd_c(&l->ido, "G", l->n, "LM", l->count, LANCZOS_TOLERANCE, l->resid, l->vectors, l->basis,
             l->n, l->iparam, l->ipntr, l->workd, l->workl, l->vectors * (l->vectors + 8),
             &l->info);
    double *in = l->workd + l->ipntr[0] - 1, *out = l->workd + l->ipntr[1] - 1;
    if (l->ido == -1) {
      // out = K^-1 M in
      thrum_sparse_product(mass, in, 1, out);
      status = thrum_factor_solve(factor, out, 1, out, error);
    } else if (l->ido == 1) {
      // M in is there already
      status = thrum_factor_solve(factor, l->workd + l->ipntr[2] - 1, 1, out, error);
    } else if (l->ido == 2) {
      thrum_sparse_product(mass, in, 1, out);
      continue;
    } else {
      break;
    }

    // the count of solves is not known beforehand: creep towards 1
    solves++;
    THRUM_THEN(status,
               thrum_report(reporter, 1 - exp(-(double)solves / (1.5 * l->vectors)), error));
  }

  // an end is no success yet
  if (status >= 0 && l->info != 0)
    status = not_converged(l, error);
  return status;
}

static thrum_status lanczos_extract(lanczos *l, double *values, double *vectors,
                                    thrum_error *error) {
  // ARPACK makes the vectors from its basis
  dseupd_c(1, "A", l->select, l->values, l->basis, l->n, 0.0, "G", l->n, "LM", l->count,
           LANCZOS_TOLERANCE, l->resid, l->vectors, l->basis, l->n, l->iparam, l->ipntr, l->workd,
           l->workl, l->vectors * (l->vectors + 8), &l->info);
  if (l->info != 0 || l->iparam[4] < l->count)
    return not_converged(l, error);

  // ascending, by selection; the vectors follow
  for (int i = 0; i < l->count; i++) {
    int lowest = 0;
    for (int j = 1; j < l->count; j++)
      if (l->values[j] < l->values[lowest])
        lowest = j;
    values[i] = l->values[lowest];
    memcpy(vectors + (int64_t)i * l->n, l->basis + (int64_t)lowest * l->n,
           sizeof(double) * (size_t)l->n);
    l->values[lowest] = INFINITY;
  }
  return THRUM_OK;
}

// one step of subspace iteration: Y = K^-1 M Psi, then Rayleigh-Ritz on Y with Y^T K Y = Y^T M Psi
static thrum_status refine(const thrum_sparse *mass, thrum_factor *factor, int64_t count,
                           double *values, double *vectors, double *y, double *small,
                           thrum_error *error) {
  const int64_t n = mass->size;
  const int rows = (int)n, k = (int)count;
  double *stiff = small, *weigh = small + count * count;

  // the right-hand sides M Psi
  thrum_sparse_product(mass, vectors, count, y);

  // columns scaled by omega^2 stay of unit size, which keeps the small problem well scaled
  for (int64_t i = 0; i < count; i++)
    cblas_dscal(rows, values[i], y + i * n, 1);
  memcpy(vectors, y, sizeof *y * (size_t)(n * count));

  // Y = K^-1 M Psi, in blocks that the factor solves at once
  for (int64_t first = 0; first < count; first += THRUM_SOLVE_BLOCK) {
    const int64_t width = count - first < THRUM_SOLVE_BLOCK ? count - first : THRUM_SOLVE_BLOCK;
    THRUM_TRY(thrum_factor_solve(factor, y + first * n, width, y + first * n, error));
  }

  // Y^T K Y = Y^T M Psi and Y^T M Y are the small problem
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k, k, rows, 1, y, rows, vectors, rows, 0,
              stiff, k);
  thrum_sparse_product(mass, y, count, vectors);
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, k, k, rows, 1, y, rows, vectors, rows, 0,
              weigh, k);
  thrum_ranks_sum(mass->ranks, small, 2 * count * count);

  // the eigenvectors of the small problem give the modes
  THRUM_TRY(thrum_lapack_status(
      LAPACKE_dsygvd(LAPACK_COL_MAJOR, 1, 'V', 'U', k, stiff, k, weigh, k, values),
      THRUM_NOT_CONVERGED, "the modes could not be refined", error));
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rows, k, k, 1, y, rows, stiff, k, 0,
              vectors, rows);
  return THRUM_OK;
}

thrum_status thrum_eigen_refine(const thrum_sparse *mass, thrum_factor *factor, int64_t count,
                                int passes, double *values, double *vectors, thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the modes", error);
  double *y = thrum_scope_allocate(&memory, mass->size * count, sizeof *y);
  double *small = thrum_scope_allocate(&memory, 2 * count * count, sizeof *small);
  thrum_status status = memory.status;
  for (int pass = 0; pass < passes && status >= 0; pass++)
    status = refine(mass, factor, count, values, vectors, y, small, error);
  thrum_scope_free(&memory);
  return status;
}

thrum_status thrum_eigen_lowest(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                thrum_factor *factor, int64_t count, double *values,
                                double *vectors, const thrum_reporter *reporter,
                                thrum_error *error) {
  const thrum_ranks *ranks = stiffness->ranks;
  const int64_t n = stiffness->size,
                own = thrum_ranks_size(ranks, n) - thrum_factor_deflated(factor);
  if (count < 1 || count >= own || n > INT32_MAX / 3)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld modes of %lld free components: there must be fewer modes",
                           (long long)count, (long long)own);

  // several processes have an eigensolver of their own, whose pairs are refined alike
  if (ranks && !ranks->rough(ranks->context)) {
    const double *rigid = thrum_factor_deflated(factor) > 0 ? thrum_factor_vectors(factor) : NULL;
    THRUM_TRY(ranks->lowest(ranks->context, rigid, count, values, vectors, error));
    return thrum_eigen_refine(mass, factor, count, REFINEMENTS, values, vectors, error);
  }

  // rough solves are for a method that makes up for them
  if (ranks || thrum_factor_is_single(factor)) {
    THRUM_TRY(
        thrum_eigen_lowest_block(stiffness, mass, factor, count, values, vectors, reporter, error));
    if (ranks)
      return THRUM_OK;
    thrum_eigen_canonicalise(n, count, values, 1e-10 * values[count - 1], vectors, 1, n);
    return THRUM_OK;
  }

  // a subspace of twice the modes converges in few restarts
  const int64_t wanted = 2 * count + 10;
  lanczos l = {.n = (int)n, .count = (int)count, .vectors = (int)(wanted < own ? wanted : own)};

  // ARPACK's parameters: own start vector, exact shifts, at most 3000 restarts, one vector a block,
  // shift-invert mode
  l.info = 1;
  l.iparam[0] = 1;
  l.iparam[2] = 3000;
  l.iparam[3] = 1;
  l.iparam[6] = 3;

  // Lanczos iteration, from a start vector that is the same in every run
  thrum_status status = lanczos_allocate(&l, error);
  if (status >= 0) {
    start_vector(l.n, l.resid);
    status = lanczos_iterate(&l, mass, factor, reporter, error);
  }
  THRUM_THEN(status, lanczos_extract(&l, values, vectors, error));

  // refined beyond Lanczos, and with a sign and an order that depend on nothing else
  thrum_scope_free(&l.memory);
  THRUM_THEN(status, thrum_eigen_refine(mass, factor, count, REFINEMENTS, values, vectors, error));
  if (status >= 0)
    thrum_eigen_canonicalise(n, count, values, 1e-10 * values[count - 1], vectors, 1, n);
  return status;
}

thrum_status thrum_eigen_residuals(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                   int64_t count, const double *values, const double *vectors,
                                   double *residuals, thrum_error *error) {
  const int64_t n = stiffness->size;
  double *work = NULL;
  THRUM_TRY(thrum_reserve(&work, 2 * n, sizeof *work, "the residuals", error));
  const double norm = thrum_sparse_norm(stiffness, work);
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < count && status >= 0; i++) {
    const double *vector = vectors + i * n;
    thrum_sparse_product(stiffness, vector, 1, work);
    thrum_sparse_product(mass, vector, 1, work + n);
    cblas_daxpy((int)n, -values[i], work + n, 1, work, 1);
    status = thrum_ranks_force_norm(stiffness->ranks, work, n, &residuals[i], error);
    residuals[i] /= norm * thrum_ranks_norm(stiffness->ranks, vector, n);
  }
  free(work);
  return status;
}
