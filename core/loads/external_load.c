/* External loads in reduced coordinates: f = U^T f_ext.
 *
 * U has rows 3 vertex + axis (thrum/model.h), so a vertex is three rows. Gravity and base
 * excitation are U^T M 1 per axis, which the model keeps. Cost: 2 operations per entry of U that is
 * touched.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/external_load.h"

#include <inttypes.h>
#include <math.h>

#include "core/base/matrix_product.h"

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

thrum_status thrum_load_add_vertex(const thrum_model *model, int64_t vertex, const double force[3],
                                   double *reduced, thrum_error *error) {
  THRUM_TRY(require_basis(model, error));
  if (vertex < 0 || vertex >= model->vertex_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "vertex %" PRId64 " is outside 0..%" PRId64, vertex,
                           model->vertex_count - 1);
  if (first_not_finite(3, force) >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "the force at vertex %" PRId64 " is not finite",
                           vertex);
  thrum_matrix_product_transposed(3, model->rank, model->basis + 3 * vertex * model->rank, force,
                                  reduced);
  return THRUM_OK;
}

thrum_status thrum_load_add_field(const thrum_model *model, const double *forces, double *reduced,
                                  thrum_error *error) {
  THRUM_TRY(require_basis(model, error));
  int64_t bad = first_not_finite(3 * model->vertex_count, forces);
  if (bad >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "component %c of the force at vertex %" PRId64 " is not finite",
                           "xyz"[bad % 3], bad / 3);
  thrum_matrix_product_transposed(3 * model->vertex_count, model->rank, model->basis, forces,
                                  reduced);
  return THRUM_OK;
}

thrum_status thrum_load_add_gravity(const thrum_model *model, const double acceleration[3],
                                    double *reduced, thrum_error *error) {
  if (!model->axis_mass)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no array axis_mass, which a uniform acceleration needs: "
                           "precompute it from a mesh");
  if (first_not_finite(3, acceleration) >= 0)
    return thrum_error_set(error, THRUM_BAD_VALUE, "the acceleration is not finite");
  thrum_matrix_product_transposed(3, model->rank, model->axis_mass, acceleration, reduced);
  return THRUM_OK;
}

thrum_status thrum_load_add_shared(const thrum_model *model, const int32_t *vertices, int64_t count,
                                   const double force[3], double *reduced, thrum_error *error) {
  // without vertices all of them share the force
  if (vertices == NULL)
    count = model->vertex_count;
  if (model->basis == NULL) {
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so forces cannot act on its vertices");
  }
  if (count <= 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the force is given no vertices");

  // all vertices are looked at first, so that a refusal leaves `reduced` as it was
  for (int64_t n = 0; vertices != NULL && n < count; n++) {
    if (vertices[n] < 0 || vertices[n] >= model->vertex_count) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "vertex %lld is not one of the model's %lld",
                             (long long)vertices[n] + 1, (long long)model->vertex_count);
    }
  }

  // equal shares
  const double share[3] = {force[0] / (double)count, force[1] / (double)count,
                           force[2] / (double)count};
  for (int64_t n = 0; n < count; n++) {
    const int64_t vertex = vertices == NULL ? n : vertices[n];
    THRUM_TRY(thrum_load_add_vertex(model, vertex, share, reduced, error));
  }
  return THRUM_OK;
}
