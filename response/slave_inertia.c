/* Inertia and damping of what follows, docs/mathematics/21 (8) and 17: the slaves are y(x),
 * quadratic in the masters, J = dy/dx and G = d2y/dx2, which is constant. They take
 *
 *   J^T (y'' + d y'),   y' = J x',   y'' = J x'' + x'^T G x',
 *
 * of the masters, which is cubic, so harmonic balance by 4 H + 1 samples stays exact. Its
 * derivatives are A = G (y'' + d y') + J^T (G x'' + d G x') by x, B = J^T (2 G x' + d J) by x', C =
 * J^T J by x''. Cost: about 10 count rank^2 operations.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/slave_inertia.h"

#include <string.h>

#include "core/base/matrix_product.h"

void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room) {
  s->second = thrum_room_take(room, s->count * s->rank * s->rank);
  s->along = thrum_room_take(room, 3 * s->count * s->rank);
  s->pull = thrum_room_take(room, s->count);
}

void thrum_slave_inertia_fill(thrum_slave_inertia *s, const thrum_model *stepped) {
  const int64_t r = s->rank, pairs = r * (r + 1) / 2;
  for (int64_t h = 0; h < s->count; h++) {
    const double *follow = stepped->follow + h * pairs;
    double *second = s->second + h * r * r;
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++, follow++) {
        const double value = stepped->follow_scale * *follow;
        second[i * r + j] = second[j * r + i] = i == j ? 2 * value : value;
      }
  }
}

double thrum_slave_inertia_force(thrum_slave_inertia *s, const double *x, const double *v,
                                 const double *a, double *force, double *loss) {
  const int64_t r = s->rank, block = s->count * r;
  double kinetic = 0, taken = 0;
  memset(s->along, 0, (size_t)(3 * block) * sizeof *s->along);
  thrum_matrix_product(block, r, s->second, x, s->along);
  thrum_matrix_product(block, r, s->second, v, s->along + block);
  thrum_matrix_product(block, r, s->second, a, s->along + 2 * block);
  for (int64_t h = 0; h < s->count; h++) {
    const double *first = s->along + h * r, *turn = first + block;
    double rate = 0, pull = 0;
    for (int64_t i = 0; i < r; i++) {
      rate += first[i] * v[i];
      pull += first[i] * a[i] + turn[i] * v[i];
    }
    kinetic += 0.5 * rate * rate;
    if (s->damping != NULL) {
      taken += s->damping[h] * rate * rate;
      pull += s->damping[h] * rate;
    }
    s->pull[h] = pull;
  }
  thrum_matrix_product_transposed(s->count, r, s->along, s->pull, force);
  *loss = taken;
  return kinetic;
}

void thrum_slave_inertia_matrices(const thrum_slave_inertia *s, double *by_x, double *by_v,
                                  double *by_a) {
  const int64_t r = s->rank, block = s->count * r;
  memset(by_v, 0, (size_t)(r * r) * sizeof *by_v);
  memset(by_a, 0, (size_t)(r * r) * sizeof *by_a);
  thrum_matrix_product_transposed(s->count, r * r, s->second, s->pull, by_x);
  for (int64_t h = 0; h < s->count; h++) {
    const double *first = s->along + h * r, *turn = first + block, *bend = turn + block;
    const double damping = s->damping != NULL ? s->damping[h] : 0;
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = 0; j < r; j++) {
        by_x[i * r + j] += first[i] * (bend[j] + damping * turn[j]);
        by_v[i * r + j] += first[i] * (2 * turn[j] + damping * first[j]);
        by_a[i * r + j] += first[i] * first[j];
      }
  }
}
