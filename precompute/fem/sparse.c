/* Cholesky factors of sparse symmetric matrices, see sparse.h.
 *
 * The factor is CHOLMOD's supernodal one (Chen, Davis, Hager, Rajamanickam 2008,
 * doi:10.1145/1391989.1391995) in METIS nested dissection order (Karypis, Kumar 1998,
 * doi:10.1137/S1064827595287997), with 64-bit indices: O(n^2) operations and O(n^(4/3)) numbers
 * for a solid of n unknowns.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/sparse.h"

#include <cblas.h>
#include <cholmod.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/threads.h"
#include "precompute/fem/refined_solve.h"
#include "precompute/fem/single_factor.h"

_Static_assert(sizeof(SuiteSparse_long) == sizeof(int64_t), "CHOLMOD's long has 64 bits");

struct thrum_factor {
  cholmod_common common;
  cholmod_factor *factor;
  /* kept between solves, so that a solve of the same width allocates nothing */
  cholmod_dense *solution, *work_a, *work_b;
  int64_t deflated; /* columns of vectors and dual */
  const double *vectors, *dual;
  double factor_flops;
  int64_t solved; /* columns */
  /* in single precision: the numbers, and the matrix whose solutions they lead to */
  const thrum_sparse *matrix; /* NULL: in double precision */
  thrum_single_factor *single;
  const thrum_ranks *ranks; /* whose solver takes the place of a factor; NULL: none */
  int64_t size;
};

// CHOLMOD's status as ours
static thrum_status report(const cholmod_common *common, thrum_error *error) {
  switch (common->status) {
  case CHOLMOD_OK:
    return THRUM_OK;

  case CHOLMOD_OUT_OF_MEMORY:
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "no memory for the sparse Cholesky factor: use a coarser mesh");
  case CHOLMOD_TOO_LARGE:
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                           "the sparse Cholesky factor is too large: use a coarser mesh");

  // a pivot that is not positive is the matrix's fault, not the solver's
  case CHOLMOD_NOT_POSDEF:
    return thrum_error_set(error, THRUM_SINGULAR, "the matrix is not positive definite");

  default:
    return thrum_error_set(error, THRUM_SINGULAR, "the sparse Cholesky factor failed (status %d)",
                           common->status);
  }
}

// our matrix in CHOLMOD's clothes; nothing is copied
static cholmod_sparse view(const thrum_sparse *matrix) {
  cholmod_sparse sparse = {0};
  sparse.nrow = (size_t)matrix->size;
  sparse.ncol = (size_t)matrix->size;
  sparse.nzmax = (size_t)matrix->begin[matrix->size];
  sparse.p = matrix->begin;
  sparse.i = matrix->row;
  sparse.x = matrix->value;
  sparse.stype = -1;
  sparse.itype = CHOLMOD_LONG;
  sparse.xtype = CHOLMOD_REAL;
  sparse.dtype = CHOLMOD_DOUBLE;
  sparse.sorted = true;
  sparse.packed = true;
  return sparse;
}

// CHOLMOD does not look at what METIS returns, which may be no order where METIS ran out of memory
static thrum_status check_order(const cholmod_factor *factor, thrum_error *error) {
  const int64_t *order = factor->Perm;
  bool *seen = NULL;
  THRUM_TRY(thrum_reserve(&seen, (int64_t)factor->n, sizeof *seen, "a sparse factor", error));
  bool whole = order != NULL;
  for (size_t i = 0; whole && i < factor->n; i++) {
    whole = order[i] >= 0 && (size_t)order[i] < factor->n && !seen[order[i]];
    if (whole)
      seen[order[i]] = true;
  }
  free(seen);
  return whole ? THRUM_OK
               : thrum_error_set(error, THRUM_OUT_OF_MEMORY,
                                 "no memory for the order of the sparse factor");
}

