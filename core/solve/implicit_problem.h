/* The equation that an implicit step solves for its increment d of the modes first..rank-1:
 *
 *   0 = mu (d - kick) + weight (R + eta D v - f),  v = nu rate d + drift,  R at q + at d
 *
 * and its parts, shared by the implicit integrators; private to libthrum, see
 * implicit_problem.c. mu, nu and eta are 1 but for the first modes, `own` in the solver: nu = mu
 * for those of Fox-Goodwin, and eta = nu for those of energy.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_IMPLICIT_PROBLEM_H
#define THRUM_CORE_SOLVE_IMPLICIT_PROBLEM_H

#include "core/linear_algebra/secant.h"
#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* Residuals below this times the amplitude seen so far are rounding (design 5). */
#define THRUM_ROUNDING_FLOOR 0x1p-44

/* Tolerance of a solve where the def has none. */
#define THRUM_TOLERANCE 1e-10

typedef struct thrum_solver thrum_solver;
struct thrum_solver {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  thrum_solve_report *report;
  /* Evaluates the mean force R of the increment in view->unknown, less 2 along_step d, into
   * `evaluated`; returns P, with grad P = weight R. view->middle has q + at d and view->velocity v
   * when it is called. */
  double (*evaluate)(const thrum_solver *s);
  /* weight (dR/dd + rate beta T) of the increment evaluated last, n x n; beta T for the tangent
   * form of damping only. */
  void (*stiffness)(const thrum_solver *s, double *matrix);
  /* Both at once; NULL: they are called one after the other. */
  void (*both)(const thrum_solver *s, double *matrix);
  /* Their parts for a batch, which puts R at view->middle into `evaluated` and T into the matrix
   * itself: what follows from V there (NULL: nothing), and the stiffness from T. */
  void (*accept)(const thrum_solver *s, double potential);
  void (*weigh)(const thrum_solver *s, double *matrix);
  /* The part of the Jacobian J beyond the J0 that `stiffness` leads to: turns image = J0^-1
   * residual into image = J^-1 residual and residual = J0 image, for quasi-Newton; `first` in the
   * first call with this J0. NULL: J is J0. */
  void (*border)(const thrum_solver *s, const thrum_secant *inverse, bool first, double *residual,
                 double *image);
  /* view->force, which has R in the end. With the discrete gradient: view->force_2, which becomes
   * R(q'), and only there is the report's along_step, sigma, not zero. */
  double *evaluated;
  double at, weight, rate;
  double beside;      /* square of the scaled increment of the modes that are not solved for */
  double tolerance;   /* of the residual left, relative to the increment */
  int32_t cheaper;    /* iterations that are cheaper than a new Jacobian */
  int32_t past_count; /* past solves from which the first guess may extrapolate */
  int32_t first;      /* of the modes solved for */
  int32_t n;          /* how many they are */
  int32_t own;        /* how many of the first modes have a mu, nu and eta of their own */
  bool tangent;       /* damping in tangent form */
  bool carries;       /* the solve ends at an evaluated increment, with a correction left over */
};

/* The problem for the modes from `first` on, with R and stiffness of the whole model; the caller
 * fills kick, drift is zero, and each mu, nu and eta is 1. The midpoint rule has at = 1/2, weight =
 * h^2/2, rate = 1/h and the kick h p. */
thrum_solver thrum_problem_make(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report, int32_t first,
                                double at, double weight, double rate);

/* Takes over the mu, nu and eta that the caller has put into view->mass, speed and drag of the
 * first `count` modes. */
void thrum_problem_take_own(thrum_solver *s, int32_t count);

/* Multiplies T of a problem that evaluates the model once into its stiffness. */
void thrum_problem_weigh(const thrum_solver *s, double *matrix);

/* Puts q + at d into view->middle and v into view->velocity, from the increment in view->unknown.
 */
void thrum_problem_place(const thrum_solver *s);

/* Puts R + D v - f into view->total and the residual into view->residual, from R in `evaluated`;
 * returns the residual's scaled norm. */
double thrum_problem_residual(const thrum_solver *s);

/* Scaled norm of the increment, in the same measure as the residual's. */
double thrum_problem_norm(const thrum_solver *s);

/* Scaled norm of a residual that ends a solve: tolerance times the norm `step` of the increment, or
 * rounding relative to the motion seen so far. */
double thrum_problem_goal(const thrum_solver *s, double step);

/* True when a residual of this norm is rounding of the motion seen so far. */
bool thrum_problem_is_rounding(const thrum_solver *s, double norm);

/* True when a residual of this norm ends the solve; then the report gets it. */
bool thrum_problem_accept(const thrum_solver *s, double norm, double step);

/* The matrix mu + weight (at T + rate eta D nu) into jacobian_next, where the stiffness may already
 * be. Without dT of the tangent form of damping. */
void thrum_problem_assemble(const thrum_solver *s, bool stiffness_there);

#endif
