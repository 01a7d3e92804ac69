/* VegaFEM's binary files, little-endian:
 *   .U    int32 rows, int32 r, then U column by column in float64 (.URendering.float: float32)
 *   .cub  int32 r, r, Q, C, then float64: linear r x r, quadratic r x Q, cubic r x C
 *
 * In these the component a of the force is outermost, then come the monomials i <= j, i <= j <= k
 * in lexicographic order. The force is R_a = dV/dq_a, design (1): the coefficient of a monomial of
 * V, times how often q_a occurs in it, stands in component a under the monomial that is left. So
 * each distinct index of a monomial tells its coefficient once more; they must agree. Cost: linear
 * in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/vega_reduced.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"
#include "io/file.h"
#include "platform/allocate.h"
#include "thrum/polynomial.h"

#define TOLERANCE 1e-6 /* of the largest coefficient of the degree: no gradient beyond this */

void thrum_imported_basis_free(thrum_imported_basis *imported) {
  free(imported->basis);
  free(imported->linear);
  free(imported->c3);
  free(imported->c4);
  *imported = (thrum_imported_basis){0};
}

// rows and rank of the header; *width: bytes of a number
static thrum_status basis_shape(const char *path, const char *file, size_t size, int64_t *rows,
                                int64_t *rank, size_t *width, thrum_error *error) {
  // the header gives rows and columns
  int32_t shape[2] = {0, 0};
  if (size >= sizeof shape)
    memcpy(shape, file, sizeof shape);
  if (shape[0] < 3 || shape[0] % 3 != 0 || shape[1] < 1 || shape[1] > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s: not a basis: it must begin with 3 times the vertices and 1 to %d "
                           "columns, as two int32",
                           path, THRUM_RANK_MAX);

  // the file's length says whether the numbers are double or single
  const size_t count = (size_t)shape[0] * (size_t)shape[1];
  *width = (size - sizeof shape) / count;
  if (size != sizeof shape + count * *width || (*width != 8 && *width != 4))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s: %d rows and %d columns take %zu bytes in float64, %zu in float32, "
                           "but the file has %zu",
                           path, shape[0], shape[1], 8 + 8 * count, 8 + 4 * count, size);

  *rows = shape[0];
  *rank = shape[1];
  return THRUM_OK;
}

thrum_status thrum_vega_basis_read(const char *path, thrum_imported_basis *imported,
                                   thrum_error *error) {
  void *data = NULL;
  size_t size = 0, width = 0;
  int64_t rows = 0, rank = 0;

  // the whole file, whose header fits its size
  thrum_status status = thrum_file_read(path, &data, &size, error);
  THRUM_THEN(status, basis_shape(path, data, size, &rows, &rank, &width, error));

  // the columns of the file become rows of Thrum's layout
  double *basis = NULL;
  THRUM_THEN(status, thrum_reserve(&basis, rows * rank, sizeof *basis, "the basis", error));
  const char *next = (const char *)data + 8;
  for (int64_t i = 0; i < rank && status >= 0; i++)
    for (int64_t c = 0; c < rows; c++, next += width) {
      float single;
      memcpy(width == 8 ? (void *)(basis + c * rank + i) : (void *)&single, next, width);
      if (width == 4)
        basis[c * rank + i] = (double)single;
    }

  if (status >= 0 && !thrum_all_finite(basis, rows * rank))
    status = thrum_error_set(error, THRUM_BAD_VALUE, "%s: a number is not finite", path);

  free(data);
  if (status < 0) {
    free(basis);
    return status;
  }

  // the new basis replaces an earlier one
  thrum_imported_basis_free(imported);
  imported->rows = rows;
  imported->rank = rank;
  imported->basis = basis;
  return THRUM_OK;
}

// a coefficient of the force: that of a component a under a monomial i <= j (<= k)
typedef struct term {
  int64_t rank, a, index[3];
  int count;           // of indices
  int64_t at;          // where the potential has the coefficient of q_a times the monomial
  int times, distinct; // how often q_a occurs in that, and how many different indices it has
} term;

