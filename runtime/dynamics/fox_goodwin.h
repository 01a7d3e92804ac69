/* Newmark's step with beta by mode; private to the runtime, see fox_goodwin.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_FOX_GOODWIN_H
#define THRUM_RUNTIME_DYNAMICS_FOX_GOODWIN_H

#include "runtime/dynamics/implicit_problem.h"

/* How many modes have beta = 1/12: the first ones. */
int32_t thrum_fox_goodwin_modes(const thrum_model *model, const thrum_state *state);

/* The problem of its step, without kick and drift. */
thrum_solver thrum_fox_goodwin_problem(const thrum_model *model, const thrum_state *state,
                                       thrum_state_view *view, thrum_solve_report *report);

/* The problem with both, and the candidates of the step from its solution, as those of newmark.h.
 */
thrum_solver thrum_fox_goodwin_begin(const thrum_model *model, const thrum_state *state,
                                     thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_fox_goodwin_finish(const thrum_solver *s, bool solved);

/* One step, as thrum_step_newmark. */
thrum_status thrum_step_fox_goodwin(const thrum_model *model, const thrum_state *state,
                                    thrum_state_view *view, thrum_solve_report *report);

/* The momentum at q from the stored view->p, into view->p_next; V(q) into *potential if not NULL.
 * Overwrites product. */
void thrum_fox_goodwin_synchronise(const thrum_model *model, const thrum_state *state,
                                   thrum_state_view *view, double *potential);

/* The inverse: turns `p` (rank) at q into the momentum that the scheme stores. Overwrites
 * jacobian_next and unknown. THRUM_OK, or THRUM_SINGULAR or THRUM_NOT_FINITE with p as it was. */
thrum_status thrum_fox_goodwin_unsynchronise(const thrum_model *model, const thrum_state *state,
                                             thrum_state_view *view, const double *q, double *p);

#endif
