/* The basis U, design 2: all linear modes, exactly, and beside them the first directions of a
 * principal component analysis of the modal derivatives Phi_ij w_1^4/(w_i^2 w_j^2) less their part
 * in the modes, in the norm of the stiffness. The weights are those of Barbic, James 2005,
 * doi:10.1145/1073204.1073300, whose analysis has the modes among its candidates, where the norm of
 * the mass may throw some out. The norm of the stiffness measures what a body without a direction
 * is too stiff by: |Phi|_K^2 q^4/8 is the strain energy that Phi takes from a motion q of its
 * modes. The decomposition goes through an accurate mass-QR, so small singular values are right as
 * well. Then U is turned so that U^T K U is diagonal: as K psi = w^2 M psi, what is orthogonal to
 * the modes in M is so in K, and the modes stay columns of U. O(n candidates^2); the derivatives
 * become the Q of the mass-QR in their place.
 *
 * Or, as Barbic and James have it and the thesis: modes psi_i w_1^2/w_i^2 and derivatives times a
 * are the candidates of one analysis in the norm of the mass, a = 0.1 (bounding-box
 * diagonal)/max_x |psi_1(x)|, which makes them comparable in any unit of length.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/basis.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/polynomial/polynomial_reduce.h"

#define TOLERANCE                                                                                  \
  1e-8 /* what is left of a candidate below this of itself is noise of the solves                  \
        */
#define ROW_BLOCK 256

/* Columns of U before it is turned, in this order. */
typedef struct parts {
  int64_t modes, derivatives; /* the first of the modes, the first of the decomposition */
  int64_t handles;            /* responses, then what their derivatives add */
  int64_t trained;
} parts;

typedef struct pca {
  const thrum_basis_def *def;
  const thrum_fem *fem;
  const thrum_sparse *mass;
  int64_t n, modes, rank;
  int64_t count;  /* of candidates: derivatives, or modes and derivatives */
  int64_t wide;   /* the largest of all candidates, the rank and the responses */
  double *psi;    /* n x modes */
  double *q;      /* n x pairs: the derivatives of unit norm, then orthonormal */
  int64_t span;   /* of the derivatives beside the modes */
  double *weight; /* pairs: what each column of unit norm counts */
  int32_t *which; /* pairs: the derivative of each column of R */
  parts parts;
  double *columns; /* n x (rank + response_count), of the basis before it is turned */
  double *shown;   /* pairs x directions, column-major: y^T K Phi of a direction y and a weighted
                      derivative Phi */
  double *work;    /* n x THRUM_GRAM_WORK */
  double *small;   /* wide x wide */
  double *left;    /* pairs x pairs */
  double *stiff;   /* pairs x pairs */
  double *values;  /* 2 wide */
  thrum_scope memory;
} pca;

static thrum_status pca_allocate(pca *p, thrum_error *error) {
  p->memory = thrum_scope_begin("the basis", error);
  p->weight = thrum_scope_allocate(&p->memory, p->count, sizeof(double));
  p->which = thrum_scope_allocate(&p->memory, p->count, sizeof *p->which);
  p->work = thrum_scope_allocate(&p->memory, p->n * THRUM_GRAM_WORK, sizeof(double));
  p->small = thrum_scope_allocate(&p->memory, p->wide * p->wide, sizeof(double));
  p->left = thrum_scope_allocate(&p->memory, p->count * p->count, sizeof(double));
  p->stiff = thrum_scope_allocate(&p->memory, p->count * p->count, sizeof(double));
  p->values = thrum_scope_allocate(&p->memory, 2 * p->wide, sizeof(double));
  p->columns = thrum_scope_allocate(&p->memory, p->n * (p->rank + p->def->response_count),
                                    sizeof *p->columns);
  return p->memory.status;
}

