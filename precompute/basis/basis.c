/* The basis U, design 2: mass-PCA of the modes psi_i (w_1^2/w_i^2) and the modal derivatives
 * Phi_ij a (w_1^4/(w_i^2 w_j^2)), a = 0.1 (bounding-box diagonal)/max_x |psi_1(x)|, after Barbic,
 * James 2005, doi:10.1145/1073204.1073300; a makes the basis independent of the unit of length.
 * The singular value decomposition in the mass inner product goes through an accurate mass-QR, so
 * small singular values are right as well. Then U is turned so that U^T K U is diagonal.
 * O(n candidates^2); the candidates become the Q of the mass-QR in their place.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/basis.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "runtime/base/vec3.h"

#define TOLERANCE                                                                                  \
  1e-8 /* what is left of a candidate below this of itself is noise of the solves                  \
        */
#define ROW_BLOCK 256

typedef struct pca {
  const thrum_fem *fem;
  const thrum_sparse *mass;
  int64_t n, modes, count, rank; /* count: candidates */
  int64_t wide;                  /* the larger of candidates and whole rank */
  double length;                 /* a of the file comment */
  const double *responses;       /* response_count columns, and the derivatives that have one of */
  int64_t response_count;        /* them; of the rank before what is trained */
  const double *omega2;          /* modes, then responses */
  const double *trained;         /* trained_count fields, the last of the rank */
  int64_t trained_count;
  const double *shares; /* count, or NULL */
  double *weight;       /* count */
  double *q;            /* n x count: the candidates of unit norm, then orthonormal */
  int32_t *which;       /* count: the candidate of each column of R */
  double *columns;      /* n x (whole rank + response_count), of the basis */
  double *work;         /* n x THRUM_GRAM_WORK */
  double *small;        /* wide x wide */
  double *left;         /* count x count */
  double *values;       /* 2 wide */
  thrum_scope memory;
} pca;

static thrum_status pca_allocate(pca *p, thrum_error *error) {
  p->memory = thrum_scope_begin("the basis", error);
  p->weight = thrum_scope_allocate(&p->memory, p->count, sizeof(double));
  p->which = thrum_scope_allocate(&p->memory, p->count, sizeof *p->which);
  p->work = thrum_scope_allocate(&p->memory, p->n * THRUM_GRAM_WORK, sizeof(double));
  p->small = thrum_scope_allocate(&p->memory, p->wide * p->wide, sizeof(double));
  p->left = thrum_scope_allocate(&p->memory, p->count * p->count, sizeof(double));
  p->values = thrum_scope_allocate(&p->memory, 2 * p->wide, sizeof(double));
  return p->memory.status;
}

// the diagonal of the box around the whole body
static double box_diagonal(const thrum_fem *fem) {
  double corners[6], square = 0;
  thrum_box3(fem->vertices, fem->vertex_count, corners, corners + 3);

  // the least coordinate is the largest of the negative ones
  for (int c = 0; c < 3; c++)
    corners[c] = -corners[c];
  thrum_ranks_largest(fem->ranks, corners, 6);
  for (int c = 0; c < 3; c++)
    square += (corners[3 + c] + corners[c]) * (corners[3 + c] + corners[c]);
  return sqrt(square);
}

// a of the file comment: what makes a derivative comparable to a mode
static double length_factor(const thrum_fem *fem, const double *first_mode) {
  double largest = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    double square = 0;
    for (int c = 0; c < 3; c++) {
      const int32_t dof = fem->dof[3 * v + c];
      square += dof < 0 ? 0 : first_mode[dof] * first_mode[dof];
    }
    largest = fmax(largest, sqrt(square));
  }
  thrum_ranks_largest(fem->ranks, &largest, 1);
  return 0.1 * box_diagonal(fem) / largest;
}

static void set_weights(pca *p, const double *omega2) {
  const double a = p->length;
  int64_t next = p->modes;
  for (int64_t i = 0; i < p->modes; i++) {
    p->weight[i] = omega2[0] / omega2[i];
    for (int64_t j = i; j < p->modes; j++)
      p->weight[next++] = a * (omega2[0] / omega2[i]) * (omega2[0] / omega2[j]);
  }
}