thrum_status thrum_factor_plan(const thrum_sparse *matrix, thrum_factor **factor,
                               thrum_error *error) {
  THRUM_TRY(thrum_threads_ready(1, error));

  thrum_factor *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "a sparse factor", error));

  // a supernodal Cholesky factor in the order of METIS alone, so that every run has the same
  cholmod_common *common = &made->common;
  cholmod_l_start(common);
  common->print = 0;
  common->supernodal = CHOLMOD_SUPERNODAL;
  common->nmethods = 1;
  common->method[0].ordering = CHOLMOD_METIS;
  common->postorder = true;
  common->quick_return_if_not_posdef = true;

  // the factor's pattern, its flops and its memory
  cholmod_sparse sparse = view(matrix);
  made->factor = cholmod_l_analyze(&sparse, common);
  made->factor_flops = common->fl;
  made->size = matrix->size;

  thrum_status status = report(common, error);
  THRUM_THEN(status, check_order(made->factor, error));
  if (status < 0) {
    thrum_factor_free(made);
    return status;
  }
  *factor = made;
  return THRUM_OK;
}

// the pattern of L that CHOLMOD planned
static thrum_supernodes supernodes(const thrum_factor *factor) {
  const cholmod_factor *planned = factor->factor;
  return (thrum_supernodes){.size = (int64_t)planned->n,
                            .count = (int64_t)planned->nsuper,
                            .first = planned->super,
                            .begin = planned->pi,
                            .row = planned->s,
                            .order = planned->Perm};
}

void thrum_factor_set_single(thrum_factor *factor, const thrum_sparse *matrix) {
  factor->matrix = matrix;
}

bool thrum_factor_is_single(const thrum_factor *factor) {
  return factor->matrix != NULL;
}

thrum_status thrum_factor_compute(const thrum_sparse *matrix, thrum_factor *factor,
                                  thrum_error *error) {
  if (factor->matrix) {
    const thrum_supernodes pattern = supernodes(factor);
    return thrum_single_factor_create(&pattern, matrix, &factor->single, error);
  }
  cholmod_sparse sparse = view(matrix);
  cholmod_l_factorize(&sparse, factor->factor, &factor->common);
  return report(&factor->common, error);
}

thrum_status thrum_factor_create(const thrum_sparse *matrix, thrum_factor **factor,
                                 thrum_error *error) {
  thrum_factor *made = NULL;
  thrum_status status = thrum_factor_plan(matrix, &made, error);
  THRUM_THEN(status, thrum_factor_compute(matrix, made, error));
  if (status >= 0)
    *factor = made;
  else
    thrum_factor_free(made);
  return status;
}

thrum_status thrum_factor_share(const thrum_ranks *ranks, int64_t size, thrum_factor **factor,
                                thrum_error *error) {
  thrum_factor *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "a sparse factor", error));
  cholmod_l_start(&made->common);
  made->ranks = ranks;
  made->size = size;
  *factor = made;
  return THRUM_OK;
}

void thrum_factor_deflate(thrum_factor *factor, int64_t count, const double *vectors,
                          const double *dual) {
  factor->deflated = count;
  factor->vectors = vectors;
  factor->dual = dual;
}

int64_t thrum_factor_deflated(const thrum_factor *factor) {
  return factor->deflated;
}

const double *thrum_factor_vectors(const thrum_factor *factor) {
  return factor->vectors;
}

// x -= along (against^T x), column by column
static void take_out(const thrum_factor *factor, const double *against, const double *along,
                     int64_t columns, double *x) {
  const int n = (int)factor->size;
  for (int64_t c = 0; c < columns; c++)
    for (int64_t i = 0; i < factor->deflated; i++) {
      double share = cblas_ddot(n, against + i * n, 1, x + c * n, 1);
      thrum_ranks_sum(factor->ranks, &share, 1);
      cblas_daxpy(n, -share, along + i * n, 1, x + c * n, 1);
    }
}

