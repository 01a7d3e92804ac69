/* The table of all passes of core/polynomial/kernel_private.h, over vectors of 8 lanes, for a
 * file that has included core/polynomial/kernel_lanes.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"
#include "runtime/kernels/kernel_packed.inl"
// it needs the packed blocks
#include "runtime/kernels/kernel_model.inl"
// these need evaluations
#include "runtime/kernels/kernel_part.inl"
#include "runtime/kernels/kernel_restricted.inl"
#include "runtime/kernels/kernel_square.inl"

/* The table of a model of points: that of this file, unless it has said another one. */
#ifndef THRUM_KERNEL_POINTS
#include "runtime/points/kernel_points.inl"
#define THRUM_KERNEL_POINTS &points_table
#endif

/* Initialiser of the table of passes in this file. */
#define THRUM_KERNEL_TABLE(kernel_id)                                                              \
  {                                                                                                \
    .id = kernel_id, .energy = pass_energy, .force = pass_force, .forces = pass_forces,            \
    .tangent = pass_tangent, .tangent_vector = pass_tangent_vector, .force_part = pass_force_part, \
    .tangent_vector_part = pass_tangent_vector_part, .restrict_to = pass_restrict,                 \
    .restricted_gradient = pass_restricted_gradient,                                               \
    .restricted_hessian = pass_restricted_hessian, .product = pass_product,                        \
    .rank_two = pass_rank_two, .sweep = pass_sweep, .points = THRUM_KERNEL_POINTS,                 \
  }
