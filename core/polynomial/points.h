/* V(q) summed over cubature points, design 18, for a model that has them in place of c3 and c4:
 *
 *   V(q) = 1/2 sum w_i^2 q_i^2 + sum_p w_p (psi_p(q) - psi_p,linear(q)),
 *
 * psi the strain energy per volume at a point whose displacement gradient is G = sum_i q_i G_i, and
 * psi_linear that of the linear strain: so the linear part is that of the whole body. For Saint
 * Venant-Kirchhoff material, with N = G^T G / 2, E = sym G + N, S = C:E and T = C:N,
 *
 *   psi - psi_linear = N : (S - T / 2),
 *   its derivative by G is P = T + G S, and that of P along D, with dN = sym(G^T D), dE = sym D +
 * dN,
 *   dP = C:dN + D S + G C:dE.
 *
 * Where the material of another law has flowed, F = F_e F_p, psi is that of F_e with F_p held:
 * model->point_plastic (design 19).
 *
 * Points of several laws are each of that of their region (thrum_block_law). Points are taken in
 * blocks of 8, one in each lane. Packed, the nine components of coordinate i at
 * the points of block b are nine vectors from 72 (b rank + i) on, zero behind the last point: so G
 * at eight points, the forces and a tangent are each one stream of whole cache lines, and no sum
 * runs across lanes until the end. Gradients all of which are single-precision numbers are packed
 * as such where they are large. Private to libthrum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_POLYNOMIAL_POINTS_H
#define THRUM_CORE_POLYNOMIAL_POINTS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/base/model_law.h"
#include "core/polynomial/kernel_private.h"
#include "thrum/model.h"

#define THRUM_POINT_ROWS 9 /* components of a gradient */

static inline bool thrum_has_points(const thrum_model *model) {
  return model->point_gradients != NULL;
}

/* Are the coefficients there from which V comes, and what evaluates them? */
static inline bool thrum_has_energy(const thrum_model *model) {
  return model->omega2 &&
         ((model->c3 && model->c4) || (thrum_has_points(model) && thrum_passes.points != NULL));
}

static inline int64_t thrum_point_blocks(const thrum_model *model) {
  return (model->point_count + 7) / 8;
}

/* The law of block b of a model of this law, or THRUM_LAW_BY_REGION where its points have several.
 */
static inline thrum_law thrum_block_law(const thrum_model *model, thrum_law law, int64_t b) {
  const int64_t first = 8 * b,
                end = first + 8 < model->point_count ? first + 8 : model->point_count;
  if (law != THRUM_LAW_BY_REGION)
    return law;
  const int32_t *region = model->point_region;
  for (int64_t p = first + 1; p < end; p++)
    if (model->region_law[region[p]] != model->region_law[region[first]])
      return law;
  return (thrum_law)model->region_law[region[first]];
}

/* Numbers of one coordinate in a block, and of all blocks. */
#define THRUM_POINT_BLOCK (8 * THRUM_POINT_ROWS)

static inline int64_t thrum_points_pack_count(const thrum_model *model) {
  return THRUM_POINT_BLOCK * thrum_point_blocks(model) * model->rank;
}

/* Numbers of model->point_plastic: the plastic strains, and behind them what runtime/points/
 * point_rest.h has of a model that may flow. */
static inline int64_t thrum_points_plastic_count(const thrum_model *model) {
  return THRUM_POINT_ROWS * model->point_count + model->rank + 2 + model->rank * model->rank;
}

/* What the plastic strains of a model that may flow have released: rank + 1 numbers; behind them 1
 * and X (rank x rank), by which its points see displacements shortened, or 0 where they do not. */
static inline const double *thrum_points_released(const thrum_model *model) {
  return model->point_plastic + THRUM_POINT_ROWS * model->point_count;
}
static inline bool thrum_points_shorten(const thrum_model *model) {
  return model->point_plastic && thrum_points_released(model)[model->rank + 1] != 0;
}

/* Packed gradients of more bytes than this are single-precision ones where they can be: below,
 * widening them costs more than reading fewer bytes saves. Measured. */
#define THRUM_POINTS_SINGLE_BYTES (3 << 19)

/* Are the gradients that the model has now packed? */
static inline bool thrum_points_are_packed(const thrum_model *model) {
  return (model->packed || model->packed_single) &&
         model->packed_gradients == model->point_gradients;
}

/* Scratch of a pass, in doubles: a block that is not packed, eight columns of a tangent, and lanes
 * of the forces at two points. */
static inline int64_t thrum_points_work(int64_t rank) {
  return THRUM_POINT_BLOCK * (rank + 8) + 16 * thrum_whole(rank);
}

#endif