// solution = A^-1 right by the factor in double precision
static thrum_status solve_double(thrum_factor *factor, const double *right, int64_t columns,
                                 double *solution, thrum_error *error) {
  cholmod_common *common = &factor->common;
  const size_t n = factor->factor->n;

  // CHOLMOD's description of the right-hand sides
  cholmod_dense dense = {0};
  dense.nrow = n;
  dense.ncol = (size_t)columns;
  dense.nzmax = n * (size_t)columns;
  dense.d = n;

  // CHOLMOD's type is not const-correct; it only reads a right-hand side
  union {
    const double *read;
    void *any;
  } values = {.read = right};
  dense.x = values.any;
  dense.xtype = CHOLMOD_REAL;
  dense.dtype = CHOLMOD_DOUBLE;

  // the solution stays in CHOLMOD's memory, which is used again
  cholmod_l_solve2(CHOLMOD_A, factor->factor, &dense, NULL, &factor->solution, NULL,
                   &factor->work_a, &factor->work_b, common);
  THRUM_TRY(report(common, error));
  memcpy(solution, factor->solution->x, sizeof(double) * dense.nzmax);
  factor->solved += columns;
  return THRUM_OK;
}

// a solve, exact or, in single precision, as the factor alone gives it
static thrum_status solve(thrum_factor *factor, bool exact, const double *right, int64_t columns,
                          double *solution, thrum_error *error) {
  // the part in the deflated space is taken out before and after
  if (factor->deflated > 0) {
    memmove(solution, right, sizeof *right * (size_t)(factor->size * columns));
    take_out(factor, factor->vectors, factor->dual, columns, solution);
    right = solution;
  }

  if (factor->ranks) {
    THRUM_TRY(factor->ranks->solve(factor->ranks->context, exact, right, columns, solution, error));
    factor->solved += columns;
  } else if (!factor->single)
    THRUM_TRY(solve_double(factor, right, columns, solution, error));
  else if (exact)
    THRUM_TRY(thrum_refined_solve(factor->matrix, factor->single, right, columns, solution,
                                  &factor->solved, error));
  else {
    THRUM_TRY(thrum_single_factor_solve(factor->single, right, columns, solution, error));
    factor->solved += columns;
  }

  take_out(factor, factor->dual, factor->vectors, columns, solution);
  return THRUM_OK;
}

thrum_status thrum_factor_solve(thrum_factor *factor, const double *right, int64_t columns,
                                double *solution, thrum_error *error) {
  return solve(factor, true, right, columns, solution, error);
}

thrum_status thrum_factor_solve_roughly(thrum_factor *factor, const double *right, int64_t columns,
                                        double *solution, thrum_error *error) {
  return solve(factor, false, right, columns, solution, error);
}

int64_t thrum_factor_nonzeros(const thrum_factor *factor) {
  if (factor->ranks)
    return (int64_t)factor->ranks->solver_use(factor->ranks->context).nonzeros;
  return (int64_t)factor->factor->xsize;
}

double thrum_factor_flops(const thrum_factor *factor) {
  return factor->factor_flops;
}

double thrum_factor_solve_flops(const thrum_factor *factor) {
  return 4 * (double)thrum_factor_nonzeros(factor) * (double)factor->solved;
}

double thrum_factor_bytes(const thrum_factor *factor) {
  const thrum_supernodes pattern = supernodes(factor);
  const double numbers = factor->matrix ? 0.5 * (double)thrum_single_factor_entries(&pattern)
                                        : (double)factor->factor->xsize;
  return 8 * (numbers + (double)factor->factor->ssize + 3 * (double)factor->factor->n);
}

double thrum_factor_work_bytes(const thrum_factor *factor) {
  return 8 * ((double)factor->factor->maxcsize + 3 * (double)factor->factor->n);
}

void thrum_factor_free(thrum_factor *factor) {
  if (!factor)
    return;
  cholmod_l_free_dense(&factor->solution, &factor->common);
  cholmod_l_free_dense(&factor->work_a, &factor->common);
  cholmod_l_free_dense(&factor->work_b, &factor->common);
  thrum_single_factor_free(factor->single);
  cholmod_l_free_factor(&factor->factor, &factor->common);
  cholmod_l_finish(&factor->common);
  free(factor);
}
