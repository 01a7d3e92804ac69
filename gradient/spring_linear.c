/* The stiffness of a spring to the ground in reduced coordinates (thrum/gradient.h): of the mean
 * displacement a q of its place along an axis, 1/2 (a q)^2 per N/m, so L is the sum of a a^T.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <string.h>

#include "thrum/gradient.h"

static thrum_status check_spring(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double *linear, thrum_error *error) {
  if (!model || !vertices || count < 1 || !linear)
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "the model, the vertices of a spring or linear is NULL, or there is none");
  if (!model->basis)
    return thrum_error_set(error, THRUM_MISSING, "the model has no basis to see a spring by");
  for (int64_t n = 0; n < count; n++)
    if (vertices[n] < 0 || vertices[n] >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "vertex %d of a spring is none of the model's %lld", (int)vertices[n],
                             (long long)model->vertex_count);
  return THRUM_OK;
}

thrum_status thrum_spring_linear(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double *direction, double *linear, thrum_error *error) {
  THRUM_TRY(check_spring(model, vertices, count, linear, error));
  const int64_t r = model->rank;
  memset(linear, 0, (size_t)(r * r) * sizeof *linear);
  for (int axis = 0; axis < (direction ? 1 : 3); axis++) {
    // how far each coordinate moves the place along this axis
    double along[THRUM_RANK_MAX] = {0};
    for (int64_t n = 0; n < count; n++)
      for (int d = 0; d < 3; d++) {
        const double by = (direction ? direction[d] : d == axis ? 1.0 : 0.0) / (double)count;
        for (int64_t i = 0; i < r; i++)
          along[i] += by * model->basis[(3 * (int64_t)vertices[n] + d) * r + i];
      }
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++)
        linear[i * r + j] += along[i] * along[j];
  }
  return THRUM_OK;
}