// the modes orthonormal to rounding; those of an eigensolver are nearly so
static thrum_status orthonormalise_modes(pca *p, thrum_error *error) {
  const int n = (int)p->n, k = (int)p->modes;
  thrum_mass_gram(p->mass, p->psi, k, p->psi, k, p->small, p->work);
  THRUM_TRY(thrum_lapack_status(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', k, p->small, k),
                                THRUM_SINGULAR, "the modes could not be orthonormalised", error));
  cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, n, k, 1, p->small,
              k, p->psi, n);
  return THRUM_OK;
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

static bool by_mass(const pca *p) {
  return p->def->selection == THRUM_SELECTION_MASS;
}

// what a motion does of each candidate: by frequency, or by the shares of a motion
static void set_weights(pca *p) {
  const double a = by_mass(p) ? length_factor(p->fem, p->psi) : 1;
  const double *w = p->def->omega2, *shares = p->def->shares;
  int64_t next = 0;
  for (int64_t i = 0; i < p->modes && by_mass(p); i++, next++)
    p->weight[next] = shares ? shares[i] : w[0] / w[i];
  shares = shares && !by_mass(p) ? shares + p->modes : shares;
  for (int64_t i = 0; i < p->modes; i++)
    for (int64_t j = i; j < p->modes; j++, next++)
      p->weight[next] = shares ? shares[next] : a * (w[0] / w[i]) * (w[0] / w[j]);
}

static double mass_norm(pca *p, const double *column) {
  double square = 0;
  thrum_mass_gram(p->mass, column, 1, column, 1, &square, p->work);
  return sqrt(square);
}

// each candidate to unit norm, its weight times what it had; derivatives that vanish become zero
static void normalise(pca *p, double least) {
  for (int64_t c = 0; c < p->count; c++) {
    const bool mode = by_mass(p) && c < p->modes;
    double norm = mass_norm(p, p->q + c * p->n);
    if (!(norm > (mode ? 0 : least)))
      norm = 0;
    cblas_dscal((int)p->n, norm > 0 ? 1 / norm : 0, p->q + c * p->n, 1);
    p->weight[c] *= norm;
  }
}

// the candidates of unit norm, with weights that have their norms; derivatives less their part in
// the modes, where these are no candidates
static void prepare_candidates(pca *p) {
  double largest = 0;
  for (int64_t c = by_mass(p) ? p->modes : 0; c < p->count; c++)
    largest = fmax(largest, mass_norm(p, p->q + c * p->n));

  // a derivative that is zero but for rounding must not be blown up to unit length, nor may what
  // rounding leaves of one that the modes show whole
  normalise(p, 1e-12 * largest);
  if (by_mass(p))
    return;
  for (int pass = 0; pass < 2; pass++)
    thrum_mass_project(p->mass, p->psi, p->modes, p->q, p->count, p->small, p->work);
  normalise(p, TOLERANCE);
}

// the weighted candidates in the coordinates of q
static void fill_weighted(pca *p) {
  for (int64_t c = 0; c < p->count; c++)
    for (int64_t i = 0; i < p->span; i++)
      p->small[c * p->span + i] = p->weight[p->which[c]] * p->left[c * p->count + i];
}

// left singular vectors of the weighted candidates in the norm of the mass
static thrum_status decompose_by_mass(pca *p, thrum_error *error) {
  const int span = (int)p->span, count = (int)p->count;
  double unused;
  fill_weighted(p);
  return thrum_lapack_status(
      LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'S', 'N', span, count, p->small, span, p->values, p->left,
                     span, &unused, 1, p->values + count),
      THRUM_NOT_CONVERGED, "the singular values of the basis did not converge", error);
}

// the factor of Q^T K Q = C^T C in p->stiff, and C times the weighted derivatives, whose lengths
// are then those in the norm of the stiffness, in p->small
static thrum_status weigh_by_stiffness(pca *p, thrum_error *error) {
  const int span = (int)p->span, pairs = (int)p->count;
  thrum_mass_gram(p->def->stiffness, p->q, span, p->q, span, p->stiff, p->work);
  THRUM_TRY(thrum_lapack_status(LAPACKE_dpotrf(LAPACK_COL_MAJOR, 'U', span, p->stiff, span),
                                THRUM_SINGULAR, "the derivatives have no strain energy", error));
  fill_weighted(p);
  cblas_dtrmm(CblasColMajor, CblasLeft, CblasUpper, CblasNoTrans, CblasNonUnit, span, pairs, 1,
              p->stiff, span, p->small, span);
  return THRUM_OK;
}

