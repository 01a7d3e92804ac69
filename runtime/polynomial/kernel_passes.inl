/* The table of all passes of runtime/polynomial/kernel_private.h, over vectors of 8 lanes, for a
 * file that has included runtime/polynomial/kernel_lanes.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "runtime/polynomial/kernel_packed.inl"
#include "runtime/polynomial/kernel_private.h"
// it needs the packed blocks
#include "runtime/polynomial/kernel_model.inl"
// these need evaluations
#include "runtime/polynomial/kernel_part.inl"
#include "runtime/polynomial/kernel_restricted.inl"
#include "runtime/polynomial/kernel_square.inl"

#define THRUM_KERNEL_TABLE(id)                                                                     \
  {                                                                                                \
    id, pass_energy, pass_force, pass_forces, pass_tangent, pass_tangent_vector, pass_force_part,  \
        pass_tangent_vector_part, pass_restrict, pass_restricted_gradient,                         \
        pass_restricted_hessian, pass_product, pass_rank_two, pass_sweep                           \
  }
