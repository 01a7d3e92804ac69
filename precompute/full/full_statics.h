/* The search for equilibria of the full-order body, shared by the files full_statics*.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FULL_FULL_STATICS_H
#define THRUM_PRECOMPUTE_FULL_FULL_STATICS_H

#include "precompute/full/full_private.h"

typedef struct full_search {
  thrum_full *full;
  const thrum_full_loading *loading;
  double *from;       /* all components at the start; owned */
  const double *hold; /* forces on the free components that hold the body there; NULL: none */
  full_follower_solver solver;
  double factor;  /* where u is */
  double largest; /* correction so far, in the norm of the matrix */
  double energy;  /* V at the trial */
  double merit;   /* V - factor f u there */
  double *before; /* u a step ago */
  double *kept;   /* u at the start of the step */
  bool strict;    /* Newton takes full steps, and ends without an answer where the tangent is not
                     positive definite */
  int most;       /* of its iterations; 0: as many as it wants */
  double shift;   /* the first shift of the tangent, kept low from one iteration to the next; 0: the
                     usual ones */
  thrum_full_equilibrium *found;
  thrum_status failure; /* no memory, so that the search cannot go on; else THRUM_OK */
} full_search;

/* Gives the actuators this factor of their levels. */
void full_statics_act(thrum_full *full, double factor);

/* Residual at u under factor times the load; held components as the factor has them. */
void full_statics_evaluate(full_search *s, double factor);

/* Shows the equilibrium at s->factor to who looks at the path. */
void full_statics_visit(const full_search *s, double least, bool jumped);

/* Newton's correction into full->delta, of the tangent that is shifted until it is positive
 * definite; the slope at which the energy falls along it, NaN on failure. */
double full_statics_descend(full_search *s, thrum_error *error);

/* Along full->delta by 1 and then shorter, until the energy falls enough, or the residual where
 * rounding hides that. False, and back where it was, where no length helps. */
bool full_statics_shorten(full_search *s, double factor, double slope, double *length);

/* Newton from u down to an equilibrium at this factor; false: none was found, and u is anywhere. */
bool full_statics_newton(full_search *s, double factor, thrum_error *error);

/* The load in steps from s->factor to 1, each to a minimum of the energy, near or far. */
bool full_statics_steps(full_search *s, thrum_error *error);

/* The same along one branch as long as that is stable, with a look at each equilibrium; where it
 * loses its stability the body falls to another one (full_statics_watch.c). */
bool full_statics_watch(full_search *s, thrum_error *error);

/* The modes of least stiffness of the tangent at an equilibrium. */
typedef struct full_soft {
  int count;       /* of vectors: 3, or all components where they are fewer */
  double *vectors; /* count x free_count, unit mass, softest first; owned by memory */
  double *next;    /* the same size */
  double least;    /* least eigenvalue of the tangent [1/s^2] */
  double *memory;
} full_soft;

thrum_status full_soft_make(const thrum_full *full, full_soft *soft, thrum_error *error);
void full_soft_free(full_soft *soft); /* a zeroed one is fine */

/* Fills soft->least and the vectors at the displacement in full->place, from the vectors that are
 * there, to `tolerance` of the eigenvalue. `ready`: the linear system is prepared with the tangent
 * there. THRUM_OK also where the tangent is not positive definite. */
thrum_status full_soft_look(thrum_full *full, full_soft *soft, bool ready, double tolerance,
                            thrum_error *error);

#endif
