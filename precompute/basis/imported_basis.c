/* A basis and a polynomial made elsewhere, brought into Thrum's form, design 2. S solves
 *   (U^T K U) S = (U^T M U) S diag(w^2),  S^T (U^T M U) S = 1,
 * so U S is mass-orthonormal and diagonalises K, and V(S q') is its polynomial. Signs and clusters
 * are then made canonical, as those of a fresh basis.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/imported_basis.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/lapack_status.h"
#include "precompute/polynomial/change_of_basis.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/polynomial.h"

#define AS_IT_IS 1e-11 /* a basis this near to Thrum's form is not changed */
#define TOLERANCE 1e-6 /* an imported polynomial may differ by this much from the body's */
#define CHANGES_MAX 3  /* a badly scaled basis takes more than one */
#define REACH 0.2      /* displacement of the check, in diagonals of the box */

typedef struct work {
  const thrum_fem *fem;
  const thrum_sparse *mass;
  int64_t rank, rows;
  double *columns, *other, *block;           /* n x rank, n x rank, n x THRUM_GRAM_WORK */
  double *mass_form, *stiffness_form, *step; /* rank x rank */
  double *copy;                              /* rows x rank */
  double *values;                            /* rank */
  thrum_scope memory;
} work;

static thrum_status work_allocate(work *w, thrum_error *error) {
  const int64_t n = w->fem->free_count, r = w->rank;
  w->memory = thrum_scope_begin("the imported basis", error);
  w->columns = thrum_scope_allocate(&w->memory, n * r, sizeof(double));
  w->other = thrum_scope_allocate(&w->memory, n * r, sizeof(double));
  w->block = thrum_scope_allocate(&w->memory, n * THRUM_GRAM_WORK, sizeof(double));
  w->mass_form = thrum_scope_allocate(&w->memory, r * r, sizeof(double));
  w->stiffness_form = thrum_scope_allocate(&w->memory, r * r, sizeof(double));
  w->step = thrum_scope_allocate(&w->memory, r * r, sizeof(double));
  w->copy = thrum_scope_allocate(&w->memory, w->rows * r, sizeof(double));
  w->values = thrum_scope_allocate(&w->memory, r, sizeof(double));
  return w->memory.status;
}

// rows of the file into rows of the mesh, whose unused vertices are dropped
static thrum_status take_rows(const thrum_fem *fem, const thrum_mesh *mesh,
                              const thrum_imported_basis *imported, double *basis,
                              thrum_error *error) {
  const int64_t rows = 3 * mesh->vertex_count, r = imported->rank;
  const bool mapped = mesh->file_vertex != NULL && imported->rows == 3 * mesh->file_vertex_count;

  // what was made since the file was read has no row
  if (mesh->made_midsides > 0 && imported->rows != rows)
    return thrum_error_set(
        error, THRUM_BAD_SHAPE,
        "the mesh has %lld nodes that its file has not, of which the basis tells "
        "nothing: give --element shell where wedges were divided, or leave out "
        "--order 2",
        (long long)mesh->made_midsides);

  // a file has rows for the vertices of the mesh, or for those of its file
  if (imported->rows != rows && !mapped)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "the basis has %lld rows, but the mesh has 3 x %lld vertices: they do "
                           "not belong together",
                           (long long)imported->rows, (long long)mesh->vertex_count);

  // each row goes to its vertex
  for (int64_t c = 0; c < imported->rows; c++) {
    const int64_t vertex = mapped ? mesh->file_vertex[c / 3] : c / 3;
    if (vertex >= 0)
      memcpy(basis + (3 * vertex + c % 3) * r, imported->basis + c * r, sizeof *basis * (size_t)r);
  }

  // a held component must not move, up to rounding beside the largest entry
  double largest = 0;
  for (int64_t n = 0; n < rows * r; n++)
    largest = fmax(largest, fabs(basis[n]));
  for (int64_t c = 0; c < rows; c++)
    for (int64_t i = 0; i < r && fem->dof[c] < 0; i++) {
      if (fabs(basis[c * r + i]) > 1e-12 * largest)
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "column %lld of the basis moves vertex %lld along %c, which is "
                               "held: give the --fix that the basis was made with",
                               (long long)i + 1, (long long)c / 3 + 1, "xyz"[c % 3]);
      // a zero keeps its sign, for the file's bits
      if (basis[c * r + i] != 0)
        basis[c * r + i] = 0;
    }
  return THRUM_OK;
}

