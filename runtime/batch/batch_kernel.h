/* Passes over the coefficients for several states of one model at once: each coefficient is loaded
 * once for all of them. Private to runtime/.
 *
 * A vector holds one number of each state: entry i of an array of a batch is the `lanes` doubles at
 * [i * lanes]. Each state gets the operations of core/polynomial/kernel_private.h in the same
 * order, so the same bits as alone.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_BATCH_BATCH_KERNEL_H
#define THRUM_RUNTIME_BATCH_BATCH_KERNEL_H

#include "core/polynomial/packed.h"
#include "core/polynomial/polynomial_private.h"
#include "runtime/kernels/processor_kernel.h"

#define THRUM_BATCH_LANES_MAX 8

/* Number of columns of the packed coefficients: whole vectors and one to spare. */
static inline int64_t thrum_batch_columns(int64_t rank) {
  return thrum_padded(thrum_pack_first(rank));
}

/* Number of doubles of scratch that any pass needs, for each state. */
static inline int64_t thrum_batch_work(int64_t rank) {
  return 4 * thrum_batch_columns(rank) + 20 * (rank + 1) + rank * rank;
}

/* All arrays are aligned to 64, and the model is packed. `work` may have any content and overlaps
 * no other argument. */
typedef struct thrum_batch_kernel {
  int64_t lanes; /* number of states */

  /* thrum_internal_force_by: R(q) into force (rank), V(q) into energy (1). */
  void (*force)(const thrum_model *model, const double *q, double *force, double *energy,
                double *work);

  /* thrum_internal_force_tangent_by where the model has its coefficients by pairs: T(q) into
   * tangent (rank x rank) too. */
  void (*tangent_pairs)(const thrum_model *model, const double *q, double *force, double *energy,
                        double *tangent, double *work);

  /* thrum_internal_force_part: R(q) into force (the first `split`), V(q) into energy (1). */
  void (*force_part)(const thrum_model *model, int64_t split, const double *q, double *force,
                     double *energy, double *work);

  /* thrum_tangent_product_part: into product (the first `split`). */
  void (*tangent_vector_part)(const thrum_model *model, int64_t split, const double *q,
                              const double *v, double *product, double *work);

  /* thrum_polynomial_restrict: into restricted (thrum_restricted_count). */
  void (*restrict_to)(const thrum_model *model, int64_t split, const double *q, double *restricted,
                      double *work);

  /* thrum_restricted_gradient: into gradient (n) and value (1). */
  void (*restricted_gradient)(const thrum_model *model, int64_t split, const double *restricted,
                              const double *q_high, double *gradient, double *value, double *work);

  /* thrum_restricted_hessian: into hessian (n x n). */
  void (*restricted_hessian)(const thrum_model *model, int64_t split, const double *restricted,
                             const double *q_high, double *hessian, double *work);

  /* Prefetches `bytes` bytes. It stands in this table because a compiler drops a direct
   * call that only prefetches. */
  void (*ask_for)(const double *from, size_t bytes);
} thrum_batch_kernel;

/* The batch kernel with the instructions of a kernel of single states; NULL where there is none. */
const thrum_batch_kernel *thrum_batch_kernel_of(thrum_kernel_id id);

#ifdef THRUM_KERNEL_HAS_X86
extern const thrum_batch_kernel thrum_batch_kernel_avx2;
extern const thrum_batch_kernel thrum_batch_kernel_avx512;
#endif

#endif