static void find_place(term *t) {
  int64_t index[4] = {t->a, 0, 0, 0};
  t->times = t->distinct = 1;
  for (int n = 0; n < t->count; n++) {
    const int64_t other = t->index[n];
    t->times += other == t->a;
    t->distinct += other != t->a && (n == 0 || other != t->index[n - 1]);
    int at = n + 1;
    for (; at > 0 && index[at - 1] > other; at--)
      index[at] = index[at - 1];
    index[at] = other;
  }
  t->at = t->count == 2 ? thrum_c3_index(t->rank, index[0], index[1], index[2])
                        : thrum_c4_index(t->rank, index[0], index[1], index[2], index[3]);
}

static term first_term(int64_t rank, int count) {
  term t = {.rank = rank, .count = count};
  find_place(&t);
  return t;
}

// goes on in the order of the file, components outermost, monomials in lexicographic order; behind
// the last one a is the rank
static void next_term(term *t) {
  int n = t->count - 1;
  while (n >= 0 && t->index[n] == t->rank - 1)
    n--;
  const int64_t value = n < 0 ? 0 : t->index[n] + 1;
  t->a += n < 0;
  for (n = n < 0 ? 0 : n; n < t->count; n++)
    t->index[n] = value;
  if (t->a < t->rank)
    find_place(t);
}

// the potential's coefficients of degree count + 1: the mean of what the components say. Where they
// all say the same it must be that to the last bit, so one that is not divided by 3 is the base and
// the others add their differences from it. `off`: as many numbers, zero
static void integrate(int64_t rank, int count, const double *force, double *coefficients,
                      int64_t total, double *off) {
  // the base: a component that is not divided by 3, as thirds round
  const double *component = force;
  for (term t = first_term(rank, count); t.a < rank; next_term(&t)) {
    const double says = *component++ / t.times;
    if (t.times != 3 || t.distinct == 1)
      coefficients[t.at] = says;
  }

  // the others add their differences from it, each its share
  for (term t = first_term(rank, count); t.a < rank; next_term(&t)) {
    const double says = *force++;
    if (says != t.times * coefficients[t.at])
      off[t.at] += (says / t.times - coefficients[t.at]) / t.distinct;
  }

  for (int64_t at = 0; at < total; at++)
    coefficients[at] += off[at];
}

static thrum_status integrate_both(const double *quadratic, const double *cubic,
                                   thrum_imported_basis *imported, thrum_error *error) {
  const int64_t r = imported->rank, count3 = thrum_c3_count(r), count4 = thrum_c4_count(r);
  double *off = NULL;
  THRUM_TRY(thrum_reserve(&off, count3 + count4, sizeof *off, "the polynomial", error));
  integrate(r, 2, quadratic, imported->c3, count3, off);
  integrate(r, 3, cubic, imported->c4, count4, off + count3);
  free(off);
  return THRUM_OK;
}

// refuses components that disagree
static thrum_status check_gradient(const char *path, int64_t rank, int count, const double *force,
                                   const double *coefficients, int64_t total, double *defect,
                                   thrum_error *error) {
  // the defect is measured beside the largest coefficient
  double largest = 0;
  for (int64_t n = 0; n < total; n++)
    largest = fmax(largest, fabs(coefficients[n]));

  // each component of the force against the derivative of the potential
  for (term t = first_term(rank, count); t.a < rank; next_term(&t)) {
    const double off = fabs(*force++ / t.times - coefficients[t.at]);
    if (off > TOLERANCE * largest)
      return thrum_error_set(
          error, THRUM_BAD_VALUE,
          "%s: the force is not the gradient of an energy: component %lld, %s coefficient "
          "(%lld, %lld%s) differs from the other components by %.2g of the largest",
          path, (long long)t.a + 1, count == 2 ? "quadratic" : "cubic", (long long)t.index[0] + 1,
          (long long)t.index[1] + 1, count == 2 ? "" : ", ...", off / largest);
    if (off > 0)
      *defect = fmax(*defect, off / largest);
  }
  return THRUM_OK;
}

