/* The list of problems, and known solutions that need a computation of their own.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "validation/published/published.h"

#define STEPS 4000

const published_entry published_problems[] = {
#define X(name, text) {#name, text, published_##name},
    VERIFY_PROBLEMS(X)
#undef X
};
const int64_t published_problem_count = sizeof published_problems / sizeof published_problems[0];

typedef void rates(const double given[2], const double y[4], double rate[4]);

/* y from one end of the unit interval to the other, by Runge-Kutta of order 4. */
static void integrate(rates *rates_of, const double given[2], double y[4]) {
  static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  const double h = 1.0 / STEPS;
  for (int n = 0; n < STEPS; n++) {
    double rate[4] = {0}, sum[4], trial[4];
    for (int i = 0; i < 4; i++)
      sum[i] = y[i];

    // each stage starts from the slope of the one before
    for (int s = 0; s < 4; s++) {
      for (int i = 0; i < 4; i++)
        trial[i] = y[i] + at[s] * h * rate[i];
      rates_of(given, trial, rate);
      for (int i = 0; i < 4; i++)
        sum[i] += weight[s] * h * rate[i];
    }
    for (int i = 0; i < 4; i++)
      y[i] = sum[i];
  }
}

/* y' = A y of a Timoshenko beam, given its thickness and the frequency squared: w' = phi + Q/(kGA),
 * phi' = M/(EI), M' = -Q - rho I w^2 phi, Q' = -rho A w^2 w, per unit of width, E = rho = 1. */
static void timoshenko_rates(const double given[2], const double y[4], double rate[4]) {
  const double area = given[0], square = given[1];
  const double inertia = pow(area, 3) / 12, shear = 5.0 / 6 * 0.5 * area;
  rate[0] = y[1] + y[3] / shear;
  rate[1] = y[2] / inertia;
  rate[2] = -y[3] - inertia * square * y[1];
  rate[3] = -area * square * y[0];
}

/* From the clamped end (w = phi = 0) with unit M or Q to the free one; the determinant of the M and
 * Q that arrive is zero at a frequency. */
static double timoshenko_determinant(double thickness, double omega) {
  const double given[2] = {thickness, omega * omega};
  double end[2][4] = {{0}};
  for (int start = 0; start < 2; start++) {
    // scaled so that both columns are of one size
    end[start][2 + start] = pow(thickness, 3);
    integrate(timoshenko_rates, given, end[start]);
  }
  return end[0][2] * end[1][3] - end[0][3] * end[1][2];
}

double published_timoshenko(double thickness, int n) {
  // a grid that is fine beside the first bending frequency, then bisection
  const double step = 0.05 * 3.516 * thickness / sqrt(12);
  double low = step, before = timoshenko_determinant(thickness, low);
  for (int found = 0; low < 100;) {
    const double after = timoshenko_determinant(thickness, low + step);
    if ((before < 0) != (after < 0) && ++found == n)
      break;
    low += step;
    before = after;
  }

  double high = low + step;
  for (int k = 0; k < 60; k++) {
    const double middle = 0.5 * (low + high);
    if ((timoshenko_determinant(thickness, middle) < 0) == (before < 0))
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

/* theta'' = -P cos(theta) of y = (theta, theta', deflection, shortening), given P. */
static void elastica_rates(const double given[2], const double y[4], double rate[4]) {
  rate[0] = y[1];
  rate[1] = -given[0] * cos(y[0]);
  rate[2] = sin(y[0]);
  rate[3] = 1 - cos(y[0]);
}

/* From the clamped end with this curvature; what curvature arrives. */
static double shoot(double load, double curvature, double *deflection, double *shortening) {
  const double given[2] = {load, 0};
  double y[4] = {0, curvature, 0, 0};
  integrate(elastica_rates, given, y);
  *deflection = y[2];
  *shortening = y[3];
  return y[1];
}

void published_elastica_tip(double load, double *deflection, double *shortening) {
  // the curvature at the clamp is at most load, the straight beam's
  double low = 0, high = load;
  for (int k = 0; k < 100; k++) {
    const double middle = 0.5 * (low + high);
    if (shoot(load, middle, deflection, shortening) < 0)
      low = middle;
    else
      high = middle;
  }
}

double published_duffing(double e) {
  // K(m) by the arithmetic-geometric mean (Abramowitz & Stegun 17.6)
  const double m = e / (2 * (1 + e));
  double a = 1, b = sqrt(1 - m);
  for (int n = 0; n < 8; n++) {
    const double mean = 0.5 * (a + b);
    b = sqrt(a * b);
    a = mean;
  }
  return sqrt(1 + e) * a;
}
