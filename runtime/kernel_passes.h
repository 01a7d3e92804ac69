/* The table of all passes of runtime/kernel.h, over vectors of 8 lanes, for a file that has
 * included runtime/kernel_lanes.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "kernel.h"
#include "kernel_packed.h"
// it needs the packed blocks
#include "kernel_model.h"
// these need evaluations
#include "kernel_part.h"
#include "kernel_restricted.h"

/* Whole lanes may go past the diagonal. */
PASS void pass_rank_two(int64_t n, bool lower, const double *a, const double *b, const double *c,
                        const double *d, double *matrix) {
  for (int64_t i = 0; i < n; i++) {
    const v8 ai = v8_set1(a[i]), ci = v8_set1(c[i]);
    const int64_t last = lower ? i + 1 : n;
    double *row = matrix + i * n;
    int64_t j = 0;
    for (; j < last && j + 8 <= n; j += 8) {
      const v8 more = v8_add(v8_mul(ai, v8_load(b + j)), v8_mul(ci, v8_load(d + j)));
      v8_store(row + j, v8_add(v8_load(row + j), more));
    }
    for (; j < last; j++)
      row[j] += a[i] * b[j] + c[i] * d[j];
  }
}

#define THRUM_KERNEL_TABLE(id)                                                                     \
  {                                                                                                \
    id, pass_energy, pass_force, pass_forces, pass_tangent, pass_tangent_vector, pass_force_part,  \
        pass_tangent_vector_part, pass_restrict, pass_restricted_gradient,                         \
        pass_restricted_hessian, pass_rank_two                                                     \
  }
