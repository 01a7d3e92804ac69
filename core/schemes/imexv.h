/* The step of imexv in its thesis split, whole and in stages for a batch; private to libthrum, see
 * imexv.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_IMEXV_H
#define THRUM_CORE_SCHEMES_IMEXV_H

#include "core/schemes/schemes.h"

/* One step: candidates into q_next and p_next, also middle, force, pairs and, when refreshed,
 * jacobian_next; nothing that persists is written. THRUM_OK, THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE. */
thrum_status thrum_step_imexv(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, thrum_solve_report *report);

/* Its row, and the members of it that are those of the position form too. */
extern const thrum_scheme_row thrum_thesis_scheme;
thrum_mode_factor thrum_imexv_frequency(const thrum_model *model, const thrum_state *state,
                                        int32_t i, double z);
bool thrum_imexv_problem(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         thrum_solve_report *report, thrum_solver *s);

/* The implicit problem of a step. */
thrum_solver thrum_imexv_solver(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report);

/* Kick and drift, from R(q_k) in view->force and V(q_k) in `potential`: q_next, middle and velocity
 * of the explicit modes. THRUM_OK, THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_imexv_drift(const thrum_solver *s, double potential);

/* Candidates from a solved increment, or the reason why there is none. */
thrum_status thrum_imexv_finish(const thrum_solver *s, bool solved);

#endif
