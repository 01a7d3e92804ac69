/* Passes over the coefficients of V(q), design (1), one table of them for each instruction set.
 * Private to runtime/.
 *
 * Every table gives the same bits for finite results. What fixes them: no fused multiply-add, and
 *   - over a whole model, each of whose terms of degree 3 and 4 is q_d q_c q_b q_a with
 *     d >= c >= b >= a >= -1 and q_{-1} = 1 (runtime/polynomial/packed.h): x_dc = q_c q_d; m_ba =
 * q_b q_a; y_dc, over the columns (b,a), runs in 8 lanes, number of the column mod 8, ascending;
 * w_ba, over the rows, has c ascending and within it d descending. With y held: g_d adds q_c y_dc,
 * c ascending, and s_c sums y_dc q_d in lanes n-1-d mod 8. With w held: g_a adds q_b w_ba, b
 *     ascending, and s_b sums w_ba q_a in lanes a+1 mod 8. A gradient is (g + g) + (s + s), those
 *     with y held first;
 *   - a tangent by pairs (runtime/polynomial/packed.h): y_P sums the columns from its group's on,
 * in lanes, then adds w_P, which has the rows before its group ascending. The gradient is a third
 * of g + s, as above with y for w, V a sixth of the sum of m y in lanes; a tangent times v that
 * comes by pairs is g + s with v for q;
 *   - of the explicit modes alone, in mirrored coordinates (runtime/polynomial/packed.h), the same
 * with rows ascending, d in lanes d-c mod 8;
 *   - with the explicit modes held, over n mirrored coordinates, likewise; w_ba, within c, has the
 *     state's own row first; s_c is (l_c + the own row's y) + the sum of y_dc z_d. Restricting, own
 *     rows add up d ascending; what is linear and quadratic has the other order, its y summed over
 *     the columns that are held;
 *   - lanes are added as ((0+4)+(2+6))+((1+5)+(3+7)).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POLYNOMIAL_KERNEL_PRIVATE_H
#define THRUM_RUNTIME_POLYNOMIAL_KERNEL_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/kernel.h"
#include "thrum/model.h"

/* Number of pairs (k, l), k <= l, of n coordinates. */
static inline int64_t thrum_pair_count(int64_t n) {
  return n * (n + 1) / 2;
}

/* As many numbers in whole vectors. */
static inline int64_t thrum_whole(int64_t count) {
  return (count + 7) / 8 * 8;
}

/* Lengths of the scratch arrays of a pass: whole lanes, and one vector to spare. */
static inline int64_t thrum_padded(int64_t count) {
  return thrum_whole(count) + 8;
}

/* Rows of scratch of a sweep. */
#define THRUM_SWEEP_VECTORS 9

#define THRUM_SMALL_PIVOT 0.015625 /* beside the diagonal entry that it was */

/* Vectors of corrections a b^T + c d^T: `count` of each, `stride` doubles apart. */
typedef struct thrum_two {
  const double *a, *b, *c, *d;
  int64_t count, stride;
} thrum_two;

/* Scratch `work` may have any content and overlaps no other argument. The first five read all
 * coefficients of a model once, packed (thrum_model_pack), the last two of them those of a small
 * model by pairs, which are more; the reference does without packing too. None has anything of the
 * quadratic terms of a model but restrict_to. */
typedef struct thrum_kernel {
  thrum_kernel_id id;

  /* Cubic and quartic terms at q. */
  double (*energy)(const thrum_model *model, const double *q, double *work);

  /* gradient += their gradient; returns their value, the same bits as `energy`. */
  double (*force)(const thrum_model *model, const double *q, double *gradient, double *work);

  /* The same at two points, the bits of `force` at each. */
  void (*forces)(const thrum_model *model, const double *const q[2], double *const gradient[2],
                 double value[2], double *work);

  /* hessian (rank x rank) += their Hessian; on entry it must be symmetric. `gradient`, if not NULL,
   * as `force`, which also gives the value; its last bits are others. Has more scratch. */
  double (*tangent)(const thrum_model *model, const double *q, double *gradient, double *hessian,
                    double *work);

  /* product += (Hessian at q) v. */
  void (*tangent_vector)(const thrum_model *model, const double *q, const double *v,
                         double *product, double *work);

  /* The first `split` entries of `force`, and the value; and of `tangent_vector` for a v whose
   * others are zero. Their last bits are others. */
  double (*force_part)(const thrum_model *model, int64_t split, const double *q, double *gradient,
                       double *work);
  void (*tangent_vector_part)(const thrum_model *model, int64_t split, const double *q,
                              const double *v, double *product, double *work);

  /* V with the first `split` coordinates held at q, without the constant, see polynomial.h; then
   * its gradient and value at q (n), and its Hessian (n x n), which has more scratch. */
  void (*restrict_to)(const thrum_model *model, int64_t split, const double *q, double *restricted,
                      double *work);
  double (*restricted_gradient)(const thrum_model *model, int64_t split, const double *restricted,
                                const double *q, double *gradient, double *work);
  void (*restricted_hessian)(const thrum_model *model, int64_t split, const double *restricted,
                             const double *q, double *hessian, double *work);

  /* y = matrix x for a symmetric matrix (n x n), no overlap: sums ascending, down a column. */
  void (*product)(int64_t n, const double *matrix, const double *x, double *y);

  /* matrix (n x n) += a b^T + c d^T for each of the pairs, in their order: all of it, or the lower
   * triangle, and then what is above the diagonal is useless. */
  void (*rank_two)(int64_t n, bool lower, const thrum_two *pairs, double *matrix);

  /* Sweeps the pivots of a symmetric matrix, n even, in their order, two by two, while each is
   * positive and not small beside the diagonal entry that it was; returns how many. A row takes
   * thrum_whole(n) doubles, zero beyond n. On entry it is there whole; in the end what is
   * above the diagonal is useless. work: THRUM_SWEEP_VECTORS rows. */
  int64_t (*sweep)(int64_t n, double *matrix, double *work);
} thrum_kernel;

/* Plain C, for every machine, and what the others are tested against. */
extern const thrum_kernel thrum_kernel_reference;

/* Those that this build has. */
#if (defined(__x86_64__) || defined(__i386__)) && defined(__GNUC__)
#define THRUM_KERNEL_HAS_X86 1
extern const thrum_kernel thrum_kernel_avx2;
extern const thrum_kernel thrum_kernel_avx512;
#endif
#if defined(__aarch64__) && defined(__ARM_NEON)
#define THRUM_KERNEL_HAS_ARM 1
extern const thrum_kernel thrum_kernel_neon;
#endif
#if defined(__wasm_simd128__)
#define THRUM_KERNEL_HAS_WASM 1
extern const thrum_kernel thrum_kernel_wasm;
#endif

/* The table of this number, or the best one here when this machine cannot run it. */
const thrum_kernel *thrum_kernel_get(int32_t id);

#endif
