/* The schemes, hooks and passes of the whole library (schemes.h,
 * core/polynomial/kernel_private.h): all that stands above the core, in the order in which it
 * acts. A new scheme is its file and a row here. SPDX-License-Identifier: Apache-2.0 */
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/imexv.h"
#include "core/schemes/newmark.h"
#include "core/schemes/position_split.h"
#include "core/schemes/schemes.h"
#include "runtime/actuation/acting.h"
#include "runtime/actuation/levels.h"
#include "runtime/comparison/backward_euler.h"
#include "runtime/comparison/fox_goodwin.h"
#include "runtime/comparison/quadratic_split.h"
#include "runtime/comparison/rk4.h"
#include "runtime/comparison/semi_implicit_euler.h"
#include "runtime/condensed/following.h"
#include "runtime/condensed/manifold.h"
#include "runtime/guard/frequency_matching.h"
#include "runtime/guard/guards.h"
#include "runtime/guard/stability.h"
#include "runtime/kernels/processor_kernel.h"
#include "runtime/points/kernel_points.h"
#include "runtime/points/point_flow.h"
#include "runtime/points/point_rest.h"

const thrum_pass_set thrum_passes = {
    .kernel = thrum_processor_kernel,
    .points = &thrum_points_reference,
    .along = thrum_points_along,
    .released_energy = thrum_released_energy,
    .see = thrum_points_see,
    .return_force = thrum_points_return,
    .return_tangent = thrum_points_return_tangent,
    .act = thrum_acting_energy,
    .act_along = thrum_acting_product,
};

/* A list of hooks, ended by NULL. */
#define HOOKS(type, ...)                                                                           \
  (const type[]) {                                                                                 \
    __VA_ARGS__, NULL                                                                              \
  }

const thrum_scheme_set thrum_schemes = {
    .rows =
        {
            [THRUM_SCHEME_THESIS] = &thrum_thesis_scheme,
            [THRUM_SCHEME_QUADRATIC] = &thrum_quadratic_scheme,
            [THRUM_SCHEME_ENERGY] = &thrum_energy_scheme,
            [THRUM_SCHEME_NEWMARK] = &thrum_newmark_scheme,
            [THRUM_SCHEME_FOX_GOODWIN] = &thrum_fox_goodwin_scheme,
            [THRUM_SCHEME_POSITION] = &thrum_position_scheme,
            [THRUM_SCHEME_BACKWARD_EULER] = &thrum_backward_euler_scheme,
            [THRUM_SCHEME_SEMI_IMPLICIT_EULER] = &thrum_semi_implicit_euler_scheme,
            [THRUM_SCHEME_RK4] = &thrum_rk4_scheme,
            [THRUM_SCHEME_MANIFOLD] = &thrum_manifold_scheme,
        },
    .mode_steps = &thrum_matched_mode_steps,
    .adapts = true,
    .falls_back = true,

    // a state
    .check = HOOKS(thrum_on_check, thrum_point_flow_check),
    .plan = HOOKS(thrum_on_plan, thrum_point_flow_plan, thrum_follow_plan, thrum_actuation_plan),
    .made = HOOKS(thrum_on_made, thrum_point_flow_prepare, thrum_actuation_prepare),
    .forget = HOOKS(thrum_on_forget, thrum_guards_forget),
    .forget_step = HOOKS(thrum_on_forget, thrum_guards_forget_step),
    .leave = HOOKS(thrum_on_moved, thrum_actuation_leave),
    .arrive = HOOKS(thrum_on_moved, thrum_actuation_arrive),
    .seen = thrum_actuated_model,

    // a step
    .load = HOOKS(thrum_on_load, thrum_follow_load),
    .before = HOOKS(thrum_on_before, thrum_guards_before),
    .sample = HOOKS(thrum_on_sample, thrum_guards_sample),
    .kicked = HOOKS(thrum_on_kicked, thrum_stability_energy),
    .after_attempt = HOOKS(thrum_on_attempt, thrum_guards_attempt),
    .settle = HOOKS(thrum_on_settle, thrum_guards_settle),
    .solved = HOOKS(thrum_on_attempt, thrum_guards_solved),
    .accepted = HOOKS(thrum_on_accepted, thrum_guards_accepted),
    .coupled = HOOKS(thrum_on_accepted, thrum_guards_coupled),
    .keep = HOOKS(thrum_on_accepted, thrum_guards_keep),
    .committed = HOOKS(thrum_on_committed, thrum_point_flow),
};
