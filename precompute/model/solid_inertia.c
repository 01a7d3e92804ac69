/* See solid_inertia.h. With X from the centre of mass, Y = (X, U_1 .. U_r) and the consistent or
 * lumped mass matrix M of the elements, all numbers are blocks of 3 x 3 of Y^T (M Y), axis by axis
 * (design 20). SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/solid_inertia.h"

#include <cblas.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "precompute/model/model_fem.h"

typedef struct solid_inertia {
  int64_t vertices, rank;
  double *columns; /* n x (rank + 1): Y; a free body has all components, in their order */
  double *images;  /* the same of M Y */
} solid_inertia;

/* Y, about the centre of mass. */
static void fill_columns(const thrum_model *model, const double *mass, const solid_inertia *s) {
  const int64_t n = 3 * s->vertices;
  double centre[3] = {0}, whole = 0;
  for (int64_t v = 0; v < s->vertices; v++) {
    whole += mass[v];
    for (int axis = 0; axis < 3; axis++)
      centre[axis] += mass[v] * model->vertices[3 * v + axis];
  }
  for (int64_t c = 0; c < n; c++) {
    s->columns[c] = model->vertices[c] - centre[c % 3] / whole;
    for (int64_t i = 0; i < s->rank; i++)
      s->columns[(1 + i) * n + c] = model->basis[c * s->rank + i];
  }
}

/* sum over the vertices of column j along a times image i along b. */
static double product(const solid_inertia *s, int64_t j, int a, int64_t i, int b) {
  const int64_t n = 3 * s->vertices;
  return cblas_ddot((int)s->vertices, s->columns + n * j + a, 3, s->images + n * i + b, 3);
}

/* sum m X X^T, then sum m X U_i^T, then sum m U_j U_i^T, each pair once, so that the table is
 * symmetric to the bit. */
static void fill_numbers(const solid_inertia *s, double *numbers) {
  const int64_t r = s->rank;
  double *pairs = numbers + 9 + 9 * r;
  for (int64_t i = 0; i <= r; i++)
    for (int k = 0; k < 9; k++)
      numbers[9 * i + k] = product(s, 0, k / 3, i, k % 3);
  for (int64_t j = 0; j < r; j++)
    for (int64_t i = j; i < r; i++)
      for (int a = 0; a < 3; a++)
        for (int b = i == j ? a : 0; b < 3; b++) {
          const double sum = product(s, 1 + j, a, 1 + i, b);
          pairs[9 * (j * r + i) + 3 * a + b] = sum;
          pairs[9 * (i * r + j) + 3 * b + a] = sum;
        }
}

thrum_status thrum_solid_inertia(const thrum_model *model, double **numbers, thrum_error *error) {
  const int64_t n = 3 * model->vertex_count, r = model->rank;
  *numbers = NULL;
  if (model->solid_count == 0 || model->rigid == NULL || model->basis == NULL)
    return THRUM_OK;
  thrum_model_fem body = {0};
  solid_inertia s = {.vertices = model->vertex_count, .rank = r};
  double *made = NULL;
  thrum_scope memory = thrum_scope_begin("the inertia of a body", error);
  double *mass = thrum_scope_allocate(&memory, s.vertices, sizeof *mass);
  s.columns = thrum_scope_allocate(&memory, n * (r + 1), sizeof *s.columns);
  s.images = thrum_scope_allocate(&memory, n * (r + 1), sizeof *s.images);
  thrum_status status = memory.status;
  THRUM_THEN(status, thrum_model_fem_create(model, &body, error));
  THRUM_THEN(status, thrum_reserve(&made, thrum_inertia_number_count(r), sizeof *made,
                                   "the inertia of a body", error));
  if (status >= 0) {
    thrum_fem_vertex_mass(&body.fem, body.kind, mass);
    fill_columns(model, mass, &s);
    thrum_sparse_product(&body.mass, s.columns, r + 1, s.images);
    fill_numbers(&s, made);
    *numbers = made;
  }
  thrum_model_fem_free(&body);
  thrum_scope_free(&memory);
  return status;
}

thrum_status thrum_solid_inertia_create(const thrum_model *model, thrum_inertia **inertia,
                                        thrum_error *error) {
  double *numbers = NULL;
  THRUM_TRY(thrum_solid_inertia(model, &numbers, error));
  thrum_model with = *model;
  if (numbers != NULL)
    with.inertia = numbers;
  const thrum_status status = thrum_inertia_create(&with, 0, NULL, inertia, error);
  free(numbers);
  return status;
}
