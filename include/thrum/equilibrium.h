/* Where a body comes to rest under a load: R(q) = factor f (design 12).
 *
 * The load grows in steps from nothing, with Newton and a line search in each, so that a body that
 * is bent far is followed from its shape at rest. The least eigenvalue of T(q) tells whether the
 * equilibrium is stable; where it passes zero on the way, the body buckles or snaps through, which
 * is reported, and the path goes on from the stable equilibrium that the body falls to.
 *
 * Pure functions: the model is only read, all memory is the caller's, nothing is allocated. Any
 * thread, as long as each has a workspace of its own.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_EQUILIBRIUM_H
#define THRUM_EQUILIBRIUM_H

#include "thrum/api.h"
#include "thrum/kernel.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct thrum_equilibrium_def {
  uint32_t cookie;        /* set by thrum_default_equilibrium_def */
  double factor;          /* of the load in the end, > 0; default 1 */
  double first_step;      /* of the load, as a share of factor, in (0, 1]; default 1/8 */
  double tolerance;       /* of the residual relative to the load, in (0, 1e-2]; default 1e-10 */
  int32_t steps_max;      /* load steps tried, >= 1; default 2000 */
  int32_t iterations_max; /* of one search for an equilibrium, >= 1; default 500 */
  int32_t stay;           /* 1: stays on a path that has become unstable; 0, default: leaves it */
  thrum_kernel_id kernel; /* default the best; same bits whatever it is */
} thrum_equilibrium_def;

THRUM_API thrum_equilibrium_def thrum_default_equilibrium_def(void);

/* How the path lost its stability first. */
typedef enum thrum_instability {
  THRUM_INSTABILITY_NONE = 0,
  THRUM_INSTABILITY_BIFURCATION = 1, /* the path goes on, unstable: the body buckles */
  THRUM_INSTABILITY_LIMIT = 2        /* the path turns back: the body snaps through */
} thrum_instability;

/* One equilibrium on the way. */
typedef struct thrum_equilibrium_point {
  double factor;   /* of the load */
  double energy;   /* V(q) [J] */
  double least;    /* least eigenvalue of T(q) [1/s^2]; >= 0: stable */
  const double *q; /* rank; the path's own, only while it is visited */
  int32_t jumped;  /* 1: the body fell to this equilibrium from one that was lost */
} thrum_equilibrium_point;

typedef struct thrum_equilibrium_report {
  double factor;          /* of the load that q balances */
  double residual;        /* |R - factor f| / |factor f|, both divided by omega mode by mode */
  double energy;          /* V(q) [J] */
  double load_energy;     /* -factor f q, the potential of the load [J] */
  double least;           /* least eigenvalue of T(q) [1/s^2]: squared frequency of the softest
                             small vibration about q; < 0: the equilibrium is unstable */
  double softest;         /* the least of these along the path, and */
  double softest_factor;  /* where it was */
  double critical;        /* factor at which the path lost its stability first; NaN: it did not */
  double critical_linear; /* estimate from rest: det(T(0) + x dT) = 0, dT along the linear answer;
                             NaN where the load softens nothing, where the body bends so far before
                             that the estimate means nothing, or where a mode has omega = 0 */
  thrum_instability instability;
  int32_t jumps;      /* how often the body fell to another equilibrium */
  int32_t load_steps; /* accepted */
  int32_t cut_steps;  /* tried again with a shorter one */
  int32_t iterations; /* Newton's, all together */
  int32_t factorisations;
} thrum_equilibrium_report;

/* Bytes of workspace of thrum_equilibrium for this model. */
THRUM_API thrum_status thrum_equilibrium_size(const thrum_model *model, size_t *size,
                                              thrum_error *error);

/* Follows the equilibrium from no load to def->factor times `load` (rank, U^T f_ext). q (rank): in,
 * where to begin, zeros for the shape at rest (what lies near is first relaxed without load); out,
 * the equilibrium. mode (rank, may be NULL): the direction of least stiffness where the path lost
 * its stability first, else at q; of length 1, its largest entry positive. `workspace`:
 * thrum_equilibrium_size bytes, aligned to 64. `visit` (may be NULL) sees each equilibrium in turn.
 * THRUM_OK; THRUM_NOT_CONVERGED, where the message says how far it came, or THRUM_BAD_VALUE for
 * numbers that are not finite: q, mode and report are then as they were. */
THRUM_API thrum_status
thrum_equilibrium(const thrum_model *model, const thrum_equilibrium_def *def, const double *load,
                  double *q, double *mode, void *workspace, size_t workspace_size,
                  void (*visit)(void *context, const thrum_equilibrium_point *point), void *context,
                  thrum_equilibrium_report *report, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
