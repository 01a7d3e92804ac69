/* Static equilibrium of a body under a load: R(q) = factor f (design 12), or base + factor f.
 *
 * The load grows in steps from zero, with Newton and a line search in each, so that a body that
 * bends far is followed from its shape at rest. The least eigenvalue of T(q) tells whether the
 * equilibrium is stable; where it passes zero on the way, the body buckles or snaps through, which
 * is reported, and the path continues from the stable equilibrium to which the body falls.
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

/* One equilibrium on the path. */
typedef struct thrum_equilibrium_point {
  double factor;   /* factor of the load [1] */
  double energy;   /* V(q) [J] */
  double least;    /* least eigenvalue of T(q) [1/s^2]; >= 0: stable */
  const double *q; /* rank; owned by the path and valid only during the call of `visit` */
  int32_t jumped;  /* 1: the body fell to this equilibrium from an unstable one */
} thrum_equilibrium_point;

/* How an equilibrium is found. Start from thrum_default_equilibrium_def and change fields. */
typedef struct thrum_equilibrium_def {
  /* Set by thrum_default_equilibrium_def; THRUM_UNINITIALISED_DEF without it. */
  uint32_t cookie;

  /* Factor of the load at the end of the path [1]; finite and > 0, default 1. Larger: a larger load
   * and a longer path. */
  double factor;

  /* First load step as a share of factor [1]; in (0, 1], default 1/8. Larger: fewer steps where the
   * body is nearly linear, and more that have to be cut elsewhere. */
  double first_step;

  /* Residual relative to the load at which a search ends [1]; in (0, 1e-2], default 1e-10. Larger:
   * fewer iterations and a less exact equilibrium. */
  double tolerance;

  /* Largest number of load steps tried; >= 1, default 2000. Larger: a path that does not reach
   * factor is given up later. */
  int32_t steps_max;

  /* Largest number of iterations of one search for an equilibrium; >= 1, default 500. Larger: a
   * search that does not converge is given up later. */
  int32_t iterations_max;

  /* 1: the path stays on a branch that has become unstable; 0: it leaves it. Default 0. */
  int32_t stay;

  /* A load that acts all along, beside factor times the other (rank) [kg^1/2 m/s^2]; NULL, the
   * default: none. With base = R(q) of another equilibrium q, which is where the path then starts,
   * that answer is continued. */
  const double *base;

  /* Which instructions evaluate the polynomial; default the best of this machine. All kernels give
   * the same bits. */
  thrum_kernel_id kernel;

  /* Called with `context` and each equilibrium in turn, in the caller's thread; NULL, the default:
   * nothing is. */
  void (*visit)(void *context, const thrum_equilibrium_point *point);
  void *context;

  /* Gets the direction of least stiffness where the path lost its stability first, else at its end
   * (rank): it has length 1 and its largest entry is positive. NULL, the default: it is not found.
   */
  double *mode;
} thrum_equilibrium_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_equilibrium_def_init(thrum_equilibrium_def *def, size_t size);

/* The same as a value. */
static inline thrum_equilibrium_def thrum_default_equilibrium_def(void) {
  thrum_equilibrium_def def;
  thrum_equilibrium_def_init(&def, sizeof def);
  return def;
}

/* How the path lost its stability first. */
typedef enum thrum_instability {
  THRUM_INSTABILITY_NONE = 0,
  THRUM_INSTABILITY_BIFURCATION = 1, /* the path continues, unstable: the body buckles */
  THRUM_INSTABILITY_LIMIT = 2        /* the path turns back: the body snaps through */
} thrum_instability;

/* The equilibrium that was found and the path to it. */
typedef struct thrum_equilibrium_report {
  double factor;          /* factor of the load that q balances [1] */
  double residual;        /* |R - factor f| / |factor f|, both divided by omega mode by mode */
  double energy;          /* V(q) [J] */
  double load_energy;     /* -(base + factor f) q, the potential of the load [J] */
  double least;           /* least eigenvalue of T(q) [1/s^2]: squared frequency of the softest
                             small vibration about q; < 0: the equilibrium is unstable */
  double softest;         /* least value of `least` along the path [1/s^2] */
  double softest_factor;  /* factor at which it occurred */
  double critical;        /* factor at which the path lost its stability first; NaN: it did not */
  double critical_linear; /* estimate from rest: det(T(0) + x dT) = 0, dT along the linear answer;
                             NaN where the load softens no mode, where the body bends too far
                             before it for a linear estimate, or where a mode has omega = 0 */
  thrum_instability instability; /* how the path lost its stability first */
  int32_t jumps;                 /* falls to another equilibrium */
  int32_t load_steps;            /* accepted load steps */
  int32_t cut_steps;             /* load steps that were repeated with a shorter one */
  int32_t iterations;            /* Newton iterations over the whole path */
  int32_t factorisations;        /* factorisations of T over the whole path */
} thrum_equilibrium_report;

/* Bytes of workspace that thrum_equilibrium needs for this model, into *size.
 * THRUM_INVALID_ARGUMENT for NULL or a model without a valid rank. */
THRUM_API thrum_status thrum_equilibrium_size(const thrum_model *model, size_t *size,
                                              thrum_error *error);

/* Follows the equilibrium from no load to def->factor times `load` (rank, U^T f_ext,
 * [kg^1/2 m/s^2]). The levels of a model of thrum_model_actuate grow with it.
 *
 * q (rank) holds the start on entry, zeros for the shape at rest; another start is first relaxed
 * without load, or under the base. On return it holds the equilibrium. `workspace` has
 * thrum_equilibrium_size bytes, is aligned to 64 and stays the caller's.
 *
 * A failure leaves q, the def's mode and report as they were: THRUM_NOT_CONVERGED with the factor
 * that was reached, THRUM_BAD_VALUE for numbers that are not finite, THRUM_UNINITIALISED_DEF,
 * THRUM_INVALID_ARGUMENT with the field and its range, THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL. */
THRUM_API thrum_status thrum_equilibrium(const thrum_model *model, const thrum_equilibrium_def *def,
                                         const double *load, double *q, void *workspace,
                                         size_t workspace_size, thrum_equilibrium_report *report,
                                         thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
