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
 * Points are taken in blocks of 8, one in each lane. Private to runtime/.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POLYNOMIAL_POINTS_H
#define THRUM_RUNTIME_POLYNOMIAL_POINTS_H

#include <stdbool.h>
#include <stdint.h>

#include "runtime/polynomial/packed.h"
#include "thrum/model.h"

#define THRUM_POINT_ROWS 9 /* components of a gradient */

static inline bool thrum_has_points(const thrum_model *model) {
  return model->point_gradients != NULL;
}

/* Are the coefficients there from which V comes? */
static inline bool thrum_has_energy(const thrum_model *model) {
  return model->omega2 && ((model->c3 && model->c4) || thrum_has_points(model));
}

static inline int64_t thrum_point_blocks(const thrum_model *model) {
  return (model->point_count + 7) / 8;
}

/* Doubles of V restricted to n coordinates: of a polynomial those of packed.h; of points their
 * gradients from the held coordinates, block by block, component by component, and the nonlinear
 * part of V there. */
static inline int64_t thrum_restriction_count(const thrum_model *model, int64_t n) {
  if (thrum_has_points(model))
    return 8 * THRUM_POINT_ROWS * thrum_point_blocks(model) + 1;
  return thrum_restricted_count(n);
}

#endif
