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

#include "response/wide.h"

void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room) {
  s->second = thrum_room_take(room, s->count * s->rank * s->rank);
  s->by_master = thrum_room_take(room, s->count * s->rank * s->rank);
  s->first = thrum_room_take(room, s->count * s->rank);
  s->turn = thrum_room_take(room, s->count * s->rank);
  s->bend = thrum_room_take(room, s->count * s->rank);
  s->rows = thrum_room_take(room, 3 * s->count * s->rank);
  s->columns = thrum_room_take(room, s->rank * s->count);
  s->products = thrum_room_take(room, 3 * s->rank);
  s->pull = thrum_room_take(room, s->count);
  s->twice = thrum_room_take(room, s->count);
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
    for (int64_t j = 0; j < r; j++)
      memcpy(s->by_master + (j * s->count + h) * r, second + j * r, (size_t)r * sizeof *second);
  }
}

/* Fills what the derivatives are made of: rows of d2y/dx2 a + d y', of 2 y' by v and d dy/dx, and
 * of dy/dx. */
static void prepare(thrum_slave_inertia *s, const double *a) {
  const int64_t r = s->rank;
  for (int64_t h = 0; h < s->count; h++)
    for (int64_t i = 0; i < r; i++)
      s->bend[h * r + i] = s->damping != NULL ? s->damping[h] * s->turn[h * r + i] : 0;
  thrum_wide_product(r, s->count * r, s->by_master, a, s->bend);
  for (int64_t h = 0; h < s->count; h++) {
    const double *first = s->first + h * r, *turn = s->turn + h * r, *bend = s->bend + h * r;
    const double damping = s->damping != NULL ? s->damping[h] : 0;
    double *row = s->rows + 3 * h * r;
    for (int64_t i = 0; i < r; i++) {
      row[i] = bend[i];
      row[r + i] = 2 * turn[i] + damping * first[i];
      row[2 * r + i] = first[i];
    }
  }
}

double thrum_slave_inertia_force(thrum_slave_inertia *s, const double *x, const double *v,
                                 const double *a, bool derivatives, double *force, double *loss) {
  const int64_t r = s->rank, all = s->count * r;
  double kinetic = 0, taken = 0;

  // dy/dx, and what the velocity makes of it, of all slaves in one pass
  memset(s->first, 0, (size_t)all * sizeof *s->first);
  memset(s->turn, 0, (size_t)all * sizeof *s->turn);
  thrum_wide_product(r, all, s->by_master, x, s->first);
  thrum_wide_product(r, all, s->by_master, v, s->turn);

  for (int64_t h = 0; h < s->count; h++) {
    const double *first = s->first + h * r, *turn = s->turn + h * r;
    const double damping = s->damping != NULL ? s->damping[h] : 0;
    double rate = 0, pull = 0;
    for (int64_t i = 0; i < r; i++) {
      rate += first[i] * v[i];
      pull += first[i] * a[i] + turn[i] * v[i];
    }
    kinetic += 0.5 * rate * rate;
    taken += damping * rate * rate;
    s->pull[h] = pull + damping * rate;
    s->twice[h] = 2 * pull + damping * rate;
  }
  if (derivatives)
    prepare(s, a);
  thrum_wide_product(s->count, r, s->first, s->pull, force);
  *loss = taken;
  return kinetic;
}

void thrum_slave_inertia_turn(const thrum_slave_inertia *s, double *turn) {
  thrum_wide_product(s->count, s->rank, s->first, s->twice, turn);
}

void thrum_slave_inertia_matrices(const thrum_slave_inertia *s, double *by_x, double *by_v,
                                  double *by_a) {
  const int64_t r = s->rank;
  thrum_wide_product(s->count, r * r, s->second, s->pull, by_x);
  for (int64_t h = 0; h < s->count; h++)
    for (int64_t i = 0; i < r; i++)
      s->columns[i * s->count + h] = s->first[h * r + i];

  // a row of all three at once
  for (int64_t i = 0; i < r; i++) {
    double *products = s->products;
    memset(products, 0, (size_t)(3 * r) * sizeof *products);
    thrum_wide_product(s->count, 3 * r, s->rows, s->columns + i * s->count, products);
    for (int64_t j = 0; j < r; j++) {
      by_x[i * r + j] += products[j];
      by_v[i * r + j] = products[r + j];
      by_a[i * r + j] = products[2 * r + j];
    }
  }
}