// the first `count` directions of the weighted derivatives, mass-orthonormal, in the coordinates of
// q: into p->left, where R was; and what each weighted derivative has of them, into p->shown
static thrum_status decompose(pca *p, int64_t count, thrum_error *error) {
  const int span = (int)p->span, pairs = (int)p->count, some = (int)count;
  double unused;
  p->shown = thrum_scope_allocate(&p->memory, (count + 1) * pairs, sizeof *p->shown);
  THRUM_TRY(p->memory.status);
  if (count == 0)
    return THRUM_OK;

  // the right singular vectors, as rows, take the place of what is decomposed
  THRUM_TRY(weigh_by_stiffness(p, error));
  int info = LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'S', 'O', span, pairs, p->small, span, p->values,
                            p->left, span, &unused, 1, p->values + pairs);
  for (int64_t d = 0; d < count; d++)
    for (int64_t c = 0; c < pairs; c++)
      p->shown[d * pairs + p->which[c]] = p->values[d] * p->small[c * span + d];

  // directions X that are orthonormal in the stiffness are X = Y T with Y orthonormal in the mass
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasUpper, CblasNoTrans, CblasNonUnit, span, some, 1,
              p->stiff, span, p->left, span);
  if (info == 0)
    info = LAPACKE_dgeqrf(LAPACK_COL_MAJOR, span, some, p->left, span, p->values);
  cblas_dtrsm(CblasColMajor, CblasRight, CblasUpper, CblasNoTrans, CblasNonUnit, pairs, some, 1,
              p->left, span, p->shown, pairs);
  if (info == 0)
    info = LAPACKE_dorgqr(LAPACK_COL_MAJOR, span, some, some, p->left, span, p->values);
  return thrum_lapack_status(info, THRUM_NOT_CONVERGED,
                             "the singular values of the basis did not converge", error);
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

// appends to `done` orthonormal columns `count` others that stand behind them, as far as these are
// not among the first or each other; *found of them are there
static thrum_status append(pca *p, int64_t done, int64_t count, int64_t *found,
                           thrum_error *error) {
  double *columns = p->columns + done * p->n;

  // each of unit size first, so that the tolerance of the orthonormalisation means the same to all
  for (int64_t c = 0; c < count; c++) {
    const double norm = mass_norm(p, columns + c * p->n);
    cblas_dscal((int)p->n, norm > 0 ? 1 / norm : 0, columns + c * p->n, 1);
  }
  for (int pass = 0; pass < 2; pass++)
    thrum_mass_project(p->mass, p->columns, done, columns, count, p->small, p->work);
  return thrum_mass_orthonormalise(p->mass, count, columns, TOLERANCE, found, p->work, error);
}

/* The trained fields behind the other columns, orthonormal to them. */
static thrum_status append_trained(pca *p, thrum_error *error) {
  const int64_t done = p->rank - p->def->trained_count;
  for (int64_t t = 0; t < p->def->trained_count; t++)
    thrum_fem_gather(p->fem, p->def->trained + 3 * t * p->fem->vertex_count,
                     p->columns + (done + t) * p->n);
  THRUM_TRY(append(p, done, p->def->trained_count, &p->parts.trained, error));

  // what leaves no direction of its own cannot be a column
  if (p->parts.trained < p->def->trained_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld of the trained shapes are among the modes and derivatives, or the "
                           "same; lower --rank",
                           (long long)(p->def->trained_count - p->parts.trained));
  return THRUM_OK;
}

