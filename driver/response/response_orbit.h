/* A period of a reduced model under a periodic load, step by step. SPDX-License-Identifier:
 * Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_ORBIT_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_ORBIT_H

#include "thrum/model.h"

#define RESPONSE_ORBIT_STEPS 120 /* of a period of the load: their own error is near 1e-4 */

typedef struct response_orbit {
  const thrum_model *model;   /* a polynomial of all its coordinates, or points */
  const double *rates;        /* damping of each coordinate [1/s] (rank) */
  const double *const *loads; /* mean, of cos and of sin of the phase (rank each) */
  double omega;               /* of the load [rad/s] */
  int64_t periods;            /* of it that are stepped */
} response_orbit;

/* Means of cos and sin of the phase over a step. */
void response_orbit_means(int64_t step, double *cosine, double *sine);

/* Steps from q and p (rank each) at the phase 0 for these periods; `visit` gets the coordinates
 * after each of the steps, which count from 0. */
thrum_status response_orbit_run(const response_orbit *orbit, const double *q, const double *p,
                                thrum_status (*visit)(void *context, int64_t step, const double *q,
                                                      thrum_error *error),
                                void *context, thrum_error *error);

/* The coefficients of the motion of the first `rank` coordinates over that time, a_0, a_1 .. a_H,
 * b_1 .. b_H (2 H + 1 x rank): near those of a periodic motion where q and p are. */
thrum_status response_orbit_coefficients(const response_orbit *orbit, const double *q,
                                         const double *p, int64_t rank, int64_t harmonics,
                                         double *coefficients, thrum_error *error);

#endif
