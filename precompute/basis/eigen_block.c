/* The lowest eigenpairs where the factor is in single precision, see eigen.h: Davidson's method in
 * blocks (Davidson 1975, doi:10.1016/0021-9991(75)90065-0; Morgan, Scott 1986,
 * doi:10.1137/0907054). A space grows by t = A r, A the factor's rough K^-1 and r = K x - s M x the
 * residuals of the best vectors that it holds, which are computed in double precision. So the
 * factor decides how fast the space gets good and not how good; with an exact factor this is block
 * Lanczos on K^-1 M. A solve for many columns costs little more than for one, so blocks are wide.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/fem/lapack_status.h"

#define SPARE 4         /* vectors beside those that are asked for */
#define BLOCKS 4        /* in the space at most; half of them stay when it starts again */
#define TOLERANCE 1e-10 /* of the error of a vector in the norm of K, before the last step */
#define STEPS_MAX 300
#define ROW_BLOCK 256

typedef struct davidson {
  const thrum_sparse *stiffness, *mass;
  thrum_factor *factor;
  int64_t n, count, width; /* width: of a block */
  int64_t most;            /* directions that there are, in all processes */
  int64_t room, dim;       /* columns of the space: at most, and now */
  int64_t active;          /* columns of the block: corrections of vectors that are not right yet */
  double *space;           /* n x room, M-orthonormal */
  double *image;           /* n x room, K times the space */
  double *weighed;         /* n x width, M times a block */
  double *products;        /* n x THRUM_PRODUCT_WORK */
  double *reduced;         /* room x room, space^T K space, upper triangle */
  double *vectors;         /* room x room, its eigenvectors */
  double *values;          /* room */
  double *gram;            /* room x room */
  double *errors;          /* width: of the vectors, in the norm of K */
  int64_t *which;          /* active: the vector of each column */
  thrum_scope memory;
} davidson;

static thrum_status davidson_allocate(davidson *d, thrum_error *error) {
  d->memory = thrum_scope_begin("the modes", error);
  d->space = thrum_scope_allocate(&d->memory, d->n * d->room, sizeof(double));
  d->image = thrum_scope_allocate(&d->memory, d->n * d->room, sizeof(double));
  d->weighed = thrum_scope_allocate(&d->memory, d->n * d->width, sizeof(double));
  d->products = thrum_scope_allocate(&d->memory, d->n * THRUM_PRODUCT_WORK, sizeof(double));
  d->reduced = thrum_scope_allocate(&d->memory, d->room * d->room, sizeof(double));
  d->vectors = thrum_scope_allocate(&d->memory, d->room * d->room, sizeof(double));
  d->values = thrum_scope_allocate(&d->memory, d->room, sizeof(double));
  d->gram = thrum_scope_allocate(&d->memory, d->room * d->room, sizeof(double));
  d->errors = thrum_scope_allocate(&d->memory, d->width, sizeof(double));
  d->which = thrum_scope_allocate(&d->memory, d->width, sizeof *d->which);
  return d->memory.status;
}

// fixed vectors without structure, one pass of the factor smoother
static thrum_status start(davidson *d, thrum_error *error) {
  uint64_t state = 0x9e3779b97f4a7c15u;
  for (int64_t i = 0; i < d->n * d->width; i++) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    d->image[i] = (double)(state >> 11) / 9007199254740992.0 - 0.5;
  }
  for (int64_t c = 0; c < d->width; c++)
    d->errors[c] = INFINITY;
  d->active = d->width;
  thrum_sparse_product_in(d->mass, d->image, d->width, d->space, d->products);
  return thrum_factor_solve_roughly(d->factor, d->space, d->width, d->space, error);
}

// the product of a force and a displacement, to which all parts add their terms
static double dot(const davidson *d, const double *force, const double *displacement) {
  double product = cblas_ddot((int)d->n, force, 1, displacement, 1);
  thrum_ranks_sum(d->mass->ranks, &product, 1);
  return product;
}

// the block becomes orthogonal to the space
static void project(davidson *d, double *block) {
  const int n = (int)d->n, dim = (int)d->dim, width = (int)d->active;
  if (dim == 0)
    return;
  thrum_sparse_product_in(d->mass, block, d->active, d->weighed, d->products);
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, dim, width, n, 1, d->space, n, d->weighed, n,
              0, d->gram, dim);
  thrum_ranks_sum(d->mass->ranks, d->gram, d->dim * d->active);
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, width, dim, -1, d->space, n, d->gram,
              dim, 1, block, n);
}

