/* Inertia and damping of what follows, in the motions of a condensed model, private to the library
 * of responses; see slave_inertia.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SLAVE_INERTIA_H
#define THRUM_RESPONSE_SLAVE_INERTIA_H

#include "response/room.h"
#include "thrum/model.h"

typedef struct thrum_slave_inertia {
  int64_t count, rank;   /* slaves, masters; count 0: there is none */
  const double *damping; /* count [1/s]; NULL: none */
  double *second;        /* count x rank x rank: d2y/dx2 */
  double *first;         /* count x rank: dy/dx at x */
  double *rows; /* count x 3 rank: what dy/dx is multiplied with in the derivatives by x, x', x'' */
  double *columns;  /* rank x count: dy/dx, transposed */
  double *products; /* 3 rank */
  double *pull;     /* count: y'' + d y' */
} thrum_slave_inertia;

/* Takes room for the arrays; count and rank are set before. */
void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room);

/* Reads how the slaves of a stepped model follow. */
void thrum_slave_inertia_fill(thrum_slave_inertia *s, const thrum_model *stepped);

/* What the slaves take of the masters at the place x with velocity v and acceleration a (rank
 * each), in force (rank), added; returns their kinetic energy, and in *loss what their damping
 * takes [W]. */
double thrum_slave_inertia_force(thrum_slave_inertia *s, const double *x, const double *v,
                                 const double *a, double *force, double *loss);

/* The derivatives of that force by x, v and a (rank x rank each), the first added, of the place of
 * the last force. */
void thrum_slave_inertia_matrices(const thrum_slave_inertia *s, double *by_x, double *by_v,
                                  double *by_a);

#endif
