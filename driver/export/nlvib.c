/* The polynomial as exponents and coefficients, see nlvib.h. A monomial c z of V gives the force of
 * coordinate m the monomial z / q_m, as often as q_m stands in z. The file is of MATLAB's level 4:
 * a head of five int32, the name, and the numbers by columns. SPDX-License-Identifier: Apache-2.0
 */
#include "driver/export/nlvib.h"

#include <stdlib.h>
#include <string.h>

#include "driver/export/body_header.h"
#include "driver/model/model_meta.h"
#include "io/file.h"
#include "platform/allocate.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "thrum/polynomial.h"

#define BIG_ENDIAN_TYPE 1000 /* of a head; 0 says little-endian doubles in full */
#define NUMBERS_MAX INT32_MAX

/* What is written, and whether that went well so far. */
typedef struct output {
  thrum_file_writer writer;
  thrum_status status;
  thrum_error *error;
} output;

static void put(output *out, const void *data, size_t size) {
  THRUM_THEN(out->status, thrum_file_writer_put(&out->writer, data, size, out->error));
}

static void put_head(output *out, const char *name, int64_t rows, int64_t columns) {
  const int32_t one = 1;
  const int32_t length = (int32_t)strlen(name) + 1;
  unsigned char first = 0;
  memcpy(&first, &one, 1);
  const int32_t head[5] = {first == 1 ? 0 : BIG_ENDIAN_TYPE, (int32_t)rows, (int32_t)columns, 0,
                           length};
  put(out, head, sizeof head);
  put(out, name, (size_t)length);
}

static void put_diagonal(output *out, const char *name, const double *numbers, int64_t rank) {
  put_head(out, name, rank, rank);
  for (int64_t j = 0; j < rank; j++)
    for (int64_t i = 0; i < rank; i++) {
      const double number = i != j ? 0 : numbers != NULL ? numbers[i] : 1;
      put(out, &number, sizeof number);
    }
}

/* Products of two and of three coordinates. */
static int64_t monomials_of(int64_t rank) {
  return rank * (rank + 1) / 2 + thrum_c3_count(rank);
}

/* How often a coordinate stands among the factors of a monomial. */
static double exponent_of(const int64_t *factors, int count, int64_t coordinate) {
  double exponent = 0;
  for (int n = 0; n < count; n++)
    exponent += factors[n] == coordinate;
  return exponent;
}

/* What the force of a coordinate has of a monomial of two or three factors. */
static double coefficient_of(const thrum_model *model, const int64_t *factors, int count,
                             int64_t coordinate) {
  int64_t all[4];
  memcpy(all, factors, sizeof *all * (size_t)count);
  all[count] = coordinate;
  thrum_indices_sort(all, count + 1);
  const double *c3 = model->c3, *c4 = model->c4;
  const double own = count == 2 ? c3[thrum_c3_index(model->rank, all[0], all[1], all[2])]
                                : c4[thrum_c4_index(model->rank, all[0], all[1], all[2], all[3])];
  return own * (exponent_of(factors, count, coordinate) + 1);
}

/* A column of p or of E: products of two coordinates, then of three, the first outermost. */
static void put_column(output *out, const thrum_model *model, bool coefficients,
                       int64_t coordinate) {
  for (int count = 2; count <= 3; count++)
    for (int64_t i = 0; i < model->rank; i++)
      for (int64_t j = i; j < model->rank; j++)
        for (int64_t k = j; k < (count == 3 ? model->rank : j + 1); k++) {
          const int64_t factors[3] = {i, j, k};
          const double number = coefficients ? coefficient_of(model, factors, count, coordinate)
                                             : exponent_of(factors, count, coordinate);
          put(out, &number, sizeof number);
        }
}

/* The mean displacements of the places. */
static thrum_status put_places(output *out, const thrum_model *model, const fmu_target *places,
                               int64_t count) {
  const int64_t rank = model->rank;
  double *rows = NULL;
  if (count == 0)
    return THRUM_OK;
  if (model->basis == NULL)
    return thrum_error_set(out->error, THRUM_MISSING,
                           "--at: the model has no basis, so it does not know its places");
  THRUM_TRY(thrum_reserve(&rows, 3 * count * rank, sizeof *rows, "the places", out->error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0; n++) {
    int32_t *list = NULL;
    int64_t vertices = 0;
    status = load_target_list(model, &places[n].target, &list, &vertices, out->error);
    if (status >= 0)
      body_place(model, list, vertices, rows + 3 * n * rank);
    free(list);
  }
  if (status >= 0) {
    put_head(out, "T", 3 * count, rank);
    for (int64_t i = 0; i < rank; i++)
      for (int64_t n = 0; n < 3 * count; n++)
        put(out, &rows[n * rank + i], sizeof *rows);
  }
  free(rows);
  return status;
}

/* A polynomial of all coordinates, whose arrays a reader of the format can hold. */
static thrum_status check(const thrum_model *model, thrum_error *error) {
  const int64_t monomials = monomials_of(model->rank);
  if (model->point_count > 0 || model->slave_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "--nlvib writes a polynomial of all coordinates, and this model %s",
                           model->point_count > 0
                               ? "is summed over cubature points: precompute it without --cubature"
                               : "is condensed: export the model that it was condensed from");
  if (monomials * model->rank > NUMBERS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "--nlvib: rank %lld has more coefficients than such a file can hold",
                           (long long)model->rank);
  return THRUM_OK;
}

thrum_status nlvib_write(const char *path, const thrum_model *model, const damping_spec *damping,
                         const fmu_target *places, int64_t place_count, thrum_error *error) {
  const int64_t rank = model->rank;
  const int64_t monomials = monomials_of(rank);
  double *rates = NULL;
  output out = {.error = error};
  THRUM_TRY(check(model, error));
  THRUM_TRY(thrum_reserve(&rates, rank, sizeof *rates, "the damping", error));
  damping_spec_rates(damping, model->omega2, rank, model_meta_modes(model), rates);
  out.status = thrum_file_writer_open(path, &out.writer, error);
  if (out.status < 0) {
    free(rates);
    return out.status;
  }

  put_diagonal(&out, "M", NULL, rank);
  put_diagonal(&out, "D", rates, rank);
  put_diagonal(&out, "K", model->omega2, rank);
  put_head(&out, "p", monomials, rank);
  for (int64_t m = 0; m < rank; m++)
    put_column(&out, model, false, m);
  put_head(&out, "E", monomials, rank);
  for (int64_t m = 0; m < rank; m++)
    put_column(&out, model, true, m);
  THRUM_THEN(out.status, put_places(&out, model, places, place_count));
  free(rates);
  return thrum_file_writer_end(&out.writer, out.status, error);
}