// the linear part must be symmetric; it is made exactly so
static thrum_status take_linear(const char *path, const double *force,
                                thrum_imported_basis *imported, thrum_error *error) {
  const int64_t r = imported->rank;

  // the asymmetry is measured beside the largest entry
  double largest = 0;
  for (int64_t n = 0; n < r * r; n++)
    largest = fmax(largest, fabs(force[n]));

  // the mean of both halves is taken
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++) {
      const double off = fabs(force[i * r + j] - force[j * r + i]) / 2;
      if (off > TOLERANCE * largest)
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "%s: the force is not the gradient of an energy: its linear part is "
                               "not symmetric at (%lld, %lld)",
                               path, (long long)i + 1, (long long)j + 1);
      if (off > 0)
        imported->defect = fmax(imported->defect, off / largest);
      imported->linear[i * r + j] = (force[i * r + j] + force[j * r + i]) / 2;
    }
  return THRUM_OK;
}

static thrum_status check_sizes(const char *path, const char *file, size_t size, int64_t rank,
                                thrum_error *error) {
  // four counts, all of which follow from the rank
  int32_t sizes[4] = {0};
  if (size >= sizeof sizes)
    memcpy(sizes, file, sizeof sizes);
  const int64_t quadratic = rank * (rank + 1) / 2, cubic = thrum_c3_count(rank);
  if (sizes[0] != rank || sizes[1] != rank || sizes[2] != quadratic || sizes[3] != cubic)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s: not the polynomial of this basis of %lld columns: it must begin "
                           "with %lld, %lld, %lld, %lld as int32",
                           path, (long long)rank, (long long)rank, (long long)rank,
                           (long long)quadratic, (long long)cubic);

  // the file's length follows from them
  const size_t wanted = sizeof sizes + 8 * (size_t)(rank * (rank + quadratic + cubic));
  if (size != wanted)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "%s: has %zu bytes in place of %zu", path, size,
                           wanted);
  return THRUM_OK;
}

/* The rank that the file says itself. */
static thrum_status own_rank(const char *path, const char *file, size_t size, int64_t *rank,
                             thrum_error *error) {
  int32_t first = 0;
  if (size >= sizeof first)
    memcpy(&first, file, sizeof first);
  if (first < 1 || first > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%s: its rank is %lld, which is not from 1 to %d; is it a .cub file?",
                           path, (long long)first, THRUM_RANK_MAX);
  *rank = first;
  return THRUM_OK;
}

static thrum_status take_force(const char *path, const double *force,
                               thrum_imported_basis *imported, thrum_error *error) {
  const int64_t r = imported->rank, count3 = thrum_c3_count(r), count4 = thrum_c4_count(r);
  const double *quadratic = force + r * r, *cubic = quadratic + r * (r * (r + 1) / 2);
  if (!thrum_all_finite(force, r * (r + r * (r + 1) / 2 + count3)))
    return thrum_error_set(error, THRUM_BAD_VALUE, "%s: a number is not finite", path);
  THRUM_TRY(take_linear(path, force, imported, error));
  THRUM_TRY(integrate_both(quadratic, cubic, imported, error));
  THRUM_TRY(check_gradient(path, r, 2, quadratic, imported->c3, count3, &imported->defect, error));
  return check_gradient(path, r, 3, cubic, imported->c4, count4, &imported->defect, error);
}

thrum_status thrum_vega_cubic_read(const char *path, thrum_imported_basis *imported,
                                   thrum_error *error) {
  void *data = NULL;
  size_t size = 0;
  thrum_status status = thrum_file_read(path, &data, &size, error);

  // the whole file, of the size that the rank says: that of the basis, or without one its own
  int64_t r = imported->rank;
  if (status >= 0 && r == 0)
    status = own_rank(path, data, size, &r, error);
  thrum_imported_basis made = {.rank = r};
  THRUM_THEN(status, check_sizes(path, data, size, r, error));

  static const char what[] = "the polynomial";
  THRUM_THEN(status, thrum_reserve(&made.linear, r * r, sizeof(double), what, error));
  THRUM_THEN(status, thrum_reserve(&made.c3, thrum_c3_count(r), sizeof(double), what, error));
  THRUM_THEN(status, thrum_reserve(&made.c4, thrum_c4_count(r), sizeof(double), what, error));

  // the numbers start 16 bytes into a block of malloc, so they are aligned
  THRUM_THEN(status, take_force(path, (const double *)((const char *)data + 16), &made, error));

  free(data);
  if (status < 0) {
    thrum_imported_basis_free(&made);
    return status;
  }

  // the new polynomial replaces an earlier one, and the basis stays
  made.rows = imported->rows;
  made.basis = imported->basis;
  imported->basis = NULL;
  thrum_imported_basis_free(imported);
  *imported = made;
  return THRUM_OK;
}

