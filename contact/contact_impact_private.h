/* This is what the files of impacts share (contact_impact.h): the rows of an impact one after the
 * other, with the bodies as a whole on either side. Private to contact_impact*.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_IMPACT_PRIVATE_H
#define THRUM_RUNTIME_CONTACT_CONTACT_IMPACT_PRIVATE_H

#include "contact/contact_impact.h"

/* A row with its bodies. */
typedef struct thrum_impact_place {
  thrum_contact_row *row;
  const thrum_pair_row *pair;   /* that the row is of; NULL: one on an obstacle */
  thrum_contact_run *bodies[2]; /* second NULL: an obstacle */
  double arms[2][3];            /* from their centres of mass [m] */
  double velocity[3];           /* of the obstacle [m/s] */
  bool springy;                 /* it has a spring or a damper that was asked for */
} thrum_impact_place;

/* Where a loop over all rows is; it begins at {0, 0}. */
typedef struct thrum_impact_cursor {
  int64_t body, row;
} thrum_impact_cursor;

/* contact_impact_places.c: the next row; false where there is none. */
bool thrum_impact_next(const thrum_impact_rows *rows, thrum_impact_cursor *at,
                       thrum_impact_place *found);

/* contact_impact_places.c: velocity of the first place against the second, by the motion of the
 * bodies as a whole and the impulses so far. */
void thrum_impact_velocity(const thrum_impact_place *at, double out[3]);

/* contact_impact_places.c: adds an impulse on the first place, and against the second. */
void thrum_impact_push(const thrum_impact_place *at, const double impulse[3]);

/* contact_impact_newton.c: solves for the impulses of all rows of an impact at once, from those
 * that they have, to within a tolerance [m/s] or, with friction mostly, as far as its iterations
 * go. False where there are too many bodies, or where the impulses are not finite: then nothing
 * changes. */
bool thrum_impact_newton(const thrum_impact_rows *rows, double tolerance);

#endif
