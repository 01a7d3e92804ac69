/* Series of the exponential and the logarithm, see elementary.h. frexp and ldexp are exact.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/elementary.h"

#include <math.h>

#define SERIES_MOST 0.1 /* size of x up to which the series alone is taken */

/* 2 (s^3/3 + s^5/5 + ...): the logarithm of (1 + s)/(1 - s) without its first term. The last term
 * of the series is below rounding for |s| < 0.18. */
static double logarithm_series(double s) {
  const double t = s * s;
  double series = 0;
  for (int k = 23; k >= 3; k -= 2)
    series = t * (1.0 / k + series);
  return 2 * s * series;
}

double thrum_beyond_logarithm(double x) {
  // log(1 + x) = 2 s + series with s = x/(2 + x), and x - 2 s = x s
  if (fabs(x) < SERIES_MOST) {
    const double s = x / (2 + x);
    return x * s - logarithm_series(s);
  }

  // 1 + x = 2^n m with m between the roots of 1/2 and 2
  int n;
  double m = frexp(1 + x, &n);
  if (m < 0.70710678118654752) {
    m *= 2;
    n--;
  }
  const double s = (m - 1) / (m + 1);
  return x - (0.69314718055994531 * n + (2 * s + logarithm_series(s)));
}

double thrum_exponential_growth(double x) {
  // beyond these the answer is -1 to rounding, and more than any number
  if (!(x >= -40))
    return isnan(x) ? x : -1;
  if (x > 710)
    return INFINITY;

  // x = 2^n y with |y| below 1/8, where the twelfth term of the series is below rounding
  int n = 0;
  frexp(x, &n);
  n = n > -3 ? n + 3 : 0;
  const double y = ldexp(x, -n);
  double series = 0;
  for (int k = 12; k >= 2; k--)
    series = y / k * (1 + series);
  double growth = y * (1 + series);

  // exp(2 y) - 1 from exp(y) - 1
  for (; n > 0; n--)
    growth *= 2 + growth;
  return growth;
}
