/* Quasi-Newton for an implicit problem; private to libthrum, see quasi_newton.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_QUASI_NEWTON_H
#define THRUM_CORE_SOLVE_QUASI_NEWTON_H

#include "core/solve/implicit_problem.h"

/* A solve one evaluation at a time, so that a batch can evaluate several states together: begin,
 * then while the answer is EVALUATE put R at view->middle into `evaluated` and take. Where `ahead`
 * is set the first evaluation will need the stiffness too, which may be put into jacobian_next and
 * then be marked in `assembled`. */
typedef struct thrum_quasi {
  thrum_secant inverse;
  double norm;    /* scaled residual of the last evaluation, */
  double before;  /* and of the one before */
  int32_t done;   /* iterations */
  bool known;     /* there is an inverse */
  bool fresh;     /* it was made at this evaluation */
  bool ahead;     /* it is to be made at the first evaluation */
  bool assembled; /* the stiffness for it is in jacobian_next */
} thrum_quasi;

typedef enum thrum_quasi_next {
  THRUM_QUASI_EVALUATE,
  THRUM_QUASI_DONE, /* a solve that carries its correction has it in view->direction, negated, and
                       J0 times it in view->trial */
  THRUM_QUASI_STUCK /* full Newton is to be tried */
} thrum_quasi_next;

void thrum_quasi_begin(const thrum_solver *s, thrum_quasi *quasi);
thrum_quasi_next thrum_quasi_take(const thrum_solver *s, thrum_quasi *quasi);

/* The work of a solve between the two: R, and the stiffness in the same pass where it is needed.
 */
void thrum_quasi_evaluate(const thrum_solver *s, thrum_quasi *quasi);

/* The whole solve: the increment in view->unknown, R + D v - f in view->total, q + at d in
 * view->middle and v in view->velocity; R where `evaluated` says if the report says verified, else
 * in view->force. False when it is stuck. */
bool thrum_quasi_solve(const thrum_solver *s);

/* Applies the correction that a solve has left over, which then is not done yet. */
void thrum_quasi_go_on(const thrum_solver *s, thrum_quasi *quasi);

#endif