static void gather(const work *w, const double *basis, double *columns) {
  for (int64_t i = 0; i < w->rank; i++)
    for (int64_t f = 0; f < w->fem->free_count; f++)
      columns[i * w->fem->free_count + f] = basis[w->fem->component[f] * w->rank + i];
}

// U^T M U and U^T K U, and how far they are from Thrum's form
static thrum_status measure(work *w, const double *basis, double *orthonormality,
                            double *diagonality, bool *ascending, thrum_error *error) {
  const int64_t r = w->rank;

  // both forms in the imported columns
  gather(w, basis, w->columns);
  thrum_mass_gram(w->mass, w->columns, r, w->columns, r, w->mass_form, w->block);
  THRUM_TRY(thrum_reduced_stiffness(w->fem, r, basis, w->stiffness_form, error));

  // the distance of U^T M U from one, and of U^T K U from a diagonal that ascends
  double off_one = 0, off_diagonal = 0, largest = 0;
  *ascending = true;
  for (int64_t i = 0; i < r; i++) {
    const double *row = w->stiffness_form + i * r;
    largest = fmax(largest, row[i]);
    *ascending = *ascending && (i == 0 || row[i] >= row[i - 1 - r] * (1 - AS_IT_IS));
    for (int64_t j = 0; j < r; j++) {
      off_one = fmax(off_one, fabs(w->mass_form[i * r + j] - (i == j ? 1 : 0)));
      off_diagonal = i == j ? off_diagonal : fmax(off_diagonal, fabs(row[j]));
    }
  }

  *orthonormality = off_one;
  *diagonality = off_diagonal / largest;
  return THRUM_OK;
}

// an elastic basis must not hold rigid motions: they and elastic ones would mix in the polynomial
static thrum_status check_rigid(const work *w, const double *dual, thrum_error *error) {
  const int64_t n = w->fem->free_count;
  for (int64_t i = 0; i < w->rank && dual; i++)
    for (int z = 0; z < 6; z++) {
      const double share = fabs(cblas_ddot((int)n, w->columns + i * n, 1, dual + z * n, 1)) /
                           sqrt(w->mass_form[i * w->rank + i]);
      if (!(share < 1e-8))
        return thrum_error_set(error, THRUM_UNSUPPORTED,
                               "nothing is fixed, and column %lld of the basis holds a rigid "
                               "motion (share %.2g): hold what was held with --fix, or take the "
                               "rigid part out of the basis",
                               (long long)i + 1, share);
    }
  return THRUM_OK;
}

// rows of matrix (height x rank) times S, in place; copy: as large
static void change_rows(int64_t height, int64_t rank, const double *change, double *matrix,
                        double *copy) {
  memcpy(copy, matrix, sizeof *copy * (size_t)(height * rank));
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, (int)height, (int)rank, (int)rank, 1, copy,
              (int)rank, change, (int)rank, 0, matrix, (int)rank);
}

static thrum_status change_once(work *w, double *basis, double *change, thrum_error *error) {
  const int r = (int)w->rank;
  const int info = LAPACKE_dsygv(LAPACK_ROW_MAJOR, 1, 'V', 'U', r, w->stiffness_form, r,
                                 w->mass_form, r, w->values);
  if (info > r)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "column %d of the basis depends on the ones before it", info - r);
  THRUM_TRY(thrum_lapack_status(info, THRUM_NOT_CONVERGED,
                                "the frequencies of the imported basis did not converge", error));
  change_rows(w->rows, w->rank, w->stiffness_form, basis, w->copy);
  change_rows(w->rank, w->rank, w->stiffness_form, change, w->step);
  return THRUM_OK;
}