// the block becomes orthonormal, by a Cholesky factor of its Gram matrix, and M times it follows;
// columns that depend on others leave it, and *kept says how many stay
static void orthonormalise(davidson *d, double *block, double least, int64_t *kept) {
  const int n = (int)d->n;
  double *weighed = d->weighed;
  thrum_sparse_product_in(d->mass, block, *kept, weighed, d->products);

  // column by column of the factor, so that what depends on earlier columns is seen
  int64_t done = 0;
  for (int64_t c = 0; c < *kept; c++) {
    double *column = block + c * d->n, *image = weighed + c * d->n;
    const double before = sqrt(fmax(dot(d, column, image), 0));

    // the columns that are done are projected out of the column and of M times it
    if (done > 0) {
      cblas_dgemv(CblasColMajor, CblasTrans, n, (int)done, 1, weighed, n, column, 1, 0, d->gram, 1);
      thrum_ranks_sum(d->mass->ranks, d->gram, done);
      cblas_dgemv(CblasColMajor, CblasNoTrans, n, (int)done, -1, block, n, d->gram, 1, 1, column,
                  1);
      cblas_dgemv(CblasColMajor, CblasNoTrans, n, (int)done, -1, weighed, n, d->gram, 1, 1, image,
                  1);
    }

    // a column of which next to nothing is left depends on those before it
    const double length = sqrt(fmax(dot(d, column, image), 0));
    if (!(length > least * before))
      continue;
    for (int64_t i = 0; i < d->n; i++) {
      block[done * d->n + i] = column[i] / length;
      weighed[done * d->n + i] = image[i] / length;
    }
    done++;
  }
  *kept = done;
}

// takes the block behind the space into it; *grown: how many directions were new
static void grow(davidson *d, int64_t *grown) {
  double *block = d->space + d->dim * d->n;

  // a space that is as large as that of the whole body has no more directions, but rounding
  if (d->active > d->most - d->dim)
    d->active = d->most - d->dim;
  *grown = d->active;
  if (d->active == 0)
    return;

  // twice, as what is left of a correction is small beside it; the second time nothing is lost
  project(d, block);
  orthonormalise(d, block, 1e-10, grown);
  project(d, block);
  orthonormalise(d, block, 1e-3, grown);

  // their images, and their part of the reduced stiffness
  thrum_sparse_product_in(d->stiffness, block, *grown, d->image + d->dim * d->n, d->products);
  const int all = (int)(d->dim + *grown), n = (int)d->n;
  memset(d->reduced + d->dim * d->room, 0, sizeof(double) * (size_t)(*grown * d->room));
  cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, all, (int)*grown, n, 1, d->space, n,
              d->image + d->dim * d->n, n, 0, d->reduced + d->dim * d->room, (int)d->room);
  thrum_ranks_sum(d->stiffness->ranks, d->reduced + d->dim * d->room, *grown * d->room);
  d->dim = all;
}

// eigenpairs of the reduced stiffness
static thrum_status reduce(davidson *d, thrum_error *error) {
  for (int64_t c = 0; c < d->dim; c++)
    memcpy(d->vectors + c * d->room, d->reduced + c * d->room, sizeof(double) * (size_t)d->dim);
  return thrum_lapack_status(
      LAPACKE_dsyevd(LAPACK_COL_MAJOR, 'V', 'U', (int)d->dim, d->vectors, (int)d->room, d->values),
      THRUM_NOT_CONVERGED, "the modes did not converge", error);
}

// columns of `from` become their first `kept` combinations, in place
static void turn(const davidson *d, int64_t kept, double *rows, double *from) {
  for (int64_t first = 0; first < d->n; first += ROW_BLOCK) {
    const int64_t height = d->n - first < ROW_BLOCK ? d->n - first : ROW_BLOCK;
    for (int64_t c = 0; c < d->dim; c++)
      memcpy(rows + c * ROW_BLOCK, from + c * d->n + first, sizeof *rows * (size_t)height);
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)height, (int)kept, (int)d->dim, 1,
                rows, ROW_BLOCK, d->vectors, (int)d->room, 0, from + first, (int)d->n);
  }
}