// candidates of unit mass norm; derivatives that vanish against the others become zero
static void normalise(pca *p) {
  const int64_t n = p->n;

  // lengths in the norm of M, and the largest of a derivative
  double largest = 0;

  for (int64_t c = 0; c < p->count; c++) {
    double square;
    thrum_mass_gram(p->mass, p->q + c * n, 1, p->q + c * n, 1, &square, p->work);
    p->values[c] = sqrt(square);
    if (c >= p->modes)
      largest = fmax(largest, p->values[c]);
  }
  for (int64_t c = 0; c < p->count; c++) {
    // a derivative that is zero but for rounding must not be blown up to unit length
    const bool vanishes =
        !(p->values[c] > 0) || (c >= p->modes && !(p->values[c] > 1e-12 * largest));
    const double factor = vanishes ? 0 : 1 / p->values[c];
    for (int64_t i = 0; i < n; i++)
      p->q[c * n + i] *= factor;
  }
}

// weights by what the candidates do in a motion: a candidate of unit norm does so much times its
// norm, which normalise has left in p->values
static void set_share_weights(pca *p) {
  for (int64_t c = 0; c < p->count; c++)
    p->weight[c] = p->shares[c] * p->values[c];
}

// the first left singular vectors of a matrix (rows x count, destroyed): rows x min, or all
static thrum_status left_vectors(pca *p, char how, int64_t rows, int64_t count, double *matrix,
                                 double *left, thrum_error *error) {
  double unused;
  const int info =
      LAPACKE_dgesvd(LAPACK_COL_MAJOR, how, 'N', (int)rows, (int)count, matrix, (int)rows,
                     p->values, left, (int)rows, &unused, 1, p->values + p->count);
  return thrum_lapack_status(info, THRUM_NOT_CONVERGED,
                             "the singular values of the basis did not converge", error);
}

// left singular vectors of the weighted candidates, in the coordinates of q; R is in p->left, and
// the norms that normalise took away in p->values
static thrum_status decompose(pca *p, int64_t span, thrum_error *error) {
  for (int64_t c = 0; c < p->count; c++) {
    const double weight = p->weight[p->which[c]] * p->values[p->which[c]];
    for (int64_t i = 0; i < span; i++)
      p->small[c * span + i] = weight * p->left[c * p->count + i];
  }
  return left_vectors(p, 'S', span, p->count, p->small, p->left, error);
}

// rows of all components from columns over the free ones
static void scatter_rows(const thrum_fem *fem, const double *columns, int64_t rank, double *basis) {
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    for (int64_t i = 0; i < rank; i++)
      basis[c * rank + i] = fem->dof[c] < 0 ? 0 : columns[i * fem->free_count + fem->dof[c]];
}

// max |U^T M U - 1|
static double orthonormality_of(const pca *p, const double *basis) {
  const int64_t n = p->n, rank = p->rank;
  for (int64_t i = 0; i < rank; i++)
    for (int64_t f = 0; f < n; f++)
      p->columns[i * n + f] = basis[p->fem->component[f] * rank + i];
  thrum_mass_gram(p->mass, p->columns, rank, p->columns, rank, p->small, p->work);
  double worst = 0;
  for (int64_t i = 0; i < rank; i++)
    for (int64_t j = 0; j < rank; j++)
      worst = fmax(worst, fabs(p->small[i + j * rank] - (i == j ? 1 : 0)));
  return worst;
}

// turns the rows of U so that U^T K U is diagonal
static thrum_status diagonalise(pca *p, double *basis, thrum_error *error) {
  const int64_t rank = p->rank;
  const int r = (int)rank;

  // rows of the basis are rotated a block at a time, so memory stays small
  double *block = NULL;
  THRUM_TRY(thrum_reserve(&block, ROW_BLOCK * rank, sizeof *block, "the basis", error));

  // U^T K U = X diag(w^2) X^T
  thrum_status status = thrum_reduced_stiffness(p->fem, rank, basis, p->small, error);
  THRUM_THEN(status,
             thrum_lapack_status(
                 LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'V', 'U', r, p->small, r, p->values),
                 THRUM_NOT_CONVERGED, "the frequencies of the basis did not converge", error));

  // U becomes U X, in place
  const int64_t rows = 3 * p->fem->vertex_count;
  for (int64_t first = 0; first < rows && status >= 0; first += ROW_BLOCK) {
    const int64_t height = rows - first < ROW_BLOCK ? rows - first : ROW_BLOCK;
    memcpy(block, basis + first * rank, sizeof *block * (size_t)(height * rank));
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, (int)height, r, r, 1, block, r, p->small,
                r, 0, basis + first * rank, r);
  }

  free(block);
  // clusters closer than what the diagonalisation resolves are one
  if (status >= 0)
    thrum_eigen_canonicalise_fem(p->fem, true, rank, p->values, 1e-14 * p->values[rank - 1], basis,
                                 rank, 1);
  return status;
}

