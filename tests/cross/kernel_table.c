/* The kernels and passes of the whole library, for a test that links them and no state.
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"
#include "runtime/kernels/processor_kernel.h"
#include "runtime/points/kernel_points.h"
#include "runtime/points/point_rest.h"

const thrum_pass_set thrum_passes = {
    .kernel = thrum_processor_kernel,
    .points = &thrum_points_reference,
    .along = thrum_points_along,
    .released_energy = thrum_released_energy,
    .see = thrum_points_see,
    .return_force = thrum_points_return,
    .return_tangent = thrum_points_return_tangent,
};
