/* Several loads together: their sum over one step, and the work that they do.
 *
 * f_k = sum_l mean_l(k) d_l with d_l = U^T f_l fixed for a run (design 5): L r a step, however
 * many vertices a load touches.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "thrum/external_load.h"

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
