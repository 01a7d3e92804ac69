/* Where on a piece of a curve its stability changes, private to the library of responses; see
 * special_points.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SPECIAL_POINTS_H
#define THRUM_RESPONSE_SPECIAL_POINTS_H

#include "response/floquet.h"

/* Special points of one step that are told apart. */
#define THRUM_SPECIAL_MAX 8

/* A piece of the curve from one point to the next, in the direction at the first. */
typedef struct thrum_piece {
  thrum_corrector *corrector;
  thrum_floquet *floquet; /* NULL: folds alone */
  const double *normal;   /* direction at the beginning, unknowns + 1 */
  const double *tangent;  /* and at the end */
  thrum_place begin, end;
  double step;                          /* from one to the other along the normal */
  double behind;                        /* length of the curve before it, in such steps */
  int32_t unstable_begin, unstable_end; /* -1: not known */
  int sign_begin, sign_end; /* of the determinant, by factors nearby; what is found is put there */
  thrum_place at;           /* room for a point, */
  double *tangent_at;       /* and for its direction */
} thrum_piece;

/* Positions along the step, 0 to 1, with the kind of each, ascending; returns how many. */
int32_t thrum_piece_specials(thrum_piece *piece, double positions[THRUM_SPECIAL_MAX],
                             thrum_response_kind kinds[THRUM_SPECIAL_MAX]);

/* The point at a position, in piece->at; false where it is not found. */
bool thrum_piece_at(thrum_piece *piece, double position);

#endif