/* The trained fields behind the columns of modes and derivatives, orthonormal to them. */
static thrum_status append_trained(pca *p, double *columns, thrum_error *error) {
  const int64_t total = p->rank + p->trained_count;
  int64_t span = 0;

  // each of unit size first, so that the tolerance of the orthonormalisation means the same to all
  for (int64_t t = 0; t < p->trained_count; t++) {
    double *column = columns + (p->rank + t) * p->n, square = 0;
    thrum_fem_gather(p->fem, p->trained + 3 * t * p->fem->vertex_count, column);
    thrum_mass_gram(p->mass, column, 1, column, 1, &square, p->work);
    cblas_dscal((int)p->n, square > 0 ? 1 / sqrt(square) : 0, column, 1);
  }

  // what leaves no direction of its own cannot be a column
  THRUM_TRY(thrum_mass_orthonormalise(p->mass, total, columns, TOLERANCE, &span, p->work, error));
  if (span < total)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld of the trained shapes are among the modes and derivatives, or the "
                           "same; lower --rank",
                           (long long)(total - span));
  return THRUM_OK;
}

// how many of the responses are independent of each other; held axes have none
static thrum_status count_responses(const pca *p, int64_t *count, thrum_error *error) {
  *count = 0;
  if (p->response_count == 0)
    return THRUM_OK;
  const size_t bytes = sizeof(double) * (size_t)(p->n * p->response_count);
  double *copy = NULL;
  THRUM_TRY(thrum_reserve(&copy, p->n * p->response_count, sizeof *copy, "the basis", error));
  memcpy(copy, p->responses, bytes);
  const thrum_status status =
      thrum_mass_orthonormalise(p->mass, p->response_count, copy, TOLERANCE, count, p->work, error);
  free(copy);
  return status;
}

// what of a response's derivatives counts beside the first mode
static void weigh_response_derivatives(const pca *p, double a, double *columns) {
  const int64_t k = p->modes, shapes = k + p->response_count;
  const double *w = p->omega2;
  double *column = columns;
  for (int64_t i = 0; i < shapes; i++)
    for (int64_t j = i > k ? i : k; j < shapes; j++, column += p->n)
      cblas_dscal((int)p->n, a * (w[0] / w[i]) * (w[0] / w[j]), column, 1);
}

// appends to `done` orthonormal columns the `count` directions that the derivatives of the
// responses show most of beside them, by the method of snapshots; *found of them are there
static thrum_status append_response_derivatives(pca *p, int64_t done, int64_t count,
                                                double *columns, int64_t *found,
                                                thrum_error *error) {
  const int64_t h = p->response_count, pairs = h * p->modes + h * (h + 1) / 2;
  const int n = (int)p->n, wide = (int)pairs;
  thrum_scope memory = thrum_scope_begin("the basis", error);
  double *rest = thrum_scope_allocate(&memory, p->n * pairs, sizeof *rest);
  double *gram = thrum_scope_allocate(&memory, (pairs + done + 1) * pairs, sizeof *gram);
  thrum_status status = memory.status;

  // the weighted derivatives less what the columns show of them
  if (status >= 0) {
    memcpy(rest, p->responses + h * p->n, sizeof *rest * (size_t)(p->n * pairs));
    weigh_response_derivatives(p, p->length, rest);
    for (int pass = 0; pass < 2; pass++)
      thrum_mass_project(p->mass, columns, done, rest, pairs, gram, p->work);
    thrum_mass_gram(p->mass, rest, pairs, rest, pairs, gram, p->work);
    status = thrum_lapack_status(
        LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', wide, gram, wide, gram + pairs * pairs),
        THRUM_NOT_CONVERGED, "the derivatives of the responses did not converge", error);
  }

  // the largest come last; what is left below the rounding of their squares is nothing
  const double *values = gram + pairs * pairs;
  *found = 0;
  for (; status >= 0 && *found < count && *found < pairs; ++*found) {
    const int64_t at = pairs - 1 - *found;
    if (!(values[at] > 1e-10 * values[pairs - 1]))
      break;
    cblas_dgemv(CblasColMajor, CblasNoTrans, n, wide, 1 / sqrt(values[at]), rest, n,
                gram + at * pairs, 1, 0, columns + (done + *found) * p->n, 1);
  }
  thrum_scope_free(&memory);
  return status;
}

