/* One step on the manifold of a condensed model, with the inertia of what follows; private to the
 * runtime, see manifold.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_MANIFOLD_H
#define THRUM_RUNTIME_DYNAMICS_MANIFOLD_H

#include "runtime/dynamics/solve_report.h"
#include "runtime/dynamics/state_layout.h"

/* Candidates into view->q_next and view->p_next, the masters and their velocities. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_manifold(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report);

/* Kinetic energy of the slaves [J] at the masters x with the velocities v (rank each); 0 of a model
 * that is not condensed. */
double thrum_manifold_slave_energy(const thrum_model *model, const double *x, const double *v);

/* Doubles of scratch that a step takes in view->restricted. */
int64_t thrum_manifold_count(const thrum_model *model);

#endif