// how many of the responses are independent of each other; held axes have none
static thrum_status count_responses(const pca *p, int64_t *count, thrum_error *error) {
  *count = 0;
  if (p->def->response_count == 0)
    return THRUM_OK;
  const size_t bytes = sizeof(double) * (size_t)(p->n * p->def->response_count);
  double *copy = NULL;
  THRUM_TRY(thrum_reserve(&copy, p->n * p->def->response_count, sizeof *copy, "the basis", error));
  memcpy(copy, p->def->responses, bytes);
  const thrum_status status = thrum_mass_orthonormalise(p->mass, p->def->response_count, copy,
                                                        TOLERANCE, count, p->work, error);
  free(copy);
  return status;
}

// what of a response's derivatives counts beside the first mode
static void weigh_response_derivatives(const pca *p, double *columns) {
  const int64_t k = p->modes, shapes = k + p->def->response_count;
  const double *w = p->def->omega2;
  double *column = columns;
  for (int64_t i = 0; i < shapes; i++)
    for (int64_t j = i > k ? i : k; j < shapes; j++, column += p->n)
      cblas_dscal((int)p->n, (w[0] / w[i]) * (w[0] / w[j]), column, 1);
}

// appends to `done` orthonormal columns the `count` directions that the derivatives of the
// responses show most of beside them, by the method of snapshots; *found of them are there
static thrum_status append_response_derivatives(pca *p, int64_t done, int64_t count,
                                                double *columns, int64_t *found,
                                                thrum_error *error) {
  const int64_t h = p->def->response_count, pairs = h * p->modes + h * (h + 1) / 2;
  const int n = (int)p->n, wide = (int)pairs;
  thrum_scope memory = thrum_scope_begin("the basis", error);
  double *rest = thrum_scope_allocate(&memory, p->n * pairs, sizeof *rest);
  double *gram = thrum_scope_allocate(&memory, (pairs + done + 1) * pairs, sizeof *gram);
  thrum_status status = memory.status;

  // the weighted derivatives less what the columns show of them
  if (status >= 0) {
    memcpy(rest, p->def->responses + h * p->n, sizeof *rest * (size_t)(p->n * pairs));
    weigh_response_derivatives(p, rest);
    for (int pass = 0; pass < 2; pass++)
      thrum_mass_project(p->mass, columns, done, rest, pairs, gram, p->work);
    thrum_mass_gram(p->mass, rest, pairs, rest, pairs, gram, p->work);
    status = thrum_lapack_status(
        LAPACKE_dsyev(LAPACK_COL_MAJOR, 'V', 'U', wide, gram, wide, gram + pairs * pairs),
        THRUM_NOT_CONVERGED, "the derivatives of the responses did not converge", error);
  }

  // the largest come last; what is left below the rounding of their squares is nothing
  const double *values = status >= 0 ? gram + pairs * pairs : NULL;
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

// the modes, and as many of the first directions of the derivatives
static void fill_modes(pca *p, int64_t directions) {
  const int n = (int)p->n, span = (int)p->span;
  memcpy(p->columns, p->psi, sizeof *p->columns * (size_t)(p->n * p->parts.modes));
  p->parts.derivatives = directions;
  if (directions > 0)
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, n, (int)directions, span, 1, p->q, n,
                p->left, span, 0, p->columns + p->parts.modes * p->n, n);
}

// modes and derivatives, all responses behind them, and what `more` of the responses' derivatives
// add, `wanted` orthonormal columns together; what is among the first already makes room for more
// of these
static thrum_status fill_columns(pca *p, int64_t more, int64_t wanted, thrum_error *error) {
  const int64_t modes = p->parts.modes;
  for (int64_t first = p->parts.derivatives; first <= p->span && modes + first <= wanted; first++) {
    int64_t found = 0, added = 0;
    fill_modes(p, first);
    memcpy(p->columns + (modes + first) * p->n, p->def->responses,
           sizeof *p->columns * (size_t)(p->n * p->def->response_count));
    THRUM_TRY(append(p, modes + first, p->def->response_count, &found, error));

    // the responses' derivatives are orthonormal to rounding once they are projected again
    const int64_t done = modes + first + found;
    const int64_t left = wanted - done < more ? wanted - done : more;
    if (left > 0)
      THRUM_TRY(append_response_derivatives(p, done, left, p->columns, &added, error));
    THRUM_TRY(append(p, done, added, &added, error));
    p->parts.handles = found + added;
    if (done + added >= wanted)
      return THRUM_OK;
  }
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "rank %lld is more than modes, derivatives and the responses of the "
                         "handles span; lower --rank",
                         (long long)wanted);
}

