/* Special points between two points of a curve.
 *
 * A fold is where the direction of the curve has no part of the frequency: its zero is found by the
 * false position of Illinois (Dowell and Jarratt 1971, doi:10.1007/BF01934364), with directions of
 * Jacobians of their own. Where the number of unstable multipliers changes, halving finds the
 * place, and the multiplier that has just left the unit circle names it. Curves cross where the
 * determinant of the equations with the direction changes its sign, which a fold does not; halving
 * finds that too, of the same equations as the points, so that the other curve can begin there.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "response/special_points.h"

#include <math.h>

#define HALVINGS 30
#define FALSE_POSITIONS 40
#define EXACT 1e-7      /* of the frequency: a place known as well is found */
#define EXACT_FOLD 1e-9 /* of the direction */
#define ONE_PLACE 0.1   /* of a step */
#define BESIDE 1e-3     /* of a step: so far from a fold stability is that of its side */
#define BEYOND 4        /* half steps outside in which a fold is looked for */

bool thrum_piece_at(thrum_piece *piece, double position) {
  const int64_t n = piece->corrector->balance->unknowns;
  const thrum_corrector *c = piece->corrector;
  thrum_place *at = &piece->at;

  // the cubic with both directions: nearer to this curve than to one that crosses it
  const double p = position, rest = 1 - p, to_end = p * p * (3 - 2 * p);
  const double first = piece->step * p * rest * rest;
  const double last =
      piece->step * p * p * -rest / thrum_direction_product(n + 1, piece->normal, piece->tangent);
  for (int64_t i = 0; i < n; i++)
    at->x[i] = piece->begin.x[i] + to_end * (piece->end.x[i] - piece->begin.x[i]) +
               c->size * (first * piece->normal[i] + last * piece->tangent[i]);
  at->omega = piece->begin.omega + to_end * (piece->end.omega - piece->begin.omega) +
              c->width * (first * piece->normal[n] + last * piece->tangent[n]);
  return thrum_corrector_solve(piece->corrector, piece->normal, &piece->begin,
                               position * piece->step, at);
}

/* The part of the frequency in the direction at a position; NaN where it is not found. */
static double turn_at(thrum_piece *piece, double position) {
  const int64_t n = piece->corrector->balance->unknowns;
  if (!thrum_piece_at(piece, position) ||
      !thrum_corrector_tangent_at(piece->corrector, piece->normal, &piece->at, piece->tangent_at))
    return NAN;
  return piece->tangent_at[n];
}

/* Position of the fold, also so many half steps outside; NaN where there is none. */
static double find_fold(thrum_piece *piece, int beyond) {
  double low = 0, high = 1;
  double at_low = turn_at(piece, low), at_high = turn_at(piece, high);

  // directions of the ends are those of factors nearby, so the fold may be outside
  const bool before = fabs(at_low) < fabs(at_high);
  for (int it = 1; it <= beyond && at_low * at_high > 0; it++) {
    if (before && 0.5 * it > piece->behind)
      return NAN;
    if (before)
      at_low = turn_at(piece, low = -0.5 * it);
    else
      at_high = turn_at(piece, high = 1 + 0.5 * it);
  }
  for (int it = 0; it < FALSE_POSITIONS && at_low * at_high < 0; it++) {
    const double middle = (low * at_high - high * at_low) / (at_high - at_low);
    const double at_middle = turn_at(piece, middle);
    if (fabs(at_middle) <= EXACT_FOLD)
      return middle;

    // where no motion is found, the nearest that was
    if (isnan(at_middle))
      return fabs(at_low) < fabs(at_high) ? low : high;

    // the end that stays twice counts half
    if (at_middle * at_high < 0) {
      low = high;
      at_low = at_high;
    } else {
      at_low *= 0.5;
    }
    high = middle;
    at_high = at_middle;
  }
  return at_low * at_high < 0 ? high : NAN;
}

/* The sign of the determinant at a position; 0 where it is not found. */
static int sign_at(thrum_piece *piece, double position) {
  return isnan(turn_at(piece, position)) ? 0 : thrum_corrector_sign(piece->corrector);
}

static int32_t unstable_at(thrum_piece *piece, double position) {
  return thrum_piece_at(piece, position) && thrum_floquet_solve(piece->floquet, &piece->at)
             ? thrum_floquet_unstable(piece->floquet)
             : -1;
}

/* Position of the branch point; NaN where there is none. The signs of the factors at hand may be of
 * places next to the ends, so a change is looked at again, as are the ends where stability changes.
 */
