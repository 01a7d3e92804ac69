/* Quasi-Newton and then full Newton for an implicit problem; private to libthrum, see
 * implicit_solve.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_IMPLICIT_SOLVE_H
#define THRUM_CORE_SOLVE_IMPLICIT_SOLVE_H

#include "core/solve/implicit_problem.h"

/* Finds the increment: then it is in view->unknown, R in view->force, R + D v - f in view->total,
 * q + at d in view->middle and v in view->velocity. False when neither the solver of the def nor
 * full Newton after it converges; full Newton is not tried after the solver newton without
 * fallback. */
bool thrum_solve_increment(const thrum_solver *s);

/* Full Newton from no motion. After thrum_quasi_begin. */
bool thrum_solve_newton(const thrum_solver *s);

/* q_next and p_next of a midpoint step from a solved increment. */
void thrum_solve_advance(const thrum_solver *s);

#endif