// an M-orthonormal basis of the candidates: of what the derivatives show beside the modes
static thrum_status make_directions(pca *p, const thrum_reporter *reporter, thrum_error *error) {
  if (!by_mass(p))
    THRUM_TRY(orthonormalise_modes(p, error));
  set_weights(p);
  prepare_candidates(p);
  THRUM_TRY(thrum_mass_factor(p->mass, p->count, p->q, TOLERANCE, &p->span, p->left, p->which,
                              p->work, error));
  return thrum_report(reporter, 0.5, error);
}

// how much of `rank` columns each part gets; `more` are left for derivatives of responses, which
// come beside modes and derivatives, chosen as without them; a lower rank has room for fewer of
// either
static thrum_status share_out(pca *p, int64_t rank, int64_t *responses, int64_t *more,
                              thrum_error *error) {
  THRUM_TRY(count_responses(p, responses, error));
  const int64_t beside = 2 * *responses < rank ? 2 * *responses : rank, usual = rank - beside;
  if (beside < *responses)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld is less than the %lld responses of the handles; raise "
                           "--rank",
                           (long long)rank, (long long)*responses);
  *more = beside - *responses;
  const int64_t modes = by_mass(p) ? 0 : p->modes;
  p->parts.modes = usual < modes ? usual : modes;
  p->parts.derivatives = usual - p->parts.modes;

  // the span limits the rank
  if (p->parts.derivatives > p->span)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld is more than the candidates span: they have rank %lld; "
                           "lower --rank or raise --modes",
                           (long long)usual, (long long)(modes + p->span));
  return THRUM_OK;
}

static thrum_status build(pca *p, double *basis, const thrum_reporter *reporter,
                          thrum_error *error) {
  const int64_t rank = p->rank - p->def->trained_count;
  int64_t responses = 0, more = 0;
  THRUM_TRY(make_directions(p, reporter, error));
  THRUM_TRY(share_out(p, rank, &responses, &more, error));
  THRUM_TRY(by_mass(p) ? decompose_by_mass(p, error)
                       : decompose(p, p->span < rank ? p->span : rank, error));

  // the columns of the basis, on the free components and then on all
  if (responses > 0)
    THRUM_TRY(fill_columns(p, more, rank, error));
  else
    fill_modes(p, p->parts.derivatives);
  THRUM_TRY(append_trained(p, error));
  scatter_rows(p->fem, p->columns, p->rank, basis);

  // the reduced stiffness of the basis becomes diagonal
  THRUM_TRY(thrum_report(reporter, 0.8, error));
  return diagonalise(p, basis, error);
}

/* --- what the coordinates are ------------------------------------------------------------------
 */

// the kind that has most of a coordinate, from its parts in the columns before they were turned
static void name_coordinate(const pca *p, const double *part, thrum_coordinate *coordinate) {
  const parts *all = &p->parts;
  const int64_t counts[THRUM_COORDINATE_KINDS] = {all->modes, all->derivatives, all->handles,
                                                  all->trained};
  for (int kind = 0; kind < THRUM_COORDINATE_KINDS; part += counts[kind++]) {
    double share = 0;
    for (int64_t i = 0; i < counts[kind]; i++)
      share += part[i] * part[i];
    if (share > coordinate->share) {
      coordinate->kind = (thrum_coordinate_kind)kind;
      coordinate->share = share;
    }
  }
}

