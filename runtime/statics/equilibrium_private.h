/* Searches for one equilibrium, private to the runtime; see equilibrium_search.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_STATICS_EQUILIBRIUM_PRIVATE_H
#define THRUM_RUNTIME_STATICS_EQUILIBRIUM_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/polynomial/polynomial_private.h"
#include "thrum/equilibrium.h"

#define THRUM_STATIC_ROUNDING 1e-12 /* of the stiffest mode: eigenvalues within it are 0 */

/* Arrays of the workspace. X(name, size): a vector is rank long, the others as they say. */
#define THRUM_EQUILIBRIUM_ARRAYS(X)                                                                \
  X(q, vector)          /* accepted */                                                             \
  X(rate, vector)       /* dq/dfactor there */                                                     \
  X(trial, vector)      /* where a search is, and what it found */                                 \
  X(rate_next, vector)  /* dq/dfactor there */                                                     \
  X(origin, vector)     /* of a line search */                                                     \
  X(direction, vector)  /* of Newton */                                                            \
  X(force, vector)      /* R */                                                                    \
  X(residual, vector)   /* R - factor f */                                                         \
  X(scale, vector)      /* omega^2, none of them zero */                                           \
  X(soft, vector)       /* eigenvector of least stiffness */                                       \
  X(first_mode, vector) /* where the path lost its stability first */                              \
  X(predicted, vector)  /* where a step was to end */                                              \
  X(candidate, vector)  /* an unstable equilibrium beyond a critical point */                      \
  X(spare, spare)       /* 3 vectors of an eigenvalue */                                           \
  X(pivots, vector)     /* int32 */                                                                \
  X(work, work)         /* of the polynomial */                                                    \
  X(levels, levels)     /* of what acts, at the factor in force */                                 \
  X(tangent, matrix)    /* T */                                                                    \
  X(factors, matrix)    /* of T, or its tridiagonal form */

typedef struct thrum_search {
  const thrum_model *model;
  thrum_model acting; /* which is the model, with the levels above, where the caller's has levels */
  const double *actors; /* these, which grow with the load; NULL: nothing acts */
  const thrum_equilibrium_def *def;
  const struct thrum_kernel *kernel;
  const double *load;
  double load_norm; /* |f| in the norm of the residuals */
  double amplitude; /* largest |q| so far, in the dual norm */
  int32_t n;        /* rank */
  thrum_equilibrium_report *report;
#define X(name, size) double *name;
  THRUM_EQUILIBRIUM_ARRAYS(X)
#undef X
} thrum_search;

/* Residual of s->trial as an equilibrium under factor times the load. */
typedef struct thrum_search_measure {
  double norm;   /* norm of the residual: sqrt(sum g_i^2 / scale_i) */
  double merit;  /* V - factor f q */
  double energy; /* V */
} thrum_search_measure;

/* Gives what acts this factor of its levels; nothing where nothing acts. */
void thrum_search_act(thrum_search *s, double factor);

/* f, and what the levels add to it at `q`: dR/dfactor, negated, into `load`. */
void thrum_search_load(thrum_search *s, const double *q, double *load);

/* sqrt(sum scale_i x_i^2) of x, or of x - y. */
double thrum_search_length(const thrum_search *s, const double *x, const double *y);

/* Goes from s->trial to an equilibrium near it, stable or not, by Newton steps that are shortened
 * until the residual falls. False when none is near. */
bool thrum_search_near(thrum_search *s, double factor, thrum_search_measure *found);

/* Goes from s->trial downhill to a stable equilibrium, however far it is, by Newton steps on the
 * total energy, stiffened where T is not positive definite. False when there is none within
 * reach. */
bool thrum_search_down(thrum_search *s, double factor, thrum_search_measure *found);

/* Least eigenvalue of T at `q`. With vector: its eigenvector too, into s->soft. Leaves T in
 * s->tangent. */
double thrum_search_least(thrum_search *s, const double *q, bool vector);

/* dq/dfactor at `q` into `rate`; false where T is singular. Leaves T in s->tangent. */
bool thrum_search_rate(thrum_search *s, const double *q, double *rate);

#endif
