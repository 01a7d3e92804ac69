/* The reduced strain energy V(q), design (1), and its derivatives, as pure functions:
 *
 *   V(q) = 1/2 sum w_i^2 q_i^2 + sum_{i<=j<=k} c3_ijk q_i q_j q_k + sum_{i<=j<=k<=l} c4_ijkl q_i
 * q_j q_k q_l R = grad V, T = grad^2 V.
 *
 * All take `work`, scratch of thrum_work_count(model) doubles that no other argument overlaps; its
 * content is undefined before and after. Nothing is allocated; the model is only read. Any thread,
 * as long as each has its own work. Each coefficient is read once per call (those of
 * small models by pairs for T and T v, which are more).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_POLYNOMIAL_H
#define THRUM_POLYNOMIAL_H

#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Doubles of scratch that the functions below need for this model. */
size_t thrum_work_count(const thrum_model *model);

/* V(q) [J]; q: rank. */
double thrum_energy(const thrum_model *model, const double *q, double *work);

/* Internal force R(q) = grad V into `force` (rank) [kg^1/2 m/s^2]; returns V(q), which comes with
 * it. */
double thrum_force(const thrum_model *model, const double *q, double *force, double *work);

/* Tangent stiffness T(q) = grad^2 V into `tangent` (rank x rank, both triangles) [1/s^2]. */
void thrum_tangent(const thrum_model *model, const double *q, double *tangent, double *work);

/* T(q) v into `product` (rank). */
void thrum_tangent_vector(const thrum_model *model, const double *q, const double *v,
                          double *product, double *work);

#ifdef __cplusplus
}
#endif
#endif