// the first vectors of the decomposition, all responses behind them, and what `more` of the
// responses' derivatives add, `wanted` orthonormal columns together; what is among the first
// already makes room for more of these
static thrum_status fill_columns(pca *p, int64_t span, int64_t more, int64_t wanted,
                                 double *columns, thrum_error *error) {
  const int n = (int)p->n;
  for (int64_t first = p->rank; first <= span && first <= wanted; first++) {
    int64_t found = first, added = 0;
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, (int)first, (int)span, 1, p->q, n,
                p->left, (int)span, 0, columns, n);
    memcpy(columns + first * p->n, p->responses,
           sizeof *columns * (size_t)(p->n * p->response_count));
    THRUM_TRY(thrum_mass_orthonormalise(p->mass, first + p->response_count, columns, TOLERANCE,
                                        &found, p->work, error));
    const int64_t left = wanted - found < more ? wanted - found : more;
    if (left > 0)
      THRUM_TRY(append_response_derivatives(p, found, left, columns, &added, error));
    THRUM_TRY(thrum_mass_orthonormalise(p->mass, found + added, columns, TOLERANCE, &found, p->work,
                                        error));
    if (found >= wanted)
      return THRUM_OK;
  }
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "rank %lld is more than modes, derivatives and the responses of the "
                         "handles span; lower --rank",
                         (long long)wanted);
}

static thrum_status build(pca *p, const double *omega2, double *basis,
                          const thrum_reporter *reporter, thrum_error *error) {
  int64_t span = 0;

  // an M-orthonormal basis of the weighted candidates
  p->length = length_factor(p->fem, p->q);
  set_weights(p, omega2);
  normalise(p);
  if (p->shares != NULL)
    set_share_weights(p);
  thrum_status status = thrum_mass_factor(p->mass, p->count, p->q, TOLERANCE, &span, p->left,
                                          p->which, p->work, error);
  THRUM_THEN(status, thrum_report(reporter, 0.5, error));

  // responses, and as many of their derivatives, come beside modes and derivatives, which are
  // chosen as without them; a lower rank has room for fewer of either
  int64_t responses = 0;
  const int64_t rank = p->rank;
  THRUM_THEN(status, count_responses(p, &responses, error));
  const int64_t beside = 2 * responses < rank ? 2 * responses : rank;
  p->rank -= beside;
  if (status >= 0 && beside < responses)
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "rank %lld is less than the %lld responses of the handles; raise "
                             "--rank",
                             (long long)rank, (long long)responses);

  // the span limits the rank
  if (status >= 0 && p->rank > span)
    status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "rank %lld is more than the candidates span: they have rank %lld; "
                             "lower --rank or raise --modes",
                             (long long)p->rank, (long long)span);
  THRUM_THEN(status, decompose(p, span, error));
  if (status < 0)
    return status;

  // the columns of the basis, on the free components and then on all
  const int64_t total = rank + p->trained_count;
  double *columns =
      thrum_scope_allocate(&p->memory, p->n * (total + p->response_count), sizeof *columns);
  THRUM_TRY(p->memory.status);
  p->columns = columns;
  if (responses > 0)
    status = fill_columns(p, span, beside - responses, rank, columns, error);
  else
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, (int)p->n, (int)p->rank, (int)span, 1,
                p->q, (int)p->n, p->left, (int)span, 0, columns, (int)p->n);
  p->rank = rank;
  if (p->trained_count > 0)
    THRUM_THEN(status, append_trained(p, columns, error));
  p->rank = total;
  scatter_rows(p->fem, columns, p->rank, basis);
  if (status < 0)
    return status;

  // the reduced stiffness of the basis becomes diagonal
  status = thrum_report(reporter, 0.8, error);
  return status >= 0 ? diagonalise(p, basis, error) : status;
}

thrum_status thrum_basis(const thrum_fem *fem, const thrum_sparse *mass, int64_t k,
                         const double *omega2, double *candidates, const double *shares,
                         const double *responses, int64_t response_count, int64_t rank,
                         const double *trained, int64_t trained_count, double *basis,
                         double *orthonormality, const thrum_reporter *reporter,
                         thrum_error *error) {
  pca p = {.fem = fem,
           .mass = mass,
           .n = fem->free_count,
           .modes = k,
           .responses = responses,
           .response_count = response_count,
           .omega2 = omega2,
           .q = candidates,
           .count = k + k * (k + 1) / 2,
           .rank = rank - trained_count,
           .shares = shares,
           .trained = trained,
           .trained_count = trained_count};
  p.wide = rank > p.count ? rank : p.count;
  if (p.rank < 1 || p.rank - 2 * response_count > p.count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld does not go with %lld trained shapes and %lld modes",
                           (long long)rank, (long long)trained_count, (long long)k);
  thrum_status status = pca_allocate(&p, error);
  THRUM_THEN(status, build(&p, omega2, basis, reporter, error));
  if (status >= 0)
    *orthonormality = orthonormality_of(&p, basis);
  thrum_scope_free(&p.memory);
  return status;
}