// the rule of fresh bases for signs and clusters; its change of basis follows from the vectors
// before and after
static void canonicalise(work *w, double *basis, double *change) {
  const int64_t r = w->rank;
  gather(w, basis, w->other);
  thrum_eigen_canonicalise(w->rows, r, w->values, 1e-14 * w->values[r - 1], basis, r, 1);
  gather(w, basis, w->columns);
  // column-major new^T M old is row-major old^T M new
  thrum_mass_gram(w->mass, w->columns, r, w->other, r, w->mass_form, w->block);
  change_rows(r, r, w->mass_form, change, w->step);
}

static thrum_status change_basis(work *w, const double *rigid_dual, double *basis, double *change,
                                 thrum_imported_figures *figures, thrum_error *error) {
  // how far the imported basis is from Thrum's form
  double off_one = 0, off_diagonal = 0;
  bool ascending = false;
  THRUM_TRY(measure(w, basis, &off_one, &off_diagonal, &ascending, error));
  figures->orthonormality = off_one;
  THRUM_TRY(check_rigid(w, rigid_dual, error));

  // changes of basis until it is in that form, each of which removes most of the last one's
  // rounding
  for (int n = 0; n < CHANGES_MAX; n++) {
    if (off_one < AS_IT_IS && off_diagonal < AS_IT_IS && ascending)
      break;
    figures->changed = true;
    THRUM_TRY(change_once(w, basis, change, error));
    THRUM_TRY(measure(w, basis, &off_one, &off_diagonal, &ascending, error));
  }

  // a changed basis has its signs fixed
  if (figures->changed)
    canonicalise(w, basis, change);
  figures->orthonormality_after = off_one;
  return THRUM_OK;
}

thrum_status thrum_imported_basis_fill(const thrum_fem *fem, const thrum_mesh *mesh,
                                       const thrum_sparse *mass, const double *rigid_dual,
                                       const thrum_imported_basis *imported, double *basis,
                                       double *change, thrum_imported_figures *figures,
                                       thrum_error *error) {
  const int64_t r = imported->rank;
  work w = {.fem = fem, .mass = mass, .rank = r, .rows = 3 * fem->vertex_count};
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++)
      change[i * r + j] = i == j;
  thrum_status status = take_rows(fem, mesh, imported, basis, error);
  THRUM_THEN(status, work_allocate(&w, error));
  THRUM_THEN(status, change_basis(&w, rigid_dual, basis, change, figures, error));
  thrum_scope_free(&w.memory);
  return status;
}

// S^T L S against U^T K U of the changed basis
static thrum_status compare_linear(const thrum_fem *fem, const thrum_model *model,
                                   const double *linear, thrum_imported_figures *figures,
                                   thrum_error *error) {
  const int64_t r = model->rank;

  // the stiffness of this mesh and material in the changed basis
  double *own = NULL;
  THRUM_TRY(thrum_reserve(&own, r * r, sizeof *own, "the imported polynomial", error));
  thrum_status status = thrum_reduced_stiffness(fem, r, model->basis, own, error);

  // their relative difference in the Frobenius norm
  double off = 0, size = 0;
  for (int64_t n = 0; n < r * r && status >= 0; n++) {
    off += (linear[n] - own[n]) * (linear[n] - own[n]);
    size += own[n] * own[n];
  }

  free(own);
  figures->linear_difference = sqrt(off / size);
  if (status >= 0 && !(figures->linear_difference <= TOLERANCE))
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "the linear part of the imported polynomial differs from U^T K U by %.2g "
        "of it: mesh, material or --fix are not those it was made with",
        figures->linear_difference);
  return status;
}

