/* Lame's constants of an isotropic material. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_LAME_H
#define THRUM_CORE_BASE_LAME_H

typedef struct thrum_lame {
  double lambda, mu; /* [Pa] */
} thrum_lame;

/* By Young's modulus [Pa] and Poisson's ratio; linear in the modulus. */
static inline thrum_lame thrum_lame_of(double young, double poisson) {
  return (thrum_lame){young * poisson / ((1 + poisson) * (1 - 2 * poisson)),
                      young / (2 * (1 + poisson))};
}

/* How they change with Poisson's ratio. */
static inline thrum_lame thrum_lame_by_poisson(double young, double poisson) {
  const double wider = 1 + poisson, narrower = 1 - 2 * poisson;
  return (thrum_lame){young * (1 + 2 * poisson * poisson) / (wider * wider * narrower * narrower),
                      -young / (2 * wider * wider)};
}

#endif
