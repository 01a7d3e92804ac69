/* The stability and energy monitor of imexv (design 4); private to the runtime. stability.c has the
 * energy balance and the switches, stability_number.c the stability number and the split.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_GUARD_STABILITY_H
#define THRUM_RUNTIME_GUARD_STABILITY_H

#include "core/state/solve_report.h"
#include "core/state/state_layout.h"

/* Steps between two samples of the stability number far from its limit, and where it hardly moves
 * either. */
#define THRUM_SAMPLE_STEPS 16
#define THRUM_SAMPLE_STEPS_MOST 64

/* Stands for larger numbers, and energies above it [J] are not monitored: sums could overflow. */
#define THRUM_MONITOR_MOST 1e300

/* Quiet time in steps before modes return to the explicit set, doubled with each change. */
#define THRUM_QUIET_STEPS 4096

typedef enum thrum_stability_decision {
  THRUM_DECISION_CONTINUE = 0,
  THRUM_DECISION_SWITCH, /* the energy integrator takes this step and those to come, */
  THRUM_DECISION_REPEAT  /* and repeats the one before */
} thrum_stability_decision;

/* How many modes are treated explicitly, at least in part: the first ones. */
static inline int32_t thrum_monitored_modes(const thrum_state *state) {
  return state->scheme == THRUM_SCHEME_QUADRATIC ? state->rank : state->split;
}

/* The scheme with an implicit solve that the def of an imexv asks for; the quadratic split gives
 * way to the thesis split. */
static inline thrum_scheme thrum_solving_scheme(const thrum_state *state) {
  return state->def.split_form == THRUM_FORM_POSITION ? THRUM_SCHEME_POSITION : THRUM_SCHEME_THESIS;
}

/* Forgets what energy and balance were compared with. */
void thrum_stability_reset(thrum_state *state);

/* Before a step; `state` is the header to be. May change its scheme and split, and then points
 * view->p to the momentum that goes with them. After a failure that could not be done. Where
 * *samples is set, T_EE times view->direction is needed in view->product: thrum_stability_multiply
 * puts it there, and thrum_stability_sample goes on from it and may change the same. */
thrum_status thrum_stability_before(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, bool *samples);
void thrum_stability_multiply(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view);
thrum_status thrum_stability_sample(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view);

/* Begins a sample of the stability number: the iterate of the power iteration into
 * view->direction. */
void thrum_stability_direct(const thrum_state *state, thrum_state_view *view);

/* The energy at q_k for the report, from V(q_k) and the explicit force in view->force; after the
 * kick, which has the synchronised p of the tangent form of damping. */
void thrum_stability_energy(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, double potential, thrum_solve_report *report);

/* After a solved step, whose candidates are in the view. Without explicit modes no kick has
 * evaluated the energy, so that at the end of the step goes into the report. With them, and after a
 * load jump, it says whether the jump has spoilt the step. */
void thrum_stability_look_ahead(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report);

/* Enters the energy of the report, where it is known, and decides. */
thrum_stability_decision thrum_stability_decide(thrum_state *state,
                                                const thrum_solve_report *report);

/* Makes the header and the view those of the energy integrator; after THRUM_DECISION_REPEAT with
 * the step before this one repeated. Clears the report. */
thrum_status thrum_stability_switch_to_energy(const thrum_model *model, thrum_state *state,
                                              thrum_state_view *view,
                                              thrum_stability_decision decision,
                                              thrum_solve_report *report);

/* Enters work and dissipation of a solved step. */
void thrum_stability_after(const thrum_model *model, thrum_state *state,
                           const thrum_state_view *view, const thrum_solve_report *report);

#endif
