/* The step of the Newmark family; private to libthrum, see newmark.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_NEWMARK_H
#define THRUM_CORE_SCHEMES_NEWMARK_H

#include "core/schemes/schemes.h"

/* One step: candidates into q_next, p_next and acceleration_next, also middle, force, pairs and,
 * when refreshed, jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_newmark(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report);

extern const thrum_scheme_row thrum_newmark_scheme;

/* The problem of its step, without kick and drift, for beta_N > 0. */
thrum_solver thrum_newmark_problem(const thrum_model *model, const thrum_state *state,
                                   thrum_state_view *view, thrum_solve_report *report);

/* The parts of a step with beta_N > 0 around its solve. */
thrum_solver thrum_newmark_begin(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_newmark_finish(const thrum_solver *s, bool solved);

/* a = -R(q) - D v, without a load, into `acceleration` (rank). Overwrites force and product. */
void thrum_newmark_acceleration(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, const double *q, const double *v,
                                double *acceleration);

/* Component i of the stored a, with the load of this step in place of the one before. */
static inline double thrum_newmark_acceleration_now(const thrum_state_view *view, int32_t i) {
  return view->acceleration[i] + (view->load[i] - view->load_before[i]);
}

#endif
