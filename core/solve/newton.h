/* Newton's method without anything around it; private to libthrum, see newton.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_NEWTON_H
#define THRUM_CORE_SOLVE_NEWTON_H

#include "core/solve/implicit_problem.h"

/* Finds the increment as thrum_solve_increment does. False where it does not converge within the
 * def's iterations, where a Jacobian is singular, and where a residual is not finite. */
bool thrum_newton_solve(const thrum_solver *s);

#endif
