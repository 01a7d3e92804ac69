/* Bodies that act: pressures in chambers, muscles and heat, tendons, and gas that is shut in. A
 * model that was made with `thrum precompute --actuator` has the energy that each of them adds to
 * V(q), exactly as the mesh has it:
 *
 * - pressure, level a [Pa]: -a (Vol(q) - Vol(0)), a cubic polynomial;
 * - strain, level a: -a (g q + 1/2 q H q), where the region strains by a E0 if nothing holds it;
 * - tendon, level a [N]: a (L(q) - L(0)), L the length of its straight parts;
 * - gas, level a [Pa]: -(p + a) Vol(0) ln(Vol(q)/Vol(0)) + p (Vol(q) - Vol(0)), p the pressure
 *   outside: a fixed amount at a fixed temperature (Boyle).
 *
 * A state has a level for each, zero at first, which is set between steps as a load is:
 *
 *   thrum_state_set_actuation(model, state, levels, &error);
 *   thrum_step(model, state, &error);
 *
 * All integrators step it. The work of each actuator on the body is accounted; where the levels
 * stay the same, that of `energy` is exact to rounding. Equations: docs/actuation.md.
 *
 * Threads: as for states. Nothing here allocates.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACTUATION_H
#define THRUM_ACTUATION_H

#include "thrum/api.h"
#include "thrum/model.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How many actuators a model has; 0 for NULL. Any thread. */
THRUM_API int64_t thrum_model_actuators(const thrum_model *model);

/* The text NAME=SPEC of actuator `index` (0-based), which lies inside the model; NULL when out of
 * range. Any thread. */
THRUM_API const char *thrum_model_actuator_text(const thrum_model *model, int64_t index);

/* The index of the actuator of this name. THRUM_MISSING where there is none,
 * THRUM_INVALID_ARGUMENT for NULL. Any thread. */
THRUM_API thrum_status thrum_model_actuator(const thrum_model *model, const char *name,
                                            int64_t *index, thrum_error *error);

/* Sets the levels of the steps to come (thrum_model_actuators of them; NULL: all zero). q and p of
 * the present time stay. What a solve keeps for the next step is moved to the new levels, at the
 * cost of the polynomials that change; of imexv in its thesis split also two forces.
 * THRUM_BAD_VALUE for levels that are not finite, or a gas of no pressure left; THRUM_UNSUPPORTED
 * where the model has no actuators; or as thrum_state_get. */
THRUM_API thrum_status thrum_state_set_actuation(const thrum_model *model, thrum_state *state,
                                                 const double *levels, thrum_error *error);

/* The levels that are set, into `levels` (thrum_model_actuators). Failures as above. */
THRUM_API thrum_status thrum_state_actuation(const thrum_model *model, const thrum_state *state,
                                             double *levels, thrum_error *error);

/* What each actuator has done to the body since the state was made [J]: the energy of q and p
 * (thrum_state_energies) is that of the start, plus this, the work of loads, less what was
 * dissipated. Setting q or p does no work. Into `work` (thrum_model_actuators). Failures as above.
 */
THRUM_API thrum_status thrum_state_actuation_work(const thrum_model *model,
                                                  const thrum_state *state, double *work,
                                                  thrum_error *error);

/* The volume of each chamber [m^3], the length of each tendon [m], and of a strain the work that
 * one level would have done on the way from rest [J], at the present q. Into `measures`
 * (thrum_model_actuators). Failures as above. */
THRUM_API thrum_status thrum_state_actuation_measures(const thrum_model *model,
                                                      const thrum_state *state, double *measures,
                                                      thrum_error *error);

/* Doubles of the memory of thrum_model_actuate; 0 where the model has no actuators. Any thread. */
THRUM_API int64_t thrum_model_actuation_count(const thrum_model *model);

/* The model under constant levels, for what has no state: equilibria, forces and tangents. Curves
 * and normal forms refuse it, and thrum_model_scale drops the levels. `acting` is a copy of the
 * struct that has them in `memory` (the caller's, of thrum_model_actuation_count doubles), which
 * must outlive it, as must `model`. States that are stepped with it have their own levels. Failures
 * as of thrum_state_set_actuation. Any thread. */
THRUM_API thrum_status thrum_model_actuate(const thrum_model *model, const double *levels,
                                           double *memory, thrum_model *acting, thrum_error *error);

/* What one unit of the level of actuator `index` (0-based) does at q (rank): its generalised force
 * into `force` (rank) [kg^1/2 m/s^2], and the work that it has done on the way from rest [J] into
 * *work. Either may be NULL. `acting` is a model of thrum_model_actuate; of its levels nothing
 * depends. Of a rest R(q) = f the derivative of a loss by the level is the product of `force` with
 * force_bar of thrum_rest_pull_back. THRUM_INVALID_ARGUMENT for NULL, another model or an index out
 * of range, THRUM_BAD_VALUE for q that is not finite, THRUM_NOT_FINITE. Any thread. */
THRUM_API thrum_status thrum_model_actuation_force(const thrum_model *acting, int64_t index,
                                                   const double *q, double *force, double *work,
                                                   thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
