/* The discrete gradient of a law's energy density between two deformations, design (19.3), after
 * Gonzalez 1996, doi:10.1007/BF02440162, and 2000, doi:10.1016/S0045-7825(00)00189-4: with E the
 * Green strain, dE its change, S(E) the second Piola-Kirchhoff stress, E-bar and F-bar means,
 *   P-bar = F-bar (S(E-bar) + [density' - density - S(E-bar):dE] / |dE|^2 dE).
 * As dE = sym(F-bar^T D), D the change of F, P-bar:D is the change of the density, and P-bar
 * F-bar^T is symmetric: a body that steps with it keeps its energy and its angular momentum, and a
 * body that only turns has no stress.
 *
 * Where an end is inverted the density is no function of E. There
 *   P-bar = P(F-bar) + [density' - density - P(F-bar):D] / |dE|^2 F-bar dE
 * keeps the same, though not a body that turns free of stress.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/base/vec3.h"
#include "precompute/material/material_law_mean.h"
#include "runtime/material/principal.h"

/* |dE|^2 beside the fourth power of the least stretch, or |D|^2, below which the bracket comes from
 * quadrature: its error there, the seventh power of the change, is below rounding, and differences
 * of densities would lose digits. The stretch counts because S has a pole where it is zero. */
#define SMALL_CHANGE 1e-5

/* Where an element is inverted the bracket by quadrature is believed while it differs from the
 * difference of densities by less than this, relative to them; it is above their rounding. A
 * corotational stress jumps where the two least stretches are opposite, and quadrature fails. */
#define ROUNDING 1e-13

typedef struct change {
  thrum_law law;
  double lambda, mu;
  double by[3][3], mean[3][3];        /* D, and the mean of both G */
  double green_by[3][3], green[3][3]; /* dE, and the mean of both E */
  double (*from)[3], (*to)[3];        /* G at both ends */
  double least;                       /* principal stretch where S was taken last */
} change;

static double contract(double a[3][3], double b[3][3]) {
  return thrum_dot3(a[0], b[0]) + thrum_dot3(a[1], b[1]) + thrum_dot3(a[2], b[2]);
}

/* result = (1 + G) matrix */
static void deform(double gradient[3][3], double matrix[3][3], double result[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      result[i][j] = matrix[i][j] + gradient[i][0] * matrix[0][j] + gradient[i][1] * matrix[1][j] +
                     gradient[i][2] * matrix[2][j];
}

static bool is_upright(double g[3][3]) {
  const double f[3][3] = {{1 + g[0][0], g[0][1], g[0][2]},
                          {g[1][0], 1 + g[1][1], g[1][2]},
                          {g[2][0], g[2][1], 1 + g[2][2]}};
  return thrum_triple3(f[0], f[1], f[2]) > 0;
}

/* S at a strain whose stretches are real: an isotropic law answers along the principal axes of E,
 * as it answers to the stretches without a rotation. */
static void second_stress(change *c, double green[3][3], double stress[3][3]) {
  double axes[3][3], grown[3], stretch[3][3] = {{0}}, first[3][3], second[3];
  thrum_principal_stretches(green, grown, axes);
  for (int k = 0; k < 3; k++)
    stretch[k][k] = grown[k];
  c->least = 1 + fmin(fmin(grown[0], grown[1]), grown[2]);
  thrum_law_stress(c->law, c->lambda, c->mu, stretch, first);

  for (int k = 0; k < 3; k++)
    second[k] = first[k][k] / (1 + grown[k]);
  thrum_principal_tensor(second, axes, stress);
}

/* The stress, S or P, in the middle between both ends displaced by `share` of the change, and its
 * product with that change. */
static double power_at(change *c, bool upright, double share, double stress[3][3]) {
  double(*middle)[3] = upright ? c->green : c->mean;
  double(*by)[3] = upright ? c->green_by : c->by;
  double place[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      place[i][j] = middle[i][j] + share * by[i][j];
  if (upright)
    second_stress(c, place, stress);
  else
    thrum_law_stress(c->law, c->lambda, c->mu, place, stress);
  return contract(stress, by);
}

/* The density at both ends. */
static void take_densities(change *c, double *from, double *to) {
  double unused[3][3];
  *from = thrum_law_stress(c->law, c->lambda, c->mu, c->from, unused);
  *to = thrum_law_stress(c->law, c->lambda, c->mu, c->to, unused);
}

/* density' - density - power, where `power` is that in the middle. */
static double bracket(change *c, bool upright, double power) {
  double unused[3][3], from, to;
  double(*by)[3] = upright ? c->green_by : c->by;
  const double scale = upright ? c->least * c->least * c->least * c->least : 1;
  if (contract(by, by) > SMALL_CHANGE * scale) {
    take_densities(c, &from, &to);
    return to - from - power;
  }

  // Gauss's rule of three points along the line from end to end, less its middle
  const double place = sqrt(0.15);
  const double gauss =
      5.0 / 18 *
      (power_at(c, upright, -place, unused) + power_at(c, upright, place, unused) - 2 * power);
  if (upright)
    return gauss;

  // inverted elements are few: there both ways are compared
  take_densities(c, &from, &to);
  const double difference = to - from - power;
  return fabs(gauss - difference) > ROUNDING * (from + to) ? difference : gauss;
}

void thrum_law_mean_stress(thrum_law law, double lambda, double mu, double from[3][3],
                           double to[3][3], double stress[3][3]) {
  change c = {.law = law, .lambda = lambda, .mu = mu, .from = from, .to = to};
  double green_from[3][3], green_to[3][3], along[3][3];
  thrum_green_strain(from, green_from);
  thrum_green_strain(to, green_to);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      c.by[i][j] = to[i][j] - from[i][j];
      c.mean[i][j] = (to[i][j] + from[i][j]) / 2;
      c.green[i][j] = (green_to[i][j] + green_from[i][j]) / 2;
    }

  // dE = sym(F-bar^T D), which keeps the digits that a difference of strains loses
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      double twice = c.by[i][j] + c.by[j][i];
      for (int k = 0; k < 3; k++)
        twice += c.mean[k][i] * c.by[k][j] + c.mean[k][j] * c.by[k][i];
      c.green_by[i][j] = twice / 2;
    }

  // the stress in the middle, and what it misses of the change of energy
  const bool upright = is_upright(from) && is_upright(to);
  double middle[3][3];
  const double power = power_at(&c, upright, 0, middle);
  const double missing = bracket(&c, upright, power);
  if (upright)
    deform(c.mean, middle, stress);
  else
    memcpy(stress, middle, sizeof middle);

  // without a change there is nothing to mend
  const double square = contract(c.green_by, c.green_by);
  if (!(square > DBL_MIN))
    return;
  deform(c.mean, c.green_by, along);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      stress[i][j] += missing / square * along[i][j];
}
