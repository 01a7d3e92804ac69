/* The questions that a state asks of cubature points when it is made. Private to runtime/.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_POINTS_KERNEL_POINTS_H
#define THRUM_RUNTIME_POINTS_KERNEL_POINTS_H

#include <stdint.h>

#include "core/polynomial/kernel_private.h"

/* The passes over cubature points in plain C. */
extern const thrum_kernel thrum_points_reference;

/* c3_jjs of all s != j, into c3 (rank), and c4_jjjj of a model of points. */
void thrum_points_along(const thrum_model *model, int64_t j, double *c3, double *c4);

#endif
