/* The polynomials of actuators in reduced coordinates. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_ACTUATOR_REDUCE_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_ACTUATOR_REDUCE_H

#include "precompute/fem/fem_actuators.h"

/* Adds the actuators to a model that has its basis: all arrays of thrum/model.h of them. compliance
 * (count): f K^-1 f of their forces at rest, for the share of their static answers that the basis
 * holds. */
thrum_status thrum_actuators_reduce(const thrum_fem *fem, int64_t count,
                                    const thrum_actuator *actuators, const double *compliance,
                                    thrum_model *model, thrum_error *error);

#endif
