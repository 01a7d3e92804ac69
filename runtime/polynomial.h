/* What the runtime's own files share about the polynomial V(q), design (1): the block kernels, and
 * V restricted to the implicit modes for the inner iteration of design 5. Private to runtime/.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POLYNOMIAL_H
#define THRUM_RUNTIME_POLYNOMIAL_H

#include "thrum/polynomial.h"

/* Number of pairs (k, l), k <= l, of n coordinates. Lists of pairs have k outermost, so the pairs
 * with k >= j are the last thrum_pair_count(n - j) ones. */
static inline int64_t thrum_pair_count(int64_t n) {
  return n * (n + 1) / 2;
}

/* --- block kernels (polynomial_kernel.c): the only loops over coefficients ---------------------
 * `block` is rows x columns, row-major and contiguous. Order of summation, which any faster kernel
 * must keep so that results are the same bits: a sum over columns runs in 8 lanes (lane = column
 * mod 8, ascending), which are added as ((0+4)+(2+6))+((1+5)+(3+7)); a sum over rows is ascending.
 */

/* y += B m; m: columns, y: rows. */
void thrum_kernel_product(int64_t rows, int64_t columns, const double *block, const double *m,
                          double *y);

/* w += B^T x; x: rows, w: columns. */
void thrum_kernel_transposed(int64_t rows, int64_t columns, const double *block, const double *x,
                             double *w);

/* Both of the above in one pass over B. */
void thrum_kernel_both(int64_t rows, int64_t columns, const double *block, const double *m,
                       const double *x, double *y, double *w);

/* Both, for two pairs (m, x) at once: y[2][rows] and w[2][columns] at the given pointers. */
void thrum_kernel_both_twice(int64_t rows, int64_t columns, const double *block,
                             const double *const m[2], const double *const x[2], double *const y[2],
                             double *const w[2]);

/* sum a_i b_i in the lanes above. */
double thrum_kernel_dot(int64_t count, const double *a, const double *b);

/* b += s a. */
void thrum_kernel_axpy(int64_t count, double s, const double *a, double *b);

/* m_kl = q_k q_l over the pairs of n coordinates. */
void thrum_pair_monomials(int64_t n, const double *q, double *m);

/* gradient += grad of sum_{k<=l} w_kl q_k q_l. */
void thrum_pair_gradient(int64_t n, const double *w, const double *q, double *gradient);

/* --- V with the first `split` coordinates held ---------------------------------------------------
 * n = rank - split coordinates remain. A restricted polynomial is one array of
 * thrum_restricted_count(n) doubles:
 *   linear    n
 *   quadratic n (n + 1) / 2, each monomial once in pair order, 1/2 omega^2 included
 *   cubic     thrum_c3_count(n), block order of thrum/model.h
 * Its quartic part is a sub-block of c4, which is read from the model where it lies: so the
 * functions that use a restricted polynomial take the model and the split again. */
int64_t thrum_restricted_count(int64_t n);

/* Restricts V at q (rank; the entries from split on are not read) into `restricted`; returns the
 * constant term V(q_E, 0). work: thrum_work_count(model). */
double thrum_polynomial_restrict(const thrum_model *model, int32_t split, const double *q,
                                 double *restricted, double *work);

/* Value at q_high (n), constant term left out; `gradient` (n) gets R_I. work as above. */
double thrum_restricted_gradient(const thrum_model *model, int32_t split, const double *restricted,
                                 const double *q_high, double *gradient, double *work);

/* `hessian` (n x n, both triangles) gets T_II at q_high. work as above. */
void thrum_restricted_hessian(const thrum_model *model, int32_t split, const double *restricted,
                              const double *q_high, double *hessian, double *work);

#endif
