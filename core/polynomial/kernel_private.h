/* Passes over the coefficients of V(q), design (1), one table of them for each instruction set.
 * Private to libthrum.
 *
 * Every table gives the same bits for finite results. The following rules fix them; there is no
 * fused multiply-add.
 *
 * Whole model. Each term of degree 3 and 4 is q_d q_c q_b q_a with d >= c >= b >= a >= -1 and
 * q_{-1} = 1 (core/polynomial/packed.h); x_dc = q_c q_d and m_ba = q_b q_a.
 *   - y_dc is summed over the columns (b,a) in 8 lanes, the column's number mod 8, ascending.
 *   - w_ba is summed over the rows with c ascending and, within c, d descending.
 *   - With y held, g_d adds q_c y_dc with c ascending, and s_c sums y_dc q_d in lanes n-1-d mod 8.
 *   - With w held, g_a adds q_b w_ba with b ascending, and s_b sums w_ba q_a in lanes a+1 mod 8.
 *   - A gradient is (g + g) + (s + s), where the terms with y held come first.
 *
 * Tangent by pairs (core/polynomial/packed.h).
 *   - y_P sums the columns from the first of its group on, in lanes, and then adds w_P, which sums
 *     the rows before its group in ascending order.
 *   - The gradient is a third of g + s, as above with y in place of w; V is a sixth of the sum of
 *     m y in lanes; a tangent times v by pairs is g + s with v in place of q.
 *
 * Explicit modes alone, in mirrored coordinates (core/polynomial/packed.h). The order is that of
 * the whole model, but rows ascend and d is in lane d-c mod 8.
 *
 * Explicit modes held, over n mirrored coordinates. The order is that of the explicit modes alone.
 *   - Within c, w_ba begins with the state's own row.
 *   - s_c is (l_c + the own row's y) + the sum of y_dc z_d.
 *   - The restriction adds up own rows with d ascending. Linear and quadratic terms are in the
 *     order that is not mirrored, and their y is summed over the held columns.
 *
 * Cubature points (runtime/points/kernel_points.inl). Lanes are the points of a block, and the
 * law of the material is the same in each. A gradient sums the coordinates, and a product with
 * gradients its nine components, in ascending order; then blocks ascend. The lanes of a force are
 * added when all blocks are in them, those of a tangent in each block.
 *
 * Lanes are added as ((0+4)+(2+6))+((1+5)+(3+7)).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_POLYNOMIAL_KERNEL_PRIVATE_H
#define THRUM_CORE_POLYNOMIAL_KERNEL_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/kernel.h"
#include "thrum/model.h"

/* Number of pairs (k, l), k <= l, of n coordinates. */
static inline int64_t thrum_pair_count(int64_t n) {
  return n * (n + 1) / 2;
}

/* `count` rounded up to whole vectors of 8. */
static inline int64_t thrum_whole(int64_t count) {
  return (count + 7) / 8 * 8;
}

/* Length of a scratch array of a pass for `count` numbers: whole vectors and one to spare. */
static inline int64_t thrum_padded(int64_t count) {
  return thrum_whole(count) + 8;
}

/* Number of scratch rows of a sweep. */
#define THRUM_SWEEP_VECTORS 9

#define THRUM_SMALL_PIVOT 0.015625 /* smallest pivot relative to its first diagonal entry */

/* Vectors of the corrections a b^T + c d^T; there are `count` of each, `stride` doubles apart. */
typedef struct thrum_two {
  const double *a, *b, *c, *d;
  int64_t count, stride;
} thrum_two;

/* One kernel. The scratch `work` may have any content and overlaps no other argument. The first
 * five passes read all coefficients of a packed model once (thrum_model_pack); `tangent` and
 * `tangent_vector` read those of a small model by pairs, which are more numbers. The reference also
 * takes a model that is not packed. Only restrict_to evaluates quadratic terms of a model. */
