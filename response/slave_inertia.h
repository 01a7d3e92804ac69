/* Inertia and damping of what follows, in the motions of a condensed model, private to the library
 * of responses; see slave_inertia.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_SLAVE_INERTIA_H
#define THRUM_RESPONSE_SLAVE_INERTIA_H

#include <stdbool.h>

#include "response/room.h"
#include "thrum/model.h"

typedef struct thrum_slave_inertia {
  int64_t count, rank, samples; /* slaves, masters, places that are kept; count 0: there is none */
  const double *damping;        /* count [1/s]; NULL: none */
  double *second;               /* count x rank x rank: d2y/dx2 */
  double *by_master;            /* rank x rank x count: the same */
  double *first, *turn;         /* samples x rank x count: dy/dx, and d2y/dx2 times the velocity */
  double *pull, *twice;         /* samples x count: y'' + d y', and 2 y'' + d y' */
  double *rate;                 /* count: y' */
  double *bend;                 /* rank x count: d2y/dx2 times the acceleration */
  double *rows; /* count x 3 rank: what dy/dx is multiplied with in the derivatives by x, x', x'' */
  double *products; /* 3 rank */
} thrum_slave_inertia;

/* Takes room for the arrays; count, rank and samples are set before. */
void thrum_slave_inertia_lay(thrum_slave_inertia *s, thrum_room *room);

/* Reads how the slaves of a stepped model follow. */
void thrum_slave_inertia_fill(thrum_slave_inertia *s, const thrum_model *stepped);

/* What the slaves take of the masters at the place x with velocity v and acceleration a (rank
 * each), in force (rank), added; returns their kinetic energy, and in *loss what their damping
 * takes [W]. What the derivatives need is kept as that of a sample. */
double thrum_slave_inertia_force(thrum_slave_inertia *s, int64_t sample, const double *x,
                                 const double *v, const double *a, double *force, double *loss);

/* The derivative of a sample's force by the frequency times that, in turn (rank), added: inertia
 * goes with its square, damping with the frequency itself. */
void thrum_slave_inertia_turn(const thrum_slave_inertia *s, int64_t sample, double *turn);

/* The derivatives of that force by x, v and a (rank x rank each), the first added, at a sample with
 * the acceleration a. */
void thrum_slave_inertia_matrices(thrum_slave_inertia *s, int64_t sample, const double *a,
                                  double *by_x, double *by_v, double *by_a);

#endif
