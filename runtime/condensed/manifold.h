/* One step on the manifold of a condensed model, with the inertia of what follows; private to the
 * runtime, see manifold.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONDENSED_MANIFOLD_H
#define THRUM_RUNTIME_CONDENSED_MANIFOLD_H

#include "core/schemes/schemes.h"

/* Candidates into view->q_next and view->p_next, the masters and their velocities. THRUM_OK,
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_manifold(const thrum_model *model, const thrum_state *state,
                                 thrum_state_view *view, thrum_solve_report *report);

extern const thrum_scheme_row thrum_manifold_scheme;

/* A step linear about the present state, with the mass of all coordinates there and the stiffness
 * at rest: moved (rank), the displacement of the masters under the mean load (rank or NULL), and
 * answers (rank), that of each to a unit load on itself [s^2]. Needs the force at q in view->force,
 * and uses what a step uses. False where there is no inverse; moved is then useless. */
bool thrum_manifold_predict(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, const double *load, double *moved,
                            double *answers);

/* Kinetic energy of the slaves [J] at the masters x with the velocities v (rank each); 0 of a model
 * that is not condensed. */
double thrum_manifold_slave_energy(const thrum_model *model, const double *x, const double *v);

/* Doubles of scratch that a step takes in view->restricted. */
int64_t thrum_manifold_count(const thrum_model *model);

#endif
