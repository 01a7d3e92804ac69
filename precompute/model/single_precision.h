/* Coefficients in single precision, see single_precision.c. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_MODEL_SINGLE_PRECISION_H
#define THRUM_PRECOMPUTE_MODEL_SINGLE_PRECISION_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

/* Rounds c3 and c4 of a model, whose arrays may be written, to the nearest single-precision
 * numbers. *worst: largest |R_single - R| / |R| over sampled q at which the nonlinear force is as
 * large as the linear one. THRUM_UNSUPPORTED, and the model as it was, when a coefficient is out of
 * their range; THRUM_OUT_OF_MEMORY. */
thrum_status thrum_single_precision_round(const thrum_model *model, double *worst,
                                          thrum_error *error);

/* Rounds `count` numbers to single precision, in place; false where one of them is beyond its
 * range, and then all stay. */
bool thrum_single_round(double *values, int64_t count);

#endif