typedef struct thrum_kernel {
  thrum_kernel_id id;

  /* Returns the sum of the cubic and quartic terms of V at q. */
  double (*energy)(const thrum_model *model, const double *q, double *work);

  /* gradient += the gradient of these terms; returns their sum with the bits of `energy`. */
  double (*force)(const thrum_model *model, const double *q, double *gradient, double *work);

  /* Evaluates `force` at two points, with its bits at each. */
  void (*forces)(const thrum_model *model, const double *const q[2], double *const gradient[2],
                 double value[2], double *work);

  /* hessian (rank x rank) += the Hessian of these terms; on entry it must be symmetric. Adds the
   * gradient to `gradient`, if not NULL, and returns the value, as `force` but with other last
   * bits. It needs more scratch. */
  double (*tangent)(const thrum_model *model, const double *q, double *gradient, double *hessian,
                    double *work);

  /* product += (Hessian at q) v. */
  void (*tangent_vector)(const thrum_model *model, const double *q, const double *v,
                         double *product, double *work);

  /* The first adds the first `split` entries of `force` and returns the value; the second adds
   * those of `tangent_vector` for a v that is zero beyond them. Their last bits differ. */
  double (*force_part)(const thrum_model *model, int64_t split, const double *q, double *gradient,
                       double *work);
  void (*tangent_vector_part)(const thrum_model *model, int64_t split, const double *q,
                              const double *v, double *product, double *work);

  /* The first writes V with the first `split` coordinates held at q, without its constant (see
   * polynomial.h). The second gives its gradient and value at q (n), the third its Hessian (n x n),
   * which needs more scratch. */
  void (*restrict_to)(const thrum_model *model, int64_t split, const double *q, double *restricted,
                      double *work);
  double (*restricted_gradient)(const thrum_model *model, int64_t split, const double *restricted,
                                const double *q, double *gradient, double *work);
  void (*restricted_hessian)(const thrum_model *model, int64_t split, const double *restricted,
                             const double *q, double *hessian, double *work);

  /* y (n) = matrix^T x (rows) for a matrix rows x n; the arguments do not overlap. Each sum runs
   * down a column in ascending order. */
  void (*product)(int64_t rows, int64_t n, const double *matrix, const double *x, double *y);

  /* matrix (n x n) += a b^T + c d^T for each of the pairs, in their order. With `lower` only the
   * lower triangle holds afterwards, and entries above the diagonal are undefined. */
  void (*rank_two)(int64_t n, bool lower, const thrum_two *pairs, double *matrix);

  /* Sweeps the pivots of a symmetric matrix, n even, in their order, two at a time, while each is
   * positive and not small relative to its first diagonal entry; returns how many were swept. A row
   * takes thrum_whole(n) doubles and is zero beyond n. On entry the whole matrix holds; afterwards
   * entries above the diagonal are undefined. work: THRUM_SWEEP_VECTORS rows. */
  int64_t (*sweep)(int64_t n, double *matrix, double *work);

  /* The passes above up to restricted_hessian for a model of cubature points
   * (core/polynomial/points.h), with the nonlinear part of V in place of its cubic and quartic
   * terms; the others are NULL. NULL: those in plain C (thrum_passes). */
  const struct thrum_kernel *points;
} thrum_kernel;

/* Plain C for every machine, against which the others are tested. */
extern const thrum_kernel thrum_kernel_reference;

/* What evaluates V beside the plain C of this folder: kernels for the processor, and the passes
 * over cubature points. The library that is linked has one such set, a const table; one without
 * them has NULL where they would be, and then no model of points has an energy. */
typedef struct thrum_pass_set {
  /* The kernel of this id where this build and this processor have it, else NULL; the fastest one
   * for THRUM_KERNEL_BEST. */
  const thrum_kernel *(*kernel)(int32_t id);

  /* The passes over cubature points in plain C. */
  const thrum_kernel *points;

  /* c3_jjs of all s != j, into c3 (rank), and c4_jjjj of a model of points. */
  void (*along)(const thrum_model *model, int64_t j, double *c3, double *c4);

  /* Of a model whose points may flow (18.7): the terms of V that were released; where its points
   * see q, into `seen` (rank); and a force or a tangent of theirs, taken from there to q in place.
   */
  double (*released_energy)(const thrum_model *model, const double *q);
  void (*see)(const thrum_model *model, const double *q, double *seen);
  void (*return_force)(const thrum_model *model, double *force);
  void (*return_tangent)(const thrum_model *model, double *tangent);

  /* Of a model with levels: returns what acts adds to V at q, and adds its gradient to `gradient`
   * and its Hessian to `hessian` (rank x rank), each where it is not NULL. A Hessian that is for a
   * Jacobian alone, to which it adds `weight` times itself, need not have what is little there;
   * weight 0: it must. */
  double (*act)(const thrum_kernel *by, const thrum_model *model, const double *q, double *gradient,
                double *hessian, double weight);

  /* product += that Hessian at q times v. */
  void (*act_along)(const thrum_kernel *by, const thrum_model *model, const double *q,
                    const double *v, double *product);
} thrum_pass_set;

extern const thrum_pass_set thrum_passes;

/* The table of this number, or the best one here when this machine cannot run it. */
const thrum_kernel *thrum_kernel_get(int32_t id);

#endif
