/* The step of Newton's method and the search along it, where all rows of a contact are solved at
 * once (contact_pairs_newton.c, contact_impact_newton.c).
 *
 * The matrix has a Cholesky factor, of which rows without an element in common with the one above
 * are left as they are: those of bodies that do not touch. Cost: m^3/6 where all do.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include <math.h>

#include "runtime/contact/contact_newton.h"

#define SEARCHES_MAX 8 /* slopes along a step */
#define FLATTER 0.3    /* of the slope at the start of a step: what its end may have */
#define NARROWER 0.1   /* of what is left of a step: a search goes at least so far from its ends */

bool thrum_newton_step(int64_t m, double *matrix, const double *gradient, double *step) {
  // U^T U, row by row
  for (int64_t k = 0; k < m; k++) {
    double *restrict row = matrix + k * m;
    if (!(row[k] > 0.0) || !isfinite(row[k]))
      return false;
    const double scale = 1.0 / sqrt(row[k]);
    for (int64_t q = k; q < m; q++)
      row[q] *= scale;
    for (int64_t p = k + 1; p < m; p++) {
      double *restrict below = matrix + p * m;
      const double share = row[p];
      for (int64_t q = p; q < m && share != 0.0; q++)
        below[q] -= share * row[q];
    }
  }

  // U^T y = -gradient, then U step = y
  double square = 0.0;
  for (int64_t q = 0; q < m; q++)
    step[q] = -gradient[q];
  for (int64_t k = 0; k < m; k++) {
    const double *restrict row = matrix + k * m;
    step[k] /= row[k];
    for (int64_t q = k + 1; q < m; q++)
      step[q] -= row[q] * step[k];
  }
  for (int64_t k = m - 1; k >= 0; k--) {
    const double *restrict row = matrix + k * m;
    double sum = step[k];
    for (int64_t q = k + 1; q < m; q++)
      sum -= row[q] * step[q];
    step[k] = sum / row[k];
    square += step[k] * step[k];
  }

  // one number that is none spreads over all of them
  return isfinite(square);
}

double thrum_newton_search(thrum_newton_slope slope_at, const void *of, double start) {
  const double flat = FLATTER * fabs(start);

  // mostly the whole step
  double low = 0.0, high = 1.0, falls = start, rises = slope_at(of, 1.0), share = 1.0;
  if (!(rises > flat))
    return share;

  // regula falsi: the interval gets smaller from one side or the other
  for (int n = 1; n < SEARCHES_MAX; n++) {
    const double part = fmin(fmax(falls / (falls - rises), NARROWER), 1.0 - NARROWER);
    share = low + part * (high - low);
    const double slope = slope_at(of, share);
    if (fabs(slope) <= flat)
      break;
    if (slope > 0.0) {
      high = share;
      rises = slope;
    } else {
      low = share;
      falls = slope;
    }
  }
  return share;
}
