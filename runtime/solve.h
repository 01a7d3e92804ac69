/* The implicit solve shared by imexv and energy, private to the runtime; see solve.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_SOLVE_H
#define THRUM_RUNTIME_SOLVE_H

#include "state.h"

/* A solve for the increment of the modes first..rank-1; filled by the integrator. */
typedef struct thrum_solver thrum_solver;
struct thrum_solver {
  const thrum_model *model;
  const thrum_state *state;
  thrum_state_view *view;
  thrum_solve_report *report;
  /* Mean force R of the increment in view->unknown into view->force; returns P. The midpoint q-bar
   * in view->middle and v in view->velocity are up to date. */
  double (*evaluate)(const thrum_solver *s);
  /* h^2/2 dR/dd, and h/2 beta T for the tangent form, of the increment last evaluated: n x n. */
  void (*stiffness)(const thrum_solver *s, double *matrix);
  double h;
  int32_t first; /* of the implicit modes */
  int32_t n;     /* how many */
  bool tangent;  /* damping in tangent form */
  bool exact;    /* solve on until rounding stops it */
};

/* Finds the increment: then it is in view->unknown, R in view->force, R + D v - f in view->total,
 * q-bar in view->middle. False when neither quasi-Newton nor full Newton ends. */
bool thrum_solve_increment(const thrum_solver *s);

/* Quasi-Newton one evaluation at a time, so that those of several states can be made together:
 * begin, then while the answer is EVALUATE put R at view->middle into view->force and give P. STUCK
 * is for thrum_solve_newton. */
typedef struct thrum_quasi {
  double before; /* residual of the evaluation before */
  int32_t done;  /* iterations */
  bool kept;     /* the factors are of a step before */
  bool fresh;    /* the factors are of this evaluation */
} thrum_quasi;

typedef enum thrum_quasi_next {
  THRUM_QUASI_EVALUATE,
  THRUM_QUASI_DONE,
  THRUM_QUASI_STUCK
} thrum_quasi_next;

void thrum_quasi_begin(const thrum_solver *s, thrum_quasi *quasi);
thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi, double potential);

/* Full Newton from no motion. */
bool thrum_solve_newton(const thrum_solver *s);

/* q_next, p_next and past_next of the implicit modes from a solved increment. */
void thrum_solve_advance(const thrum_solver *s);

#endif
