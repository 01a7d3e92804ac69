/* Passes over the coefficients of V(q), design (1), one table of them for each instruction set.
 * Private to runtime/.
 *
 * Every table gives the same bits for finite results. What fixes them: no fused multiply-add, and
 *   - over a whole model, each of whose terms of degree 3 and 4 is q_d q_c q_b q_a with
 *     d >= c >= b >= a >= -1 and q_{-1} = 1 (runtime/pack.h): x_dc = q_c q_d; m_ba = q_b q_a;
 *     y_dc, over the columns (b,a), runs in 8 lanes, number of the column mod 8, ascending; w_ba,
 * over the rows, has c ascending and within it d descending. With y held: g_d adds q_c y_dc, c
 *     ascending, and s_c sums y_dc q_d in lanes n-1-d mod 8. With w held: g_a adds q_b w_ba, b
 *     ascending, and s_b sums w_ba q_a in lanes a+1 mod 8. A gradient is (g + g) + (s + s), y's
 * first;
 *   - over a restricted form in n coordinates, in the order of thrum/model.h: x_i = q_i q_j;
 *     m_kl = q_k q_l; a sum over columns runs in 8 lanes, ascending: lane = k mod 8 for a column of
 * c3, number of (k,l) in the list of all pairs mod 8 for one of c4. Row i of block j of c3 and of
 * c4 share their lanes, c3 first, and give y_ij. A sum over rows is ascending: w_kl and g_k, over i
 *     within j and over j; the pair gradient of w adds q_k w_kl to g_l with k ascending, and the
 * sum of w_kl q_l, in lanes l mod 8, to s_k; that of y goes before it, with i <= j: lanes i mod 8,
 * j ascending; a gradient is g + s;
 *   - lanes are added as ((0+4)+(2+6))+((1+5)+(3+7)).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_KERNEL_H
#define THRUM_RUNTIME_KERNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/kernel.h"
#include "thrum/model.h"

/* Number of pairs (k, l), k <= l, of n coordinates. Lists of pairs have k outermost, so the pairs
 * with k >= j are the last thrum_pair_count(n - j) ones. */
static inline int64_t thrum_pair_count(int64_t n) {
  return n * (n + 1) / 2;
}

/* The cubic and quartic terms of a polynomial in n coordinates. c4 starts at its block 0; each of
 * its blocks is preceded by `skip` rows that belong to coordinates held elsewhere. */
typedef struct thrum_form {
  int64_t n;
  const double *c3;
  const double *c4;
  int64_t skip;
} thrum_form;

/* Lengths of the scratch arrays of a pass: whole lanes, and one vector to spare. */
static inline int64_t thrum_padded(int64_t count) {
  return (count + 7) / 8 * 8 + 8;
}

#define THRUM_KERNEL_PAIR_ARRAYS 3
#define THRUM_KERNEL_VECTORS 5

/* Doubles of scratch of any pass over a restricted form in n coordinates. */
static inline int64_t thrum_kernel_work(int64_t n) {
  return THRUM_KERNEL_PAIR_ARRAYS * thrum_padded(thrum_pair_count(n)) +
         (THRUM_KERNEL_VECTORS + 8) * thrum_padded(n);
}

/* The same for `hessian`, which has lists beside it: a row of c3's size. */
static inline int64_t thrum_kernel_work_hessian(int64_t n) {
  return thrum_kernel_work(n) + thrum_c3_count(n) + 2 * thrum_padded(thrum_pair_count(n)) +
         (n + 1) * (thrum_padded(n) + 24);
}

/* Scratch `work` may have any content and overlaps no other argument. The first six read all
 * coefficients of a model once, packed (thrum_model_pack); the reference does without packing too.
 * None has anything of the quadratic terms of a model but restrict_to. */
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

  /* V with the first `split` coordinates held at q, without the constant, see polynomial.h. */
  void (*restrict_to)(const thrum_model *model, int64_t split, const double *q, double *restricted,
                      double *work);

  /* gradient += grad of the form at q; returns its value. */
  double (*gradient)(const thrum_form *f, const double *q, double *gradient, double *work);

  /* hessian (n x n) += Hessian of the form at q. On entry it must be symmetric. Has more scratch.
   */
  void (*hessian)(const thrum_form *f, const double *q, double *hessian, double *work);

  /* gradient += grad of sum_{k<=l} w_kl q_k q_l; returns that sum. */
  double (*pairs)(int64_t n, const double *w, const double *q, double *gradient, double *work);

  /* matrix (n x n) += a b^T + c d^T: all of it, or the lower triangle, and then what is above the
   * diagonal is useless. */
  void (*rank_two)(int64_t n, bool lower, const double *a, const double *b, const double *c,
                   const double *d, double *matrix);
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
