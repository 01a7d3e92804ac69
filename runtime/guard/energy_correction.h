/* The target energy of the energy-conserving scheme, and the scaling of the momentum that leads to
 * it; private to the runtime, see energy_correction.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_ENERGY_CORRECTION_H
#define THRUM_RUNTIME_GUARD_ENERGY_CORRECTION_H

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* Sets the target energy [J], or removes it. */
void thrum_energy_correction_open(thrum_state *state, double energy);
void thrum_energy_correction_close(thrum_state *state);

/* Takes an amount [J] that the body has lost between two steps off the target, where there is one.
 */
void thrum_energy_correction_take(thrum_state *state, double amount);

/* Enters a solved step of the energy integrator; may scale view->p_next by the energy error. */
void thrum_energy_correction_after(const thrum_model *model, thrum_state *state,
                                   thrum_state_view *view, const thrum_solve_report *report);

/* Gives the momentum of imexv the energy *energy_error [J] where its kinetic energy is at least
 * `least` [J]; then view->p is view->p_start and *energy_error is zero. THRUM_OK, THRUM_SINGULAR or
 * THRUM_NOT_FINITE. */
thrum_status thrum_energy_correction_apply(const thrum_model *model, thrum_state *state,
                                           thrum_state_view *view, double least,
                                           double *energy_error);

#endif
