/* The equations of a periodic motion in its Fourier coefficients, private to the library of
 * responses; see harmonic_balance.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_HARMONIC_BALANCE_H
#define THRUM_RESPONSE_HARMONIC_BALANCE_H

#include <stdbool.h>
#include <stdint.h>

#include "response/room.h"
#include "response/slave_inertia.h"
#include "thrum/response.h"

/* The mean, the cosine's and the sine's part of what acts: of a load, and of what of it changes
 * with q. */
enum { LOAD_MEAN, LOAD_COSINE, LOAD_SINE, LOAD_PARTS };

/* A matrix over a period: at the samples, and its means with cos(m tau) and sin(m tau), m = 0 .. 2
 * H. */
typedef struct thrum_spectrum {
  double *samples;    /* N x rank x rank */
  double *even, *odd; /* (2 H + 1) x rank x rank */
} thrum_spectrum;

typedef struct thrum_balance {
  const thrum_model *model;
  const double *damping; /* rank; NULL: none */
  int64_t rank, unknowns;
  int64_t harmonics; /* H */
  int64_t blocks;    /* functions: 2 H + 1; H + 1 of an even motion, which has no sines */
  int64_t samples;   /* N of a period */
  int64_t periods;   /* of the load in it */
  double *load;      /* LOAD_PARTS x rank */
  double *pull; /* LOAD_PARTS x rank x rank: the same load grows so with q; NULL: it does not, */
  bool pulls[LOAD_PARTS];       /* nor does a part for which this is false */
  double *cosines, *sines;      /* (2 H + 1) x N: cos and sin of m tau_s */
  double *q, *force;            /* N x rank */
  thrum_spectrum stiffness;     /* derivatives of the forces by the place, */
  thrum_spectrum drag, inertia; /* and those of slaves by velocity and acceleration */
  thrum_slave_inertia slaves;   /* count 0: there are none, or they have no inertia */
  double *velocity, *bend;      /* N x rank, of slaves: x' and x'' */
  double *turn;                 /* unknowns: derivative of their forces by omega */
  double *work;                 /* thrum_work_count */
  double energy; /* means over the samples of the last residual: V, and kinetic of slaves [J] */
  double loss;   /* what the damping of slaves takes [W] */
} thrum_balance;

/* Takes room for the arrays; sizes and model are set before. pulls: the load changes with q. */
void thrum_balance_lay(thrum_balance *b, bool pulls, thrum_room *room);

/* Fills the tables of cosines and sines. */
void thrum_balance_fill(thrum_balance *b);

/* Which harmonic (0: the mean) the block is of, and whether it is that of sines. */
static inline int64_t thrum_block_harmonic(const thrum_balance *b, int64_t block) {
  return block <= b->harmonics ? block : block - b->harmonics;
}
static inline bool thrum_block_sine(const thrum_balance *b, int64_t block) {
  return block > b->harmonics;
}

/* force (rank) -= the load at sample s, where the body is at q. */
void thrum_balance_subtract_load(const thrum_balance *b, int64_t s, const double *q, double *force);

/* residual (unknowns) at x (unknowns). */
void thrum_balance_residual(thrum_balance *b, const double *x, double omega, double *residual);

/* velocity and bend (rank each): the first and second derivative of the motion at sample s. */
void thrum_balance_rates(const thrum_balance *b, const double *x, double omega, int64_t s,
                         double *velocity, double *bend);

/* Makes the means of the tangents at the motion of the last residual, of which Jacobians consist.
 */
void thrum_balance_linearise(thrum_balance *b, double omega);

/* Row `row` of the Jacobian (unknowns) by x, times `scale`; the derivative by omega is returned,
 * not scaled.
 */
double thrum_balance_row(const thrum_balance *b, const double *x, double omega, int64_t row,
                         double scale, double *out);

/* Stiffness and inertia of an unknown, by which its residual is divided: omega_i^2 + (k Omega)^2.
 */
double thrum_balance_weight(const thrum_balance *b, double omega, int64_t row);

#endif
