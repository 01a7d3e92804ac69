/* The numbers of an inertia, and what a step takes from them; private to the runtime, see
 * inertia.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_FRAMES_INERTIA_PRIVATE_H
#define THRUM_RUNTIME_FRAMES_INERTIA_PRIVATE_H

#include "thrum/inertia.h"

/* Sums are over the mass matrix: sum m a b for fields a, b is a^T M b. r is the rank. */
struct thrum_inertia {
  int64_t rank;
  double rest[9];  /* sum m X X^T, X from the centre of mass [kg m^2] */
  double *linear;  /* r x 9: A_i = sum m X U_i^T [kg^1/2 m] */
  double *pairs;   /* r x 9 r, row j: sum m U_j U_i^T for i = 0, 1, ... [1] */
  double *crosses; /* r x 3 r, row j: S_ji = sum m U_j x U_i for i = 0, 1, ... [1] */
  double numbers[];
};

/* The sum of the cross products of the fields a and b whose sum m a b^T is given. */
static inline void thrum_inertia_cross(const double moment[9], double cross[3]) {
  cross[0] = moment[5] - moment[7];
  cross[1] = moment[6] - moment[2];
  cross[2] = moment[1] - moment[3];
}

/* I(q) of D_i = sum m x U_i^T (r x 9) at the shape q. */
void thrum_inertia_of_moments(const thrum_inertia *inertia, const double *q, const double *moments,
                              double tensor[9]);

#endif
