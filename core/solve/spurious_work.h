/* The energy that unverified corrections move between low and high modes; private to libthrum,
 * see spurious_work.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SOLVE_SPURIOUS_WORK_H
#define THRUM_CORE_SOLVE_SPURIOUS_WORK_H

#include "core/solve/implicit_problem.h"

/* Most halvings of the tolerance. */
#define THRUM_HALVINGS_MOST 12

/* Most windows until one is taken back. */
#define THRUM_WAIT_MOST 1024

/* Takes a sample where a new Jacobian has been made: the correction by its inverse is in
 * view->direction, the one by the inverse before it in view->correction, both negated. Fills the
 * report. */
void thrum_spurious_work_sample(const thrum_solver *s);

/* Adds a solved step to the state's report and to the window, and tightens or relaxes the tolerance
 * at its end. `next` is the header to be, before the step is counted. */
void thrum_spurious_work_enter(thrum_state *next, const thrum_solve_report *report);

/* Forgets the window; the state's report stays. */
void thrum_spurious_work_forget(thrum_state *state);

/* The share of the tolerance to be used. */
double thrum_spurious_work_share(const thrum_state *state);

#endif
