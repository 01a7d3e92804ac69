/* Stresses of the laws of materials in closed form (docs/mathematics/19_materials.md).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_CLOSED_FORMS_H
#define THRUM_TESTS_SUPPORT_CLOSED_FORMS_H

#include <math.h>

#include "runtime/material/material_law.h"

/* Stretch s along x, closed forms of the cross stretch t without stress across, and of P along. */
static inline double tension_form(thrum_law law, double lambda, double mu, double s, double *t) {
  const double nu = lambda / (2 * (lambda + mu)), young = 2 * mu * (1 + nu);
  if (law == THRUM_LAW_STVK) {
    *t = sqrt(1 - nu * (s * s - 1));
    return young * s * (s * s - 1) / 2;
  }
  if (law == THRUM_LAW_COROTATIONAL) {
    *t = 1 - nu * (s - 1);
    return young * (s - 1);
  }

  // neo-Hookean, x = t^2: m (1 - 1/D) + s l (s x - a) = 0 with D = s^2 + 2 x + 1, a quadratic in x
  const double m = 4.0 / 3 * mu, l = lambda + 5.0 / 6 * mu, a = 1 + 0.75 * m / l;
  const double p = 2 * l * s * s, d = s * s + 1;
  const double q = 2 * m + l * s * s * d - 2 * l * a * s, r = m * (d - 1) - l * a * s * d;
  const double x = (-q + sqrt(q * q - 4 * p * r)) / (2 * p);
  *t = sqrt(x);
  return m * (1 - 1 / (d + 2 * x)) * (s - x / s);
}

/* P_xy and P_yx of simple shear, x moved by k y. */
typedef struct shear_stress {
  double xy, yx;
} shear_stress;

static inline shear_stress shear_form(thrum_law law, double lambda, double mu, double k) {
  const double root = sqrt(4 + k * k), turned = lambda * (root - 2) * k / root;
  if (law == THRUM_LAW_STVK)
    return (shear_stress){mu * k + (lambda / 2 + mu) * k * k * k, mu * k};
  if (law == THRUM_LAW_COROTATIONAL)
    return (shear_stress){2 * mu * (k - k / root) + turned, 2 * mu * k / root - turned};
  return (shear_stress){4.0 / 3 * mu * k * (1 - 1 / (4 + k * k)), mu * k};
}

#endif
