/* Floquet multipliers of a periodic motion, private to the library of responses; see floquet.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_FLOQUET_H
#define THRUM_RESPONSE_FLOQUET_H

#include "response/corrector.h"

typedef struct thrum_floquet {
  thrum_balance *balance;
  int64_t steps_least, steps; /* of a period: first, and in use */
  int64_t steps_tabled;       /* so many have room in the tables */
  double *cosines, *sines;    /* 2 H + 1, at a place of Gauss */
  double *residual;           /* of the balance, not looked at */
  double *motion;             /* 2 rank x 2 rank: perturbations and their rates, by column */
  double *system;   /* 2 rank x width: the equations of a step with their right-hand sides */
  int32_t *columns; /* 2 rank: their exchanges */
  int64_t width;
  double *tangents;       /* places of Gauss, two a step, x rank x rank */
  double *drag, *inertia; /* the same of velocities and accelerations, where slaves have inertia */
  bool tabled;            /* all places of the steps in use are in these tables */
  int64_t at;             /* the first of the present step in them */
  double *product;        /* rank x 2 rank */
  double *values, *kept;  /* 2 rank pairs */
  double *q;              /* rank: the place */
} thrum_floquet;

/* Takes room for the arrays. */
void thrum_floquet_lay(thrum_floquet *f, thrum_room *room);

/* The multipliers of the motion, in f->values. False where they are not found, or depend on the
 * steps. */
bool thrum_floquet_solve(thrum_floquet *f, const thrum_place *place);

/* How many are outside of the unit circle, of the last motion; of a free one without the two that
 * are 1 for its phase and its energy. */
int32_t thrum_floquet_unstable(const thrum_floquet *f);

/* What has gone through the unit circle last: the unstable multiplier nearest to it says. */
thrum_response_kind thrum_floquet_crossing(const thrum_floquet *f);

#endif