// the space becomes that of its lowest `kept` eigenvectors
static thrum_status shrink(davidson *d, int64_t kept, thrum_error *error) {
  double *rows = NULL;
  THRUM_TRY(thrum_reserve(&rows, ROW_BLOCK * d->room, sizeof *rows, "the modes", error));
  turn(d, kept, rows, d->space);
  turn(d, kept, rows, d->image);
  free(rows);

  // where the reduced stiffness is diagonal
  for (int64_t c = 0; c < kept; c++) {
    memset(d->reduced + c * d->room, 0, sizeof(double) * (size_t)kept);
    d->reduced[c * d->room + c] = d->values[c];
  }
  d->dim = kept;
  return THRUM_OK;
}

// corrections of the lowest vectors, behind the space; *worst: the largest error of those asked for
static thrum_status correct(davidson *d, double *worst, thrum_error *error) {
  const int n = (int)d->n, dim = (int)d->dim, room = (int)d->room;
  double *block = d->space + d->dim * d->n, *residual = d->image + d->dim * d->n;

  // vectors that are not right yet are corrected; their columns are brought together
  d->active = 0;
  for (int64_t c = 0; c < d->width; c++)
    if (d->errors[c] > 0.1 * TOLERANCE) {
      memcpy(d->gram + d->active * d->room, d->vectors + c * d->room,
             sizeof(double) * (size_t)d->dim);
      d->which[d->active++] = c;
    }

  // residuals K x - s M x
  const int active = (int)d->active;
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, active, dim, 1, d->image, n, d->gram,
              room, 0, residual, n);
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, active, dim, 1, d->space, n, d->gram,
              room, 0, block, n);
  thrum_sparse_product_in(d->mass, block, d->active, d->weighed, d->products);
  for (int64_t c = 0; c < d->active; c++)
    cblas_daxpy(n, -d->values[d->which[c]], d->weighed + c * d->n, 1, residual + c * d->n, 1);

  // r.t is the square of the error in the norm of K, where a vector has the square s
  THRUM_TRY(thrum_factor_solve_roughly(d->factor, residual, d->active, block, error));
  for (int64_t c = 0; c < d->active; c++) {
    const double square = dot(d, residual + c * d->n, block + c * d->n);
    d->errors[d->which[c]] = sqrt(fmax(square, 0) / d->values[d->which[c]]);
  }
  *worst = 0;
  for (int64_t c = 0; c < d->count; c++)
    *worst = fmax(*worst, d->errors[c]);
  return THRUM_OK;
}

static thrum_status iterate(davidson *d, const thrum_reporter *reporter, thrum_error *error) {
  double worst = 1;
  int64_t grown;
  THRUM_TRY(start(d, error));
  grow(d, &grown);

  // one step follows the one that was good enough, and makes the vectors better still
  for (int step = 0; step < STEPS_MAX; step++) {
    THRUM_TRY(reduce(d, error));
    if (worst <= TOLERANCE || grown == 0)
      return shrink(d, d->count, error);

    // a space that is full starts again from its best half, of which the vectors are the columns
    if (d->dim + d->width > d->room) {
      THRUM_TRY(shrink(d, BLOCKS / 2 * d->width, error));
      THRUM_TRY(reduce(d, error));
    }
    THRUM_TRY(correct(d, &worst, error));
    grow(d, &grown);
    THRUM_TRY(thrum_report(reporter, fmin(1, log(fmax(worst, TOLERANCE)) / log(TOLERANCE)), error));
  }
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "the %lld modes did not converge in %d steps: check the material, the "
                         "scale and the quality of the mesh, or lower --modes",
                         (long long)d->count, STEPS_MAX);
}

thrum_status thrum_eigen_lowest_block(const thrum_sparse *stiffness, const thrum_sparse *mass,
                                      thrum_factor *factor, int64_t count, double *values,
                                      double *vectors, const thrum_reporter *reporter,
                                      thrum_error *error) {
  const int64_t most = thrum_ranks_size(mass->ranks, mass->size) - thrum_factor_deflated(factor);
  davidson d = {.stiffness = stiffness,
                .mass = mass,
                .factor = factor,
                .n = mass->size,
                .count = count,
                .most = most,
                .width = count + SPARE < most ? count + SPARE : most};
  d.room = BLOCKS * d.width;

  thrum_status status = davidson_allocate(&d, error);
  THRUM_THEN(status, iterate(&d, reporter, error));
  if (status >= 0) {
    memcpy(vectors, d.space, sizeof *vectors * (size_t)(d.n * count));
    memcpy(values, d.values, sizeof *values * (size_t)count);
  }
  thrum_scope_free(&d.memory);
  return status;
}
