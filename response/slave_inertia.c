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
#include "response/wide.h"

void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room) {
  const int64_t all = s->count * s->rank;
  s->second = thrum_room_take(room, all * s->rank);
  s->by_master = thrum_room_take(room, all * s->rank);
  s->first = thrum_room_take(room, s->samples * all);
  s->turn = thrum_room_take(room, s->samples * all);
  s->pull = thrum_room_take(room, s->samples * s->count);
  s->twice = thrum_room_take(room, s->samples * s->count);
  s->rate = thrum_room_take(room, s->count);
  s->bend = thrum_room_take(room, all);
  s->rows = thrum_room_take(room, 3 * all);
  s->products = thrum_room_take(room, 3 * s->rank);
}

void thrum_slave_inertia_fill(thrum_slave_inertia *s, const thrum_model *stepped) {
  const int64_t r = s->rank, n = s->count, pairs = r * (r + 1) / 2;
  for (int64_t h = 0; h < n; h++) {
    const double *follow = stepped->follow + h * pairs;
    double *second = s->second + h * r * r;
    for (int64_t i = 0; i < r; i++)
      for (int64_t j = i; j < r; j++, follow++) {
        const double value = stepped->follow_scale * *follow;
        second[i * r + j] = second[j * r + i] = i == j ? 2 * value : value;
      }
    for (int64_t j = 0; j < r; j++)
      for (int64_t i = 0; i < r; i++)
        s->by_master[(j * r + i) * n + h] = second[i * r + j];
  }
}

/* The rates y' of the slaves, and y'' + d y' and 2 y'' + d y' in pull and twice, where y'' is in
 * pull; returns their kinetic energy. */
static double add_damping(thrum_slave_inertia *s, double *pull, double *twice, double *loss) {
  double kinetic = 0;
  *loss = 0;
  for (int64_t h = 0; h < s->count; h++) {
    const double rate = s->rate[h], damping = s->damping != NULL ? s->damping[h] : 0;
    kinetic += 0.5 * rate * rate;
    *loss += damping * rate * rate;
    twice[h] = 2 * pull[h] + damping * rate;
    pull[h] += damping * rate;
  }
  return kinetic;
}

double thrum_slave_inertia_force(thrum_slave_inertia *s, int64_t sample, const double *x,
                                 const double *v, const double *a, double *force, double *loss) {
  const int64_t r = s->rank, n = s->count, all = n * r;
  double *first = s->first + sample * all, *turn = s->turn + sample * all;
  double *pull = s->pull + sample * n, *twice = s->twice + sample * n;

  // dy/dx, and what the velocity makes of it, of all slaves in one pass
  memset(first, 0, (size_t)all * sizeof *first);
  memset(turn, 0, (size_t)all * sizeof *turn);
  thrum_wide_product(r, all, s->by_master, x, first);
  thrum_wide_product(r, all, s->by_master, v, turn);

  // y' and y''
  memset(s->rate, 0, (size_t)n * sizeof *s->rate);
  memset(pull, 0, (size_t)n * sizeof *pull);
  thrum_wide_product(r, n, first, v, s->rate);
  thrum_wide_product(r, n, first, a, pull);
  thrum_wide_product(r, n, turn, v, pull);
  const double kinetic = add_damping(s, pull, twice, loss);
  thrum_matrix_product(r, n, first, pull, force);
  return kinetic;
}

void thrum_slave_inertia_turn(const thrum_slave_inertia *s, int64_t sample, double *turn) {
  thrum_matrix_product(s->rank, s->count, s->first + sample * s->count * s->rank,
                       s->twice + sample * s->count, turn);
}

/* Fills what the derivatives are made of, a row for each slave: with y = dy/dx by masters, those of
 * y''
 * + d y' by x, of the same by v, and y itself. */
static void fill_rows(thrum_slave_inertia *s, const double *first, const double *turn) {
  const int64_t r = s->rank, n = s->count;
  for (int64_t i = 0; i < r; i++)
    for (int64_t h = 0; h < n; h++) {
      const double damping = s->damping != NULL ? s->damping[h] : 0;
      const double by_x = first[i * n + h], by_v = turn[i * n + h];
      double *row = s->rows + 3 * h * r + i;
      row[0] = s->bend[i * n + h] + damping * by_v;
      row[r] = 2 * by_v + damping * by_x;
      row[2 * r] = by_x;
    }
}

void thrum_slave_inertia_matrices(thrum_slave_inertia *s, int64_t sample, const double *a,
                                  double *by_x, double *by_v, double *by_a) {
  const int64_t r = s->rank, n = s->count, all = n * r;
  const double *first = s->first + sample * all;
  memset(s->bend, 0, (size_t)all * sizeof *s->bend);
  thrum_wide_product(r, all, s->by_master, a, s->bend);
  fill_rows(s, first, s->turn + sample * all);
  thrum_wide_product(n, r * r, s->second, s->pull + sample * n, by_x);

  // a row of all three at once
  for (int64_t i = 0; i < r; i++) {
    double *products = s->products;
    memset(products, 0, (size_t)(3 * r) * sizeof *products);
    thrum_wide_product(n, 3 * r, s->rows, first + i * n, products);
    for (int64_t j = 0; j < r; j++) {
      by_x[i * r + j] += products[j];
      by_v[i * r + j] = products[r + j];
      by_a[i * r + j] = products[2 * r + j];
    }
  }
}
