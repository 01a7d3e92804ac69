/* Newton's method in a plane across the curve: n equations of balance and one of the plane, for the
 * n coefficients and the frequency, docs/mathematics/21 (6). Regular at folds, where the frequency
 * alone would not do. The factors of an iteration serve the next while they halve the residual many
 * times over.
 *
 * Rows are divided by stiffness and inertia, columns by the size of the solution so far and by the
 * range of frequencies, so nothing depends on units. Cost: a factorisation of n + 1 rows, mostly
 * one a point.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/corrector.h"

#include <math.h>
#include <string.h>

#include "response/square_system.h"

#define ITERATIONS_MAX 25
#define SLOW 0.1     /* a residual that shrinks less in an iteration asks for factors anew */
#define ROUNDED 1e-9 /* such a residual is taken where it does not shrink any more */
#define NULL_ITERATIONS 4
#define FURTHEST 4.0 /* a step longer than so many sizes leads elsewhere */

void thrum_corrector_lay(thrum_corrector *c, thrum_room *room) {
  const int64_t n = c->balance->unknowns + 1;
  c->matrix = thrum_room_take(room, n * thrum_square_width(n, 0));
  c->residual = thrum_room_take(room, n);
  c->columns = (int32_t *)(void *)thrum_room_take(room, (n + 1) / 2);
}

double thrum_direction_product(int64_t count, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < count; i++)
    sum += a[i] * b[i];
  return sum;
}

void thrum_direction_normalise(int64_t count, double *direction) {
  const double length = sqrt(thrum_direction_product(count, direction, direction));
  for (int64_t i = 0; i < count; i++)
    direction[i] /= length;
}

/* Makes the factors at the motion of the last residual. */
static bool factor(thrum_corrector *c, const double *normal, const thrum_place *place) {
  thrum_balance *b = c->balance;
  const int64_t n = b->unknowns, width = thrum_square_width(n + 1, 0);
  thrum_balance_linearise(b, place->omega);
  for (int64_t row = 0; row < n; row++) {
    double *out = c->matrix + row * width;
    const double scale = 1 / thrum_balance_weight(b, place->omega, row);
    out[n] =
        thrum_balance_row(b, place->x, place->omega, row, scale, out) * scale * c->width / c->size;
  }
  memcpy(c->matrix + n * width, normal, (size_t)(n + 1) * sizeof *normal);
  c->factorisations++;
  return thrum_square_factor(c->matrix, n + 1, c->columns);
}

/* The scaled residual at `place`, and its largest entry; that of the plane is last and not among
 * them. */
static double look(thrum_corrector *c, const double *normal, const thrum_place *anchor,
                   double along, const thrum_place *place) {
  thrum_balance *b = c->balance;
  const int64_t n = b->unknowns;
  double largest = 0, plane = normal[n] * (place->omega - anchor->omega) / c->width - along;
  thrum_balance_residual(b, place->x, place->omega, c->residual);
  for (int64_t i = 0; i < n; i++) {
    c->residual[i] /= thrum_balance_weight(b, place->omega, i) * c->size;
    plane += normal[i] * (place->x[i] - anchor->x[i]) / c->size;
    const double size = fabs(c->residual[i]);
    largest = size > largest || isnan(size) ? size : largest;
  }
  c->residual[n] = plane;
  return largest;
}

/* Takes the step of the present residual; false where it leads far away. */
static bool take_step(thrum_corrector *c, thrum_place *place) {
  const int64_t n = c->balance->unknowns;
  thrum_square_solve(c->matrix, n + 1, c->columns, c->residual);
  if (!(thrum_direction_product(n + 1, c->residual, c->residual) < FURTHEST * FURTHEST))
    return false;
  for (int64_t i = 0; i < n; i++)
    place->x[i] -= c->size * c->residual[i];
  place->omega -= c->width * c->residual[n];
  return place->omega > 0;
}

bool thrum_corrector_solve(thrum_corrector *c, const double *normal, const thrum_place *anchor,
                           double along, thrum_place *place) {
  double before = INFINITY;
  bool made = false, fresh = false;
  for (int32_t it = 0; it <= ITERATIONS_MAX; it++) {
    const double norm = look(c, normal, anchor, along, place);
    c->last_iterations = it;
    if (!isfinite(norm))
      return false;

    // the last step costs next to nothing, and the energy balance gains digits by it
    const bool still = fresh && norm <= ROUNDED && norm > SLOW * before;
    if (made && (norm <= c->tolerance || still))
      return take_step(c, place);

    // factors that serve no more are made anew
    fresh = !made || norm > SLOW * before;
    if (fresh && !factor(c, normal, place))
      return false;
    made = true;
    before = norm;
    c->iterations++;
    if (!take_step(c, place))
      return false;
  }
  return false;
}

double thrum_corrector_residual(thrum_corrector *c, const thrum_place *place) {
  const thrum_balance *b = c->balance;
  double largest = 0;
  thrum_balance_residual(c->balance, place->x, place->omega, c->residual);
  for (int64_t i = 0; i < b->unknowns; i++)
    largest =
        fmax(largest, fabs(c->residual[i]) / (thrum_balance_weight(b, place->omega, i) * c->size));
  return largest;
}

void thrum_corrector_tangent(thrum_corrector *c, double *tangent) {
  const int64_t n = c->balance->unknowns;
  memset(tangent, 0, (size_t)n * sizeof *tangent);
  tangent[n] = 1;
  thrum_square_solve(c->matrix, n + 1, c->columns, tangent);
  thrum_direction_normalise(n + 1, tangent);
}

int thrum_corrector_sign(const thrum_corrector *c) {
  return thrum_square_sign(c->matrix, c->balance->unknowns + 1, c->columns);
}

void thrum_corrector_null(const thrum_corrector *c, double *null) {
  const int64_t n = c->balance->unknowns;
  double largest = 0;
  for (int64_t i = 0; i <= n; i++)
    null[i] = 1 / (double)(i + 1);

  // each solve leaves more of what the matrix makes small
  for (int it = 0; it < NULL_ITERATIONS; it++) {
    thrum_square_solve(c->matrix, n + 1, c->columns, null);
    thrum_direction_normalise(n + 1, null);
  }
  for (int64_t i = 0; i <= n; i++)
    largest = fabs(null[i]) > fabs(largest) ? null[i] : largest;
  for (int64_t i = 0; i <= n; i++)
    null[i] *= copysign(1, largest);
}

bool thrum_corrector_tangent_at(thrum_corrector *c, const double *normal, const thrum_place *place,
                                double *tangent) {
  thrum_balance_residual(c->balance, place->x, place->omega, c->residual);
  if (!factor(c, normal, place))
    return false;
  thrum_corrector_tangent(c, tangent);
  return true;
}
