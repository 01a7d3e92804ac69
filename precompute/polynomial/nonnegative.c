/* Least squares of few unknowns >= 0, see nonnegative.h. The set has a Cholesky factor of its
 * products, to which an unknown adds a row; where one leaves, the rows behind it are made again.
 * Cost: count x used for each unknown that joins.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/polynomial/nonnegative.h"

#include <math.h>
#include <string.h>

#include "platform/allocate.h"

#define SINGULAR 1e-12 /* of a pivot relative to its column: what joins adds nothing */
#define RISE 1e-13     /* of the slope relative to A^T b: what is left is rounding */

/* The set while it grows. */
typedef struct growth {
  const thrum_squares *s;
  int64_t most, used;
  int64_t *places;
  double *x, *factor; /* most x most, lower, by rows */
  double *solved;     /* most */
  double *slope;      /* count: A^T (b - A x) */
  bool *taken;        /* count: in the set, or left out for good */
} growth;

static double product(const growth *g, int64_t i, int64_t j) {
  return g->s->products[i * g->s->count + j];
}

/* Row k of the factor from the unknowns before it; false: it depends on them. */
static bool factor_row(growth *g, int64_t k) {
  double *row = g->factor + k * g->most;
  const double own = product(g, g->places[k], g->places[k]);
  double pivot = own;
  for (int64_t j = 0; j < k; j++) {
    const double *before = g->factor + j * g->most;
    double sum = product(g, g->places[k], g->places[j]);
    for (int64_t i = 0; i < j; i++)
      sum -= row[i] * before[i];
    row[j] = sum / before[j];
    pivot -= row[j] * row[j];
  }

  // what is left of the column beside those before it
  if (!(pivot > SINGULAR * own))
    return false;
  row[k] = sqrt(pivot);
  return true;
}

/* The least squares over the set, unbounded, into `solved`. */
static void solve(growth *g) {
  for (int64_t k = 0; k < g->used; k++) {
    double sum = g->s->projections[g->places[k]];
    for (int64_t i = 0; i < k; i++)
      sum -= g->factor[k * g->most + i] * g->solved[i];
    g->solved[k] = sum / g->factor[k * g->most + k];
  }
  for (int64_t k = g->used - 1; k >= 0; k--) {
    g->solved[k] /= g->factor[k * g->most + k];
    for (int64_t i = 0; i < k; i++)
      g->solved[i] -= g->factor[k * g->most + i] * g->solved[k];
  }
}

/* Takes unknown k out of the set. */
static void drop(growth *g, int64_t k) {
  g->taken[g->places[k]] = false;
  g->used--;
  for (int64_t i = k; i < g->used; i++) {
    g->places[i] = g->places[i + 1];
    g->x[i] = g->x[i + 1];
  }
  for (int64_t i = k; i < g->used; i++)
    factor_row(g, i);
}

/* Goes to the least squares over the set, as far as x stays >= 0; what becomes zero leaves it. */
static void settle(growth *g) {
  for (;;) {
    solve(g);

    // the first unknown that would become negative ends the way
    double way = 1;
    int64_t first = -1;
    for (int64_t k = 0; k < g->used; k++)
      if (!(g->solved[k] > 0) && g->x[k] / (g->x[k] - g->solved[k]) < way) {
        way = g->x[k] / (g->x[k] - g->solved[k]);
        first = k;
      }
    for (int64_t k = 0; k < g->used; k++)
      g->x[k] += way * (g->solved[k] - g->x[k]);
    if (first < 0)
      return;
    drop(g, first);
  }
}

static void find_slope(growth *g) {
  memcpy(g->slope, g->s->projections, (size_t)g->s->count * sizeof *g->slope);
  for (int64_t k = 0; k < g->used; k++) {
    const double *row = g->s->products + g->places[k] * g->s->count;
    for (int64_t i = 0; i < g->s->count; i++)
      g->slope[i] -= row[i] * g->x[k];
  }
}

/* The unknown to join next; -1: none. */
static int64_t steepest(const growth *g) {
  int64_t found = -1;
  double best = 0;
  for (int64_t i = 0; i < g->s->count; i++) {
    if (g->taken[i] || !(g->slope[i] > RISE * fabs(g->s->projections[i])))
      continue;
    const double steep = g->slope[i] / sqrt(g->s->products[i * g->s->count + i]);
    if (steep > best) {
      best = steep;
      found = i;
    }
  }
  return found;
}

double thrum_squares_of(const thrum_squares *squares, int64_t used, const int64_t *places,
                        const double *x) {
  const int64_t n = squares->count;
  double sum = squares->target;
  for (int64_t k = 0; k < used; k++) {
    double row = 0;
    for (int64_t i = 0; i < k; i++)
      row += squares->products[places[k] * n + places[i]] * x[i];
    sum += x[k] * (2 * row + squares->products[places[k] * (n + 1)] * x[k] -
                   2 * squares->projections[places[k]]);
  }
  return fmax(sum, 0);
}

thrum_status thrum_nonnegative(const thrum_squares *squares, int64_t most,
                               bool (*enough)(void *context, int64_t used, const int64_t *places,
                                              const double *x),
                               void *context, int64_t *places, double *x, int64_t *used,
                               thrum_error *error) {
  thrum_scope memory = thrum_scope_begin("the cubature", error);
  growth g = {.s = squares,
              .most = most,
              .places = places,
              .x = x,
              .factor = thrum_scope_allocate(&memory, most * most, sizeof(double)),
              .solved = thrum_scope_allocate(&memory, most, sizeof(double)),
              .slope = thrum_scope_allocate(&memory, squares->count, sizeof(double)),
              .taken = thrum_scope_allocate(&memory, squares->count, sizeof(bool))};

  // each round one unknown joins, and others may leave; an unknown that leaves at once would come
  // back for ever
  int64_t rounds = 0;
  while (memory.status == THRUM_OK && g.used < most && rounds++ < 3 * most) {
    find_slope(&g);
    const int64_t next = steepest(&g);
    if (next < 0)
      break;
    g.taken[next] = true;
    places[g.used] = next;
    x[g.used] = 0;
    if (!factor_row(&g, g.used))
      continue;
    g.used++;
    settle(&g);
    if (enough(context, g.used, places, x))
      break;
  }
  *used = g.used;
  thrum_scope_free(&memory);
  return memory.status;
}
