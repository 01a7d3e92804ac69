/* Newton's method for one point of a curve, private to the library of responses; see corrector.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_CORRECTOR_H
#define THRUM_RESPONSE_CORRECTOR_H

#include "response/harmonic_balance.h"

/* A motion and its frequency. */
typedef struct thrum_place {
  double *x; /* unknowns */
  double omega;
} thrum_place;

/* Unknowns are measured by `size`, frequencies by `width`; a direction has unknowns + 1 numbers so
 * measured, that of the frequency last. */
typedef struct thrum_corrector {
  thrum_balance *balance;
  double size, width;
  double tolerance;
  double *matrix, *residual; /* unknowns + 1 rows of thrum_square_width, unknowns + 1 */
  int32_t *columns;          /* unknowns + 1 */
  int32_t iterations, factorisations;
  int32_t last_iterations; /* of the last call */
} thrum_corrector;

/* Takes room for the arrays. */
void thrum_corrector_lay(thrum_corrector *c, thrum_room *room);

/* Moves `place`, a guess, to a motion in the plane that stands on `normal`, so far `along` it from
 * `anchor`. False where it finds none near; place is then undefined. */
bool thrum_corrector_solve(thrum_corrector *c, const double *normal, const thrum_place *anchor,
                           double along, thrum_place *place);

/* The largest entry of the scaled residual at `place`, whose samples the balance then has. */
double thrum_corrector_residual(thrum_corrector *c, const thrum_place *place);

/* tangent (unknowns + 1) = the direction of the curve by the last factors, of length 1, on the side
 * of `normal`, with which they were made. */
void thrum_corrector_tangent(thrum_corrector *c, double *tangent);

/* The same at `place`, by factors of its own; false where they are singular. */
bool thrum_corrector_tangent_at(thrum_corrector *c, const double *normal, const thrum_place *place,
                                double *tangent);

/* The sign of the determinant of the last factors, 1 or -1. Where the normal points along the curve
 * it changes only at branch points. */
int thrum_corrector_sign(const thrum_corrector *c);

/* null (unknowns + 1) = the direction, of length 1, in which the last factors are next to singular,
 * where they are. */
void thrum_corrector_null(const thrum_corrector *c, double *null);

/* Length of a direction, and its product with another. */
double thrum_direction_product(int64_t count, const double *a, const double *b);
void thrum_direction_normalise(int64_t count, double *direction);

#endif