// V at large displacements both ways against the body's
static thrum_status compare_energy(const thrum_fem *fem, const thrum_model *model,
                                   thrum_imported_figures *figures, thrum_error *error) {
  const int64_t r = model->rank, rows = 3 * fem->vertex_count;
  thrum_scope memory = thrum_scope_begin("the imported polynomial", error);
  double *q = thrum_scope_allocate(&memory, r, sizeof *q);
  double *u = thrum_scope_allocate(&memory, rows, sizeof *u);
  double *scratch =
      thrum_scope_allocate(&memory, (int64_t)thrum_work_count(model), sizeof *scratch);

  // one displacement u = U q in which every mode has the same energy, and the size of the body
  // beside it
  double low = INFINITY, high = -INFINITY, largest = 0;
  for (int64_t c = 0; scratch && c < rows; c++) {
    u[c] = 0;
    // every mode at the same energy, signs alternating
    for (int64_t i = 0; i < r; i++) {
      q[i] = (i % 2 == 0 ? 1 : -1) / sqrt(fmax(model->omega2[i], 1e-12 * model->omega2[r - 1]));
      u[c] += model->basis[c * r + i] * q[i];
    }
    largest = fmax(largest, fabs(u[c]));
    low = fmin(low, fem->vertices[c]);
    high = fmax(high, fem->vertices[c]);
  }

  // energies are compared at a share of the body's size, and the other way at twice that
  for (int side = 0; side < 2 && scratch; side++) {
    const double scale = (side == 0 ? 1 : -2) * (side == 0 ? REACH * (high - low) / largest : 1);
    for (int64_t c = 0; c < rows; c++)
      u[c] *= scale;
    for (int64_t i = 0; i < r; i++)
      q[i] *= scale;
    const double own = thrum_fem_energy(fem, u, NULL);
    figures->energy_difference =
        fmax(figures->energy_difference, fabs(thrum_strain_energy(model, q, scratch) - own) / own);
  }

  const thrum_status status = memory.status;
  thrum_scope_free(&memory);
  THRUM_TRY(status);
  if (!(figures->energy_difference <= TOLERANCE))
    return thrum_error_set(
        error, THRUM_BAD_VALUE,
        "the energy of the imported polynomial differs from the body's by %.2g of "
        "it: it is not that of Saint Venant-Kirchhoff tetrahedra on this mesh",
        figures->energy_difference);
  return THRUM_OK;
}

thrum_status thrum_imported_polynomial(const thrum_fem *fem, const thrum_imported_basis *imported,
                                       const double *change, const thrum_model *model,
                                       double *linear, double *c3, double *c4,
                                       thrum_imported_figures *figures, thrum_error *error) {
  const int64_t r = imported->rank;
  const int n = (int)r;
  thrum_status status = THRUM_OK;

  // a changed basis takes the polynomial along: S^T L S, and the coefficients in the new
  // coordinates
  if (figures->changed) {
    double *half = NULL;
    THRUM_TRY(thrum_reserve(&half, r * r, sizeof *half, "the imported polynomial", error));
    cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, n, n, n, 1, imported->linear, n, change,
                n, 0, half, n);
    cblas_dgemm(CblasRowMajor, CblasTrans, CblasNoTrans, n, n, n, 1, change, n, half, n, 0, linear,
                n);
    free(half);
    status = thrum_polynomial_change_basis(r, change, imported->c3, imported->c4, c3, c4, error);
  } else {
    memcpy(linear, imported->linear, sizeof *linear * (size_t)(r * r));
    memcpy(c3, imported->c3, sizeof *c3 * (size_t)model->c3_count);
    memcpy(c4, imported->c4, sizeof *c4 * (size_t)model->c4_count);
  }

  figures->defect = imported->defect;
  return status >= 0 ? compare_linear(fem, model, linear, figures, error) : status;
}

thrum_status thrum_imported_check(const thrum_fem *fem, const thrum_model *model,
                                  thrum_imported_figures *figures, thrum_error *error) {
  return compare_energy(fem, model, figures, error);
}
