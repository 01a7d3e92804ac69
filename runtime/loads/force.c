/* Loads into reduced coordinates, displacements out of them: f = U^T f_ext and u = U q.
 *
 * U has rows 3 vertex + axis (thrum/model.h), so a vertex is three rows and a range of vertices is
 * one contiguous block. Gravity and shaking are U^T M 1 per axis, kept in the model.
 * Cost: 2 operations per entry of U that is touched.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "thrum/force.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "runtime/polynomial/polynomial_private.h"

#include "runtime/base/fp_contract.h"

static thrum_status require_basis(const thrum_model *model, thrum_error *error) {
  if (!model->basis)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so vertices cannot be reached: precompute it "
                           "from a mesh, or work in reduced coordinates");
  return THRUM_OK;
}

/* Index of the first value that is not finite, or -1. */
static int64_t first_not_finite(int64_t count, const double *values) {
  for (int64_t i = 0; i < count; i++)
    if (!isfinite(values[i]))
      return i;
  return -1;
}

thrum_status thrum_force_add_vertex(const thrum_model *model, int64_t vertex, const double force[3],
                                    double *reduced, thrum_error *error) {
  thrum_status status = require_basis(model, error);
  if (status < 0)
    return status;
  if (vertex < 0 || vertex >= model->vertex_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "vertex %" PRId64 " is outside 0..%" PRId64, vertex,
                           model->vertex_count - 1);
  if (first_not_finite(3, force) >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "the force at vertex %" PRId64 " is not finite",
                           vertex);
  thrum_kernel_transposed(3, model->rank, model->basis + 3 * vertex * model->rank, force, reduced);
  return THRUM_OK;
}

thrum_status thrum_force_add_field(const thrum_model *model, const double *forces, double *reduced,
                                   thrum_error *error) {
  thrum_status status = require_basis(model, error);
  if (status < 0)
    return status;
  int64_t bad = first_not_finite(3 * model->vertex_count, forces);
  if (bad >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "component %c of the force at vertex %" PRId64 " is not finite",
                           "xyz"[bad % 3], bad / 3);
  thrum_kernel_transposed(3 * model->vertex_count, model->rank, model->basis, forces, reduced);
  return THRUM_OK;
}

thrum_status thrum_force_add_gravity(const thrum_model *model, const double acceleration[3],
                                     double *reduced, thrum_error *error) {
  if (!model->axis_mass)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no array axis_mass, which a uniform acceleration needs: "
                           "precompute it from a mesh");
  if (first_not_finite(3, acceleration) >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "the acceleration is not finite");
  thrum_kernel_transposed(3, model->rank, model->axis_mass, acceleration, reduced);
  return THRUM_OK;
}

thrum_status thrum_displacement(const thrum_model *model, const double *q, int64_t first,
                                int64_t count, double *displacements, thrum_error *error) {
  thrum_status status = require_basis(model, error);
  if (status < 0)
    return status;
  // written so that no sum can overflow
  if (first < 0 || count < 0 || first > model->vertex_count || count > model->vertex_count - first)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%" PRId64 " vertices from %" PRId64 " do not lie in 0..%" PRId64, count,
                           first, model->vertex_count - 1);
  memset(displacements, 0, (size_t)(3 * count) * sizeof *displacements);
  thrum_kernel_product(3 * count, model->rank, model->basis + 3 * first * model->rank, q,
                       displacements);
  return THRUM_OK;
}
