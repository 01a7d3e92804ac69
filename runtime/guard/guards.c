/* When the guards act in a step (guards.h):
 *
 *   before     the stability monitor may change the scheme, and asks for a product now and then
 *   attempt    it looks at what the step has led to, and may have it made again by `energy`
 *   settle     the fallback chain takes a step that is not solved
 *   solved     the energy balance may have one of fox-goodwin made again by `energy`
 *   accepted   the monitor enters work and dissipation, and the momentum is scaled to the target
 *              energy
 *   keep       the state before the step, which the monitor may repeat, and its iterates
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/guard/guards.h"

#include <math.h>
#include <string.h>

#include "runtime/guard/energy_balance.h"
#include "runtime/guard/energy_correction.h"
#include "runtime/guard/fallback.h"
#include "runtime/guard/stability.h"

void thrum_guards_forget(thrum_state *state) {
  thrum_stability_reset(state);
  thrum_energy_balance_reset(state);
}

void thrum_guards_forget_step(thrum_state *state) {
  state->monitor.before_step = -1;
}

void thrum_guards_take(thrum_state *state, double amount) {
  if (amount == 0.0 || !isfinite(amount))
    return;
  thrum_energy_correction_take(state, amount);
  state->balance.explained -= amount;
  state->balance.moved += fabs(amount);
  state->monitor.work -= amount;
  state->monitor.moved += fabs(amount);
}

thrum_status thrum_guards_before(const thrum_model *model, thrum_step_run *run) {
  return thrum_stability_before(model, &run->next, &run->view, &run->samples);
}

thrum_status thrum_guards_sample(const thrum_model *model, thrum_step_run *run,
                                 bool product_there) {
  if (!product_there)
    thrum_stability_multiply(model, &run->next, &run->view);
  return thrum_stability_sample(model, &run->next, &run->view);
}

bool thrum_guards_attempt(const thrum_model *model, thrum_step_run *run, thrum_status *status) {
  // of the others the monitor knows no energy
  thrum_state *next = &run->next;
  if (!thrum_is_monitored_imexv(next))
    return false;
  if (*status >= 0)
    thrum_stability_look_ahead(model, next, &run->view, &run->report);

  // also after a failure: the step before may have spoilt this one, which its kick then has seen
  const thrum_stability_decision decision = thrum_stability_decide(next, &run->report);
  if (decision == THRUM_DECISION_CONTINUE)
    return false;
  *status = thrum_stability_switch_to_energy(model, next, &run->view, decision, &run->report);
  return *status >= 0;
}

thrum_status thrum_guards_settle(const thrum_model *model, thrum_step_run *run,
                                 thrum_status failure) {
  return thrum_fallback_run(model, &run->next, &run->view, failure, &run->report);
}

bool thrum_guards_solved(const thrum_model *model, thrum_step_run *run, thrum_status *status) {
  if (!thrum_energy_balance_follows(&run->next) ||
      !thrum_energy_balance_enter(model, &run->next, &run->view, &run->report))
    return false;

  // nothing of the first attempt stays
  memset(&run->report, 0, sizeof run->report);
  memset(run->view.acceleration_next, 0, (size_t)run->next.rank * sizeof(double));
  *status = thrum_energy_balance_switch(model, &run->next, &run->view);
  return *status >= 0;
}

void thrum_guards_accepted(const thrum_model *model, thrum_step_run *run) {
  if (run->next.scheme == THRUM_SCHEME_ENERGY)
    thrum_energy_correction_after(model, &run->next, &run->view, &run->report);
  else
    thrum_stability_after(model, &run->next, &run->view, &run->report);
}

void thrum_guards_coupled(const thrum_model *model, thrum_step_run *run) {
  // the state sees a part of the energy alone, which has no target
  (void)model;
  thrum_energy_correction_close(&run->next);
}

void thrum_guards_keep(const thrum_model *model, thrum_step_run *run) {
  thrum_state *next = &run->next;
  const thrum_state_view *view = &run->view;
  const size_t vector = (size_t)next->rank * sizeof(double);
  (void)model;

  // the state before this step, should the next one repeat it; a finite energy has finite momenta
  const bool whole = next->scheme == THRUM_SCHEME_POSITION;
  if (whole || (run->report.energy_known && isfinite(run->report.energy))) {
    memcpy(view->q_before, run->q, vector);
    memcpy(view->p_before, whole ? view->p : view->p_before_next, vector);
    next->monitor.before_step = next->report.steps;
    next->monitor.before_dt = next->def.dt;
  }
  if (view->power_sampled) {
    memcpy(view->power_explicit, view->power_explicit_next, vector);
    memcpy(view->power_whole, view->power_whole_next, vector);
  }

  // an energy that nothing has put in
  next->report.grown_steps += next->balance.grew;
  run->notable = next->balance.grew ? THRUM_ENERGY_GREW : THRUM_OK;
}
