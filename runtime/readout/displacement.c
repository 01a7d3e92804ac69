/* Displacements u = U q, starts of a given amplitude and the running peak of a run.
 *
 * U has rows 3 vertex + axis (thrum/model.h), so a range of vertices is one contiguous block.
 * Under q = s e_i vertex v is displaced by s U_v,i, so s = amplitude / max_v |U_v,i| gives a start
 * whose furthest vertex moves by the amplitude. For the peak of a run the bound
 *   max_v |u_v(q)| <= sum_i |q_i| max_v |U_v,i|
 * costs r and rules out most states; only the others pay for u = U q, 6 n r.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/displacement.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "core/base/matrix_product.h"

/* With THRUM_BASIS_MAX, squares of displacements stay finite. */
#define Q_MAX 1e100

static thrum_status require_basis(const thrum_model *model, const void *output,
                                  thrum_error *error) {
  if (model == NULL || output == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model or an output is NULL");
  if (model->basis != NULL)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_MISSING,
                         "the model has no basis, so its vertices have no displacement");
}

/* Refuses coordinates that are none, or so large that a displacement would not be finite. */
static thrum_status check_q(const thrum_model *model, const double *q, thrum_error *error) {
  if (q == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "q is NULL");
  for (int64_t i = 0; i < model->rank; i++)
    if (!(fabs(q[i]) <= Q_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "entry %" PRId64 " of q is %g, not a number within %g", i, q[i],
                             Q_MAX);
  return THRUM_OK;
}

thrum_status thrum_displacement(const thrum_model *model, const double *q, int64_t first,
                                int64_t count, double *displacements, thrum_error *error) {
  THRUM_TRY(require_basis(model, displacements, error));
  THRUM_TRY(check_q(model, q, error));

  // written so that no sum can overflow
  if (first < 0 || count < 0 || first > model->vertex_count || count > model->vertex_count - first)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%" PRId64 " vertices from %" PRId64 " do not lie in 0..%" PRId64, count,
                           first, model->vertex_count - 1);
  memset(displacements, 0, (size_t)(3 * count) * sizeof *displacements);
  thrum_matrix_product(3 * count, model->rank, model->basis + 3 * first * model->rank, q,
                       displacements);
  return THRUM_OK;
}

/* Largest vertex displacement under a unit of basis vector `mode`. */
static double extent(const thrum_model *model, int64_t mode) {
  double largest = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double value = model->basis[(3 * v + axis) * model->rank + mode];
      square += value * value;
    }
    if (square > largest)
      largest = square;
  }
  return sqrt(largest);
}

thrum_status thrum_mode_add(const thrum_model *model, int64_t mode, double amplitude, double *q,
                            thrum_error *error) {
  THRUM_TRY(require_basis(model, q, error));
  if (mode < 0 || mode >= model->rank) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the model has modes 1 to %lld, there is no mode %lld",
                           (long long)model->rank, (long long)mode + 1);
  }
  const double scaled = amplitude / extent(model, mode);
  // also catches a basis vector that moves nothing
  if (!isfinite(scaled) || !isfinite(q[mode] + scaled)) {
    return thrum_error_set(error, THRUM_BAD_VALUE, "mode %lld cannot be given this amplitude",
                           (long long)mode + 1);
  }
  q[mode] += scaled;
  return THRUM_OK;
}

thrum_status thrum_basis_extents(const thrum_model *model, double *extents, thrum_error *error) {
  THRUM_TRY(require_basis(model, extents, error));
  for (int64_t i = 0; i < model->rank; i++)
    extents[i] = extent(model, i);
  return THRUM_OK;
}

thrum_status thrum_displacement_peak(const thrum_model *model, const double *extents,
                                     const double *q, double *length, int64_t *vertex,
                                     thrum_error *error) {
  // a bound on the displacement of any vertex tells whether to look at all
  THRUM_TRY(require_basis(model, length, error));
  THRUM_TRY(check_q(model, q, error));
  if (extents == NULL || vertex == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "extents or vertex is NULL");
  double bound = 0;
  for (int64_t i = 0; i < model->rank; i++)
    bound += fabs(q[i]) * extents[i];
  if (!(bound > *length))
    return THRUM_OK;

  // the squares of the lengths, from the largest so far
  double largest = *length * *length;
  int64_t furthest = -1;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double *row = model->basis + (3 * v + axis) * model->rank;
      double u = 0;
      for (int64_t i = 0; i < model->rank; i++)
        u += row[i] * q[i];
      square += u * u;
    }
    if (square > largest) {
      largest = square;
      furthest = v;
    }
  }

  if (furthest >= 0) {
    *length = sqrt(largest);
    *vertex = furthest;
  }
  return THRUM_OK;
}

thrum_status thrum_displacement_mean(const thrum_model *model, const int32_t *vertices,
                                     int64_t count, const double *q, double mean[3],
                                     thrum_error *error) {
  THRUM_TRY(require_basis(model, mean, error));
  THRUM_TRY(check_q(model, q, error));
  if (vertices == NULL)
    count = model->vertex_count;
  if (count <= 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the mean is of no vertices");

  // a sum in doubles, in the order of the vertices
  double sum[3] = {0, 0, 0};
  for (int64_t n = 0; n < count; n++) {
    const int64_t v = vertices == NULL ? n : vertices[n];
    if (v < 0 || v >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "vertex %lld is not one of the model's %lld", (long long)v + 1,
                             (long long)model->vertex_count);
    for (int axis = 0; axis < 3; axis++) {
      const double *row = model->basis + (3 * v + axis) * model->rank;
      for (int64_t i = 0; i < model->rank; i++)
        sum[axis] += row[i] * q[i];
    }
  }

  for (int axis = 0; axis < 3; axis++)
    mean[axis] = sum[axis] / (double)count;
  return THRUM_OK;
}
