/* The reduced strain energy V(q), design (1), its derivatives as pure functions, and the orders in
 * which its coefficients lie:
 *
 *   V(q) = 1/2 sum w_i^2 q_i^2 + sum_{i<=j<=k} c3_ijk q_i q_j q_k
 *        + sum_{i<=j<=k<=l} c4_ijkl q_i q_j q_k q_l,
 *   R = grad V, the internal force,   T = grad^2 V, the tangent stiffness.
 *
 * or, of a model with cubature points, V = 1/2 sum w_i^2 q_i^2 + the sum of the nonlinear part of
 * the strain energy at the points times their weights (docs/mathematics/18_cubature.md); no
 * function below tells the two apart.
 *
 * A model that was precomputed condensed (thrum_model_masters > 0; those with touch modes are) has
 * no V of all its coordinates: the evaluations give NaN, and those of the model that
 * thrum_model_condense makes of it are what steps. They have no status; where V is beyond the range
 * of finite numbers, so are they.
 *
 * The evaluations take `work`, scratch of thrum_work_count(model) doubles that no other argument
 * overlaps; its content is undefined before and after. Nothing is allocated; the model is only
 * read. Any thread, as long as each has its own work. Each coefficient is read once a call; T and T
 * v of small models read more numbers, by pairs of modes (thrum_model_pack).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_POLYNOMIAL_H
#define THRUM_POLYNOMIAL_H

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Doubles of scratch that the evaluations need for this model. */
THRUM_API size_t thrum_work_count(const thrum_model *model);

/* V(q) [J]; q: rank. */
THRUM_API double thrum_strain_energy(const thrum_model *model, const double *q, double *work);

/* Internal force R(q) = grad V into `force` (rank) [kg^1/2 m/s^2]; returns V(q) [J], which comes
 * with it. */
THRUM_API double thrum_internal_force(const thrum_model *model, const double *q, double *force,
                                      double *work);

/* Tangent stiffness T(q) = grad^2 V into `tangent` (rank x rank, both triangles) [1/s^2]. */
THRUM_API void thrum_tangent_stiffness(const thrum_model *model, const double *q, double *tangent,
                                       double *work);

/* Both from one read of the coefficients, and V(q), which it returns: the tangent has the bits of
 * thrum_tangent_stiffness, force and energy may have others in their last places. */
THRUM_API double thrum_internal_force_tangent(const thrum_model *model, const double *q,
                                              double *force, double *tangent, double *work);

/* T(q) v into `product` (rank); q, v: rank. */
THRUM_API void thrum_tangent_product(const thrum_model *model, const double *q, const double *v,
                                     double *product, double *work);

/* Block order of the coefficients (each monomial once, i <= j <= k <= l, design (1)).
 * c3: for j ascending a dense block of j+1 rows (i = 0..j) by rank-j columns (k = j..rank-1).
 * c4: for j ascending a dense block of j+1 rows (i = 0..j) by P_j = (rank-j)(rank-j+1)/2 columns,
 *     the pairs (k,l), j <= k <= l, k outermost. Blocks are row-major; the columns of block j are
 *     a suffix of the list of all pairs, which is what makes one pass over the coefficients serve
 *     a product and a transposed product. */
THRUM_API int64_t thrum_c3_index(int64_t rank, int64_t i, int64_t j, int64_t k);
THRUM_API int64_t thrum_c4_index(int64_t rank, int64_t i, int64_t j, int64_t k, int64_t l);

/* Bytes that thrum_model_pack needs for a model of rank 1 to THRUM_RANK_MAX, of coefficients or of
 * points. */
THRUM_API size_t thrum_model_pack_size(const thrum_model *model);

/* Lays c3 and c4 out twice more, in `memory` (aligned to 64, thrum_model_pack_size bytes, which
 * must outlive the model), in the orders in which steps read them: from either end of the modes; up
 * to rank 26 a third time, by pairs of modes, which takes about as much again. Models of
 * thrum_model_init, _load and _lock are packed; one of thrum_model_view or made by hand gives
 * the same bits unpacked, but its steps take plain C and many times as long, tangents most of all.
 * Before any other thread uses the model. Large models all of whose coefficients are
 * single-precision numbers are packed as such. Of a model of points the gradients are laid out once
 * more, eight points side by side, by the same rule. Allocates nothing. */
THRUM_API thrum_status thrum_model_pack(thrum_model *model, void *memory, size_t memory_size,
                                        thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