thrum_status thrum_vega_basis_write(const char *path, const thrum_model *model, bool single,
                                    thrum_error *error) {
  const int64_t rows = 3 * model->vertex_count, rank = model->rank;

  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no basis to export");
  if (rows > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%s: more rows than the format can count",
                           path);

  // a column in single precision uses the memory of one in double
  thrum_file_writer writer = {0};
  double *column = NULL;
  THRUM_TRY(thrum_reserve(&column, rows, sizeof *column, "the basis", error));
  float *narrow = (float *)column;

  // the header is the number of rows and of columns
  thrum_status status = thrum_file_writer_open(path, &writer, error);
  if (status >= 0)
    status = thrum_file_writer_put(&writer, (int32_t[]){(int32_t)rows, (int32_t)rank}, 8, error);

  // one column after the other, as the format has them
  for (int64_t i = 0; i < rank && status >= 0; i++) {
    for (int64_t c = 0; c < rows; c++)
      if (single)
        narrow[c] = (float)model->basis[c * rank + i];
      else
        column[c] = model->basis[c * rank + i];
    status = thrum_file_writer_put(&writer, column, (size_t)rows * (single ? 4 : 8), error);
  }

  free(column);
  return thrum_file_writer_end(&writer, status, error);
}

// the force's components of degree `count`; returns the end
static double *differentiate(int64_t rank, int count, const double *coefficients, double *force) {
  for (term t = first_term(rank, count); t.a < rank; next_term(&t))
    *force++ = t.times * coefficients[t.at];
  return force;
}

thrum_status thrum_vega_cubic_write(const char *path, const thrum_model *model,
                                    thrum_error *error) {
  const int64_t r = model->rank, pairs = r * (r + 1) / 2, triples = thrum_c3_count(r);
  if (model->point_weights != NULL)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has cubature points and no polynomial to export: make it "
                           "without --cubature");
  if (model->c3 == NULL || model->c4 == NULL)
    return thrum_error_set(
        error, THRUM_MISSING,
        "the model was precomputed condensed: it has no polynomial of all of its "
        "coordinates to export");

  // two doubles hold the four counts of the header
  const int64_t total = r * (r + pairs + triples);
  double *file = NULL;
  THRUM_TRY(thrum_reserve(&file, total + 2, sizeof *file, "the polynomial", error));
  const int32_t sizes[4] = {(int32_t)r, (int32_t)r, (int32_t)pairs, (int32_t)triples};
  memcpy(file, sizes, sizeof sizes);

  // the linear part is diagonal in Thrum's basis; the rest is the derivative of the potential
  double *linear = file + 2;
  memset(linear, 0, sizeof *linear * (size_t)(r * r));
  for (int64_t i = 0; i < r; i++)
    linear[i * r + i] = model->omega2[i];
  differentiate(r, 3, model->c4, differentiate(r, 2, model->c3, linear + r * r));

  // the derivative of a coefficient near the end of the range is beyond it
  bool finite = true;
  for (int64_t n = 0; finite && n < total; n++)
    finite = isfinite(linear[n]);
  const thrum_status status =
      finite
          ? thrum_file_write_atomic(path, file, 8 * (size_t)(total + 2), error)
          : thrum_error_set(error, THRUM_BAD_VALUE,
                            "%s: a coefficient would be beyond the range of finite numbers", path);
  free(file);
  return status;
}
