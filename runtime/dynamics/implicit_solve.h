/* The implicit solve shared by imexv, newmark and energy, private to the runtime; see solve.c and
 * quasi.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_IMPLICIT_SOLVE_H
#define THRUM_RUNTIME_DYNAMICS_IMPLICIT_SOLVE_H

#include "runtime/dynamics/secant.h"
#include "runtime/dynamics/state_private.h"

/* Steps that make their Jacobian at once, after one that found too late that it must. */
#define THRUM_EAGER 96

/* Steps of `energy` that take the mean force of the path, after one that that of the ends did not
 * solve. */
#define THRUM_PATH 64

/* A solve for the increment d of the modes first..rank-1:
 *   0 = d - kick + weight (R + D v - f),  v = rate d + drift,  R at q + at d */
typedef struct thrum_solver thrum_solver;
struct thrum_solver {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  thrum_solve_report *report;
  /* Mean force R of the increment in view->unknown into `evaluated`, less 2 along_step d; returns
   * P, with grad P = weight R. q + at d in view->middle and v in view->velocity are up to date. */
  double (*evaluate)(const thrum_solver *s);
  /* weight (dR/dd + rate beta T), the latter for the tangent form, of the increment last evaluated:
   * n x n. */
  void (*stiffness)(const thrum_solver *s, double *matrix);
  /* Both at once; NULL: they are to be called one after the other. */
  void (*both)(const thrum_solver *s, double *matrix);
  /* What the Jacobian J has beyond the J0 that `stiffness` leads to: from image = J0^-1 residual to
   * image = J^-1 residual and residual = J0 image, for quasi-Newton; `first` with this J0 or not.
   * NULL: there is nothing. */
  void (*border)(const thrum_solver *s, const thrum_secant *inverse, bool first, double *residual,
                 double *image);
  /* view->force, where R is in the end. Energy by the ends: view->force_2, which becomes R(q'), and
   * only there is the report's along_step, sigma, not zero. */
  const double *evaluated;
  double at, weight, rate;
  int32_t cheaper;    /* how many iterations are cheaper than a Jacobian made anew */
  int32_t past_count; /* steps before whose q + at d and R the first guess may go on from */
  int32_t first;      /* of the modes solved for */
  int32_t n;          /* how many */
  bool tangent;       /* damping in tangent form */
};

/* The solver of the modes from `first` on, with the model's R and stiffness; kick is to be filled,
 * drift is zero. The midpoint rule has at = 1/2, weight = h^2/2, rate = 1/h and the kick h p. */
thrum_solver thrum_solver_of(const thrum_model *model, const thrum_state *state,
                             thrum_state_view *view, thrum_solve_report *report, int32_t first,
                             double at, double weight, double rate);

/* R of the whole model at view->middle, and its stiffness. */
double thrum_solve_force(const thrum_solver *s);
void thrum_solve_stiffness(const thrum_solver *s, double *matrix);
void thrum_solve_both(const thrum_solver *s, double *matrix);

/* Multiplies T of a solve that evaluates the model once into its stiffness. */
void thrum_solve_weigh(const thrum_solver *s, double *matrix);

/* Finds the increment: then it is in view->unknown, R in view->force, R + D v - f in view->total,
 * q + at d in view->middle and v in view->velocity. False when neither quasi-Newton nor full Newton
 * ends. */
bool thrum_solve_increment(const thrum_solver *s);

/* The same by quasi-Newton alone; R where `evaluated` says if it was evaluated there. */
bool thrum_solve_quasi(const thrum_solver *s);

/* quasi.c: quasi-Newton one evaluation at a time, so that those of several states can be made
 * together: begin, then while the answer is EVALUATE put R at view->middle into `evaluated` and
 * take. Where `ahead` is set the stiffness will be needed too, and may be put into jacobian_next,
 * which `assembled` then says. STUCK is for thrum_solve_newton. */
typedef struct thrum_quasi {
  thrum_secant inverse;
  double before;  /* residual of the evaluation before */
  int32_t done;   /* iterations */
  bool known;     /* there is an inverse */
  bool fresh;     /* made at this evaluation */
  bool ahead;     /* to be made at the first evaluation */
  bool assembled; /* its stiffness is there */
} thrum_quasi;

typedef enum thrum_quasi_next {
  THRUM_QUASI_EVALUATE,
  THRUM_QUASI_DONE,
  THRUM_QUASI_STUCK
} thrum_quasi_next;

void thrum_quasi_begin(const thrum_solver *s, thrum_quasi *quasi);
thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi);

/* Full Newton from no motion. After thrum_quasi_begin. */
bool thrum_solve_newton(const thrum_solver *s);

/* Of the increment in view->unknown, for quasi.c: where it is to be evaluated; the scaled norm of
 * its residual, from R in `evaluated`; is that small enough; the matrix 1 + weight (at T + rate D)
 * into jacobian_next. */
void thrum_solve_place(const thrum_solver *s);
double thrum_solve_assess(const thrum_solver *s);
double thrum_solve_norm(const thrum_solver *s);
bool thrum_solve_accept(const thrum_solver *s, double norm, double step);
void thrum_solve_assemble(const thrum_solver *s, bool stiffness_there);

/* q_next and p_next of a midpoint step from a solved increment, and what the next guess needs. */
void thrum_solve_advance(const thrum_solver *s);

#endif