static double find_branch(thrum_piece *piece) {
  double low = 0, high = 1;
  const bool changes = piece->unstable_begin >= 0 && piece->unstable_end >= 0 &&
                       piece->unstable_begin != piece->unstable_end;
  if (piece->sign_begin * piece->sign_end >= 0 && !changes)
    return NAN;
  piece->sign_begin = sign_at(piece, 0);
  piece->sign_end = sign_at(piece, 1);
  if (piece->sign_begin * piece->sign_end >= 0)
    return NAN;
  for (int it = 0; it < HALVINGS && (high - low) * piece->step > EXACT; it++) {
    const double middle = 0.5 * (low + high);
    if (sign_at(piece, middle) == piece->sign_begin)
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

/* The first change of stability between `low`, where `unstable` are so, and `high`, where `behind`
 * are: its position in *position, and how many are unstable there. -1 where it is lost. */
static int32_t find_change(thrum_piece *piece, double low, int32_t unstable, double high,
                           int32_t behind, double *position, thrum_response_kind *kind) {
  const double span = fabs(piece->end.omega - piece->begin.omega) / piece->end.omega;
  for (int it = 0; it < HALVINGS && (high - low) * fmax(span, piece->step) > EXACT; it++) {
    const double middle = 0.5 * (low + high);
    const int32_t found = unstable_at(piece, middle);
    if (found < 0)
      return -1;
    if (found == unstable) {
      low = middle;
    } else {
      high = middle;
      behind = found;
    }
  }

  // the side on which more is unstable tells what has left the circle
  *position = high;
  if (unstable_at(piece, behind > unstable ? high : low) < 0)
    return -1;
  *kind = thrum_floquet_crossing(piece->floquet);
  return behind;
}

/* Puts a special point where it belongs. */
static void insert(double *positions, thrum_response_kind *kinds, int32_t *count, double position,
                   thrum_response_kind kind) {
  int32_t at = (*count)++;
  for (; at > 0 && positions[at - 1] > position; at--) {
    positions[at] = positions[at - 1];
    kinds[at] = kinds[at - 1];
  }
  positions[at] = position;
  kinds[at] = kind;
}

/* One change after the other; those through 1 are folds or branch points. */
static void find_changes(thrum_piece *piece, double low, int32_t unstable, double high,
                         int32_t behind, double *positions, thrum_response_kind *kinds,
                         int32_t *count) {
  for (int it = 1; it < THRUM_SPECIAL_MAX && unstable >= 0 && behind >= 0 && unstable != behind &&
                   *count < THRUM_SPECIAL_MAX;
       it++) {
    thrum_response_kind kind = THRUM_RESPONSE_REGULAR;
    unstable = find_change(piece, low, unstable, high, behind, &low, &kind);
    if (unstable >= 0 && kind != THRUM_RESPONSE_REGULAR && kind != THRUM_RESPONSE_BRANCH)
      insert(positions, kinds, count, low, kind);
  }
}

int32_t thrum_piece_specials(thrum_piece *piece, double positions[THRUM_SPECIAL_MAX],
                             thrum_response_kind kinds[THRUM_SPECIAL_MAX]) {
  const int64_t n = piece->corrector->balance->unknowns;
  int32_t count = 0;
  const bool turns = piece->normal[n] * piece->tangent[n] < 0;
  const double branch = find_branch(piece);
  const double fold = turns || !isnan(branch) ? find_fold(piece, turns ? BEYOND : 0) : NAN;
  const bool both = fabs(fold - branch) < ONE_PLACE;

  // what turns back where it crosses another curve has one place, which the fold gives exactly
  if (!isnan(fold))
    insert(positions, kinds, &count, fold, both ? THRUM_RESPONSE_BRANCH : THRUM_RESPONSE_FOLD);
  if (!isnan(branch) && !both)
    insert(positions, kinds, &count, branch, THRUM_RESPONSE_BRANCH);

  if (piece->floquet == NULL || piece->unstable_begin < 0 || piece->unstable_end < 0 ||
      piece->unstable_begin == piece->unstable_end)
    return count;

  // a multiplier goes through 1 at what was found: mostly that is all
  const double known = count > 0 ? positions[0] : 1;
  const double before = fmax(known - BESIDE, 0), after = fmin(known + BESIDE, 1);
  if (count == 0 || !(before > 0) || !(after < 1)) {
    find_changes(piece, 0, piece->unstable_begin, 1, piece->unstable_end, positions, kinds, &count);
    return count;
  }
  const int32_t left = unstable_at(piece, before), right = unstable_at(piece, after);
  find_changes(piece, 0, piece->unstable_begin, before, left, positions, kinds, &count);
  find_changes(piece, after, right, 1, piece->unstable_end, positions, kinds, &count);
  return count;
}
