/* The passes over the coefficients of a model of which steps are made, one at a time, to be timed:
 * how fast a machine and a kernel are at each of them (`thrum bench kernels`), and how much work
 * it is. With E the first `explicit_modes` modes and I the others, n = |I|.
 *
 * Pure functions; nothing is allocated; any thread, as long as each has its own result and work.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_KERNEL_PASS_H
#define THRUM_KERNEL_PASS_H

#include "thrum/api.h"
#include "thrum/kernel.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* X(NAME, operations per coefficient, key, text). The tangents of small models read other numbers,
 * by pairs of modes (thrum_model_pack), with 4 operations each. */
#define THRUM_PASS_LIST(X)                                                                         \
  X(ENERGY, 2, "energy", "V")                                                                      \
  X(FORCE, 4, "force", "R and V")                                                                  \
  X(TANGENT, 6, "tangent", "T")                                                                    \
  X(TANGENT_VECTOR, 8, "tangent_vector", "T v")                                                    \
  X(RESTRICT, 2, "restrict", "V at held q_E") /* the polynomial in the modes I that is left */     \
  X(RESTRICTED_TANGENT, 6, "restricted_tangent", "T_II") /* its second derivatives */

typedef enum thrum_pass {
#define X(name, operations, key, text) THRUM_PASS_##name,
  THRUM_PASS_LIST(X)
#undef X
      THRUM_PASS_COUNT
} thrum_pass;

/* Doubles that the results of all passes take. */
THRUM_API size_t thrum_pass_result_count(const thrum_model *model);

/* Runs one pass at q with the direction v (rank each). Its result comes first in `result`
 * (thrum_pass_result_count(model) doubles): V; R; T or T_II, row-major; or T v; that of
 * THRUM_PASS_RESTRICT comes last, and THRUM_PASS_RESTRICTED_TANGENT reads it there, so restrict
 * first. `work` is scratch of thrum_work_count(model) doubles, aligned to 64. A kernel that this
 * machine has not is replaced as thrum_kernel_chosen says. THRUM_INVALID_ARGUMENT for NULL, a pass
 * that is none, and explicit_modes outside 0..rank; THRUM_MISSING for a model without a polynomial
 * or points. Results may be beyond the range of finite numbers where V is. */
THRUM_API thrum_status thrum_pass_run(const thrum_model *model, thrum_kernel_id kernel,
                                      thrum_pass pass, int32_t explicit_modes, const double *q,
                                      const double *v, double *result, double *work,
                                      thrum_error *error);

/* Additions and multiplications of a pass, and the numbers of the model that it reads, each once;
 * for a packed model of 1 to THRUM_RANK_MAX modes. 0 for other arguments. */
typedef struct thrum_pass_cost {
  double operations;
  double coefficients;
} thrum_pass_cost;
THRUM_API thrum_pass_cost thrum_pass_cost_of(int64_t rank, thrum_pass pass, int64_t explicit_modes);

#ifdef __cplusplus
}
#endif
#endif