// puts a pair into the list of the largest
static void rank_pair(thrum_coordinate *coordinate, int64_t i, int64_t j, double share) {
  int place = THRUM_COORDINATE_PAIRS;
  while (place > 0 && share > coordinate->pair_shares[place - 1])
    place--;
  for (int n = THRUM_COORDINATE_PAIRS - 1; n > place; n--) {
    coordinate->pair_shares[n] = coordinate->pair_shares[n - 1];
    memcpy(coordinate->pairs[n], coordinate->pairs[n - 1], sizeof coordinate->pairs[n]);
  }
  if (place == THRUM_COORDINATE_PAIRS)
    return;
  coordinate->pair_shares[place] = share;
  coordinate->pairs[place][0] = i + 1;
  coordinate->pairs[place][1] = j + 1;
}

// the pairs whose weighted derivatives have most strain energy along a coordinate, which has these
// parts in the directions
static void name_pairs(const pca *p, const double *part, thrum_coordinate *coordinate) {
  double whole = 0;
  for (int64_t i = 0, pair = 0; i < p->modes; i++)
    for (int64_t j = i; j < p->modes; j++, pair++) {
      double shown = 0;
      for (int64_t d = 0; d < p->parts.derivatives; d++)
        shown += part[d] * p->shown[d * p->count + pair];
      whole += shown * shown;
      rank_pair(coordinate, i, j, shown * shown);
    }
  for (int n = 0; n < THRUM_COORDINATE_PAIRS; n++)
    coordinate->pair_shares[n] /= whole > 0 ? whole : 1;
}

static void name_coordinates(pca *p, const double *basis, thrum_coordinate *coordinates) {
  const int64_t rank = p->rank;
  double *column = p->q, *part = p->small;
  for (int64_t c = 0; c < rank; c++) {
    thrum_coordinate *coordinate = &coordinates[c];
    for (int64_t f = 0; f < p->n; f++)
      column[f] = basis[p->fem->component[f] * rank + c];
    thrum_mass_gram(p->mass, p->columns, rank, column, 1, part, p->work);

    *coordinate = (thrum_coordinate){0};
    name_coordinate(p, part, coordinate);
    if (coordinate->kind == THRUM_COORDINATE_MODE)
      coordinate->mode = 1 + (int64_t)cblas_idamax((int)p->parts.modes, part, 1);
    else if (coordinate->kind == THRUM_COORDINATE_DERIVATIVE)
      name_pairs(p, part + p->parts.modes, coordinate);
  }
}

thrum_status thrum_basis(const thrum_basis_def *def, double *basis, double *orthonormality,
                         thrum_coordinate *coordinates, const thrum_reporter *reporter,
                         thrum_error *error) {
  const int64_t k = def->modes, pairs = k * (k + 1) / 2;
  const int64_t rest = def->rank - def->trained_count;
  const bool together = def->selection == THRUM_SELECTION_MASS;
  pca p = {.def = def,
           .fem = def->fem,
           .mass = def->mass,
           .n = def->fem->free_count,
           .modes = k,
           .count = together ? k + pairs : pairs,
           .rank = def->rank,
           .wide = def->rank > k + pairs ? def->rank : k + pairs,
           .psi = def->candidates,
           .q = def->candidates + (together ? 0 : k * def->fem->free_count)};
  if (p.wide < def->response_count)
    p.wide = def->response_count;
  if (rest < 1 || rest - 2 * def->response_count > k + pairs)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld does not go with %lld trained shapes and %lld modes",
                           (long long)def->rank, (long long)def->trained_count, (long long)k);
  thrum_status status = pca_allocate(&p, error);
  THRUM_THEN(status, build(&p, basis, reporter, error));
  if (status >= 0 && !together)
    name_coordinates(&p, basis, coordinates);
  if (status >= 0)
    *orthonormality = orthonormality_of(&p, basis);
  thrum_scope_free(&p.memory);
  return status;
}
