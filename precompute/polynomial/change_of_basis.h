/* The polynomial in other coordinates. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_CHANGE_OF_BASIS_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_CHANGE_OF_BASIS_H

#include <stdint.h>

#include "thrum/status.h"

/* Cubic and quartic coefficients (block order of thrum/model.h) of V(S q): change is S, rank x
 * rank, row-major. Outputs must not overlap inputs. Memory: 3 (r (r + 1) / 2)^2 numbers. */
thrum_status thrum_polynomial_change_basis(int64_t rank, const double *change, const double *c3,
                                           const double *c4, double *changed3, double *changed4,
                                           thrum_error *error);

#endif
