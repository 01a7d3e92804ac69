/* The coefficients of V as the matrix that gives its second derivatives; private to the accelerator
 * library. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_COEFFICIENTS_H
#define THRUM_ACCELERATOR_COEFFICIENTS_H

#include <stdint.h>

#include "thrum/model.h"

/* Adds, for each cubic coefficient, what it contributes to d2V/dq_a dq_b into row q_c, and for each
 * quartic one into row `first` + pair (c, d), of `matrix`, whose rows have `columns` numbers;
 * column and row of a pair (k, l), k <= l, are k rank - k (k - 1) / 2 + l - k. */
void second_derivatives(const thrum_model *model, float *matrix, int64_t columns, int64_t first);

#endif
