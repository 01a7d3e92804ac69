/* Tests for NaN and infinity. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_FINITE_H
#define THRUM_CORE_BASE_FINITE_H

#include <stdbool.h>
#include <stdint.h>

/* True when all n values are finite. */
bool thrum_all_finite(const double *values, int64_t n);

/* True when all n values are numbers of at most this magnitude. */
bool thrum_all_within(const double *values, int64_t n, double most);

#endif
