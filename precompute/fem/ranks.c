/* A body that several processes share, see ranks.h. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/ranks.h"

#include <cblas.h>
#include <stddef.h>

void thrum_ranks_sum(const thrum_ranks *ranks, double *numbers, int64_t count) {
  if (ranks != NULL)
    ranks->sum(ranks->context, numbers, count);
}

void thrum_ranks_largest(const thrum_ranks *ranks, double *numbers, int64_t count) {
  if (ranks != NULL)
    ranks->largest(ranks->context, numbers, count);
}

double thrum_ranks_norm(const thrum_ranks *ranks, const double *x, int64_t count) {
  return ranks != NULL ? ranks->norm(ranks->context, x) : cblas_dnrm2((int)count, x, 1);
}

thrum_status thrum_ranks_force_norm(const thrum_ranks *ranks, double *force, int64_t count,
                                    double *norm, thrum_error *error) {
  if (ranks != NULL)
    THRUM_TRY(ranks->add_terms(ranks->context, force, error));
  *norm = thrum_ranks_norm(ranks, force, count);
  return THRUM_OK;
}

int64_t thrum_ranks_size(const thrum_ranks *ranks, int64_t here) {
  return ranks != NULL ? ranks->size : here;
}
