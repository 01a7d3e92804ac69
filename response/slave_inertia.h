/* Inertia and damping of what follows, in the motions of a condensed model, private to the library
 * of responses; see slave_inertia.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SLAVE_INERTIA_H
#define THRUM_RESPONSE_SLAVE_INERTIA_H

#include <stdbool.h>

#include "response/room.h"
#include "thrum/model.h"

typedef struct thrum_slave_inertia {
  int64_t count, rank;   /* slaves, masters; count 0: there is none */
  const double *damping; /* count [1/s]; NULL: none */
  double *second;        /* count x rank x rank: d2y/dx2 */
  double *by_master;     /* rank x count x rank: the same, a row for each master */
  double *turn, *bend;   /* count x rank: d2y/dx2 times the velocity and the acceleration */
  double *first;         /* count x rank: dy/dx at x */
  double *rows; /* count x 3 rank: what dy/dx is multiplied with in the derivatives by x, x', x'' */
  double *columns;      /* rank x count: dy/dx, transposed */
  double *products;     /* 3 rank */
  double *pull, *twice; /* count: y'' + d y', and 2 y'' + d y' */
} thrum_slave_inertia;

/* Takes room for the arrays; count and rank are set before. */
void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room);

/* Reads how the slaves of a stepped model follow. */
void thrum_slave_inertia_fill(thrum_slave_inertia *s, const thrum_model *stepped);

/* What the slaves take of the masters at the place x with velocity v and acceleration a (rank
 * each), in force (rank), added; returns their kinetic energy, and in *loss what their damping
 * takes [W]. derivatives: they are asked for next. */
double thrum_slave_inertia_force(thrum_slave_inertia *s, const double *x, const double *v,
                                 const double *a, bool derivatives, double *force, double *loss);

/* The derivative of the last force by the frequency times that, in turn (rank), added: inertia goes
 * with its square, damping with the frequency itself. */
void thrum_slave_inertia_turn(const thrum_slave_inertia *s, double *turn);

/* The derivatives of that force by x, v and a (rank x rank each), the first added, of the place of
 * the last force. */
void thrum_slave_inertia_matrices(const thrum_slave_inertia *s, double *by_x, double *by_v,
                                  double *by_a);

#endif
