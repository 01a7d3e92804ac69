/* Samples between steps. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "validation/tradeoff/tradeoff.h"

void tradeoff_sample(double time, double begin, double dt, int64_t count, const double *from,
                     const double *to,
                     void (*take)(void *context, int64_t index, double share, const double *value),
                     void *context, double *work) {
  const double spacing = time / TRADEOFF_SAMPLES, slack = 1e-9 * spacing;
  // the samples in (begin, begin + dt]; the first step's begin belongs to no sample
  for (int64_t n = (int64_t)floor((begin + slack) / spacing) + 1;
       n <= TRADEOFF_SAMPLES && (double)n * spacing <= begin + dt + slack; n++) {
    const double s = ((double)n * spacing - begin) / dt, r = 1 - s;

    // cubic Hermite: values, then slopes
    for (int64_t i = 0; i < count; i++) {
      const double a = from[i], va = dt * from[count + i], b = to[i], vb = dt * to[count + i];
      work[i] = r * r * ((1 + 2 * s) * a + s * va) + s * s * ((3 - 2 * s) * b - r * vb);
      work[count + i] = (6 * s * r * (b - a) + r * (1 - 3 * s) * va + s * (3 * s - 2) * vb) / dt;
    }
    take(context, n - 1, s, work);
  }
}
