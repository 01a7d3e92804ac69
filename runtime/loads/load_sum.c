/* Several loads together: a force shared by vertices, and the sum of the loads over one step.
 *
 * f_k = sum_l mean_l(k) d_l with d_l = U^T f_l fixed for a run (design 5): L r a step, however
 * many vertices a load touches.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "thrum/force.h"

#include "runtime/base/fp_contract.h"

thrum_status thrum_force_add_shared(const thrum_model *model, const int32_t *vertices,
                                    int64_t count, const double force[3], double *reduced,
                                    thrum_error *error) {
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
  const double share[3] = {force[0] / (double)count, force[1] / (double)count,
                           force[2] / (double)count};
  for (int64_t n = 0; n < count; n++) {
    const int64_t vertex = vertices == NULL ? n : vertices[n];
    const thrum_status status = thrum_force_add_vertex(model, vertex, share, reduced, error);
    if (status < 0)
      return status;
  }
  return THRUM_OK;
}

void thrum_load_sum(const thrum_load *loads, const double *directions, int64_t count, int64_t rank,
                    int64_t step, double dt, double *reduced) {
  for (int64_t i = 0; i < rank; i++)
    reduced[i] = 0;
  for (int64_t l = 0; l < count; l++) {
    const double mean = thrum_load_mean(&loads[l], step, dt);
    // most loads are over for most of a run
    if (mean == 0)
      continue;
    const double *direction = directions + l * rank;
    for (int64_t i = 0; i < rank; i++)
      reduced[i] += mean * direction[i];
  }
}

double thrum_load_work(const double *load, const double *q, const double *q_next, int64_t rank) {
  double work = 0;
  for (int64_t i = 0; i < rank; i++)
    work += load[i] * (q_next[i] - q[i]);
  return work;
}

double thrum_damping_loss(const thrum_model *model, double alpha, double beta, const double *q,
                          const double *q_next, double dt) {
  double loss = 0;
  for (int64_t i = 0; i < model->rank; i++) {
    const double d = q_next[i] - q[i];
    loss += (alpha + beta * model->omega2[i]) * (d * d);
  }
  return loss / dt;
}
