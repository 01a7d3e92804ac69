/* The table of all passes of runtime/kernel.h, over vectors of 8 lanes, for a file that has
 * included runtime/kernel_lanes.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "kernel.h"
#include "kernel_packed.h"
// it needs the packed blocks
#include "kernel_model.h"
// these need evaluations
#include "kernel_part.h"
#include "kernel_restricted.h"
#include "kernel_square.h"

#define THRUM_KERNEL_TABLE(id)                                                                     \
  {                                                                                                \
    id, pass_energy, pass_force, pass_forces, pass_tangent, pass_tangent_vector, pass_force_part,  \
        pass_tangent_vector_part, pass_restrict, pass_restricted_gradient,                         \
        pass_restricted_hessian, pass_product, pass_rank_two, pass_sweep                           \
  }
