/* The static shapes of actuators, and how they bend on. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_BASIS_ACTUATOR_SHAPES_H
#define THRUM_PRECOMPUTE_BASIS_ACTUATOR_SHAPES_H

#include "precompute/fem/fem_actuators.h"

/* x = K^-1 f of each actuator, f its force at rest, scaled to x^T M x = 1: n x count, column-major;
 * omega2 (count): its Rayleigh quotient; lengths (count): sqrt(x^T M x) before; compliance (count):
 * f x. THRUM_INVALID_ARGUMENT for one that moves nothing. */
thrum_status thrum_actuator_responses(const thrum_fem *fem, const thrum_sparse *mass,
                                      thrum_factor *factor, int64_t count,
                                      const thrum_actuator *actuators, double *responses,
                                      double *omega2, double *lengths, double *compliance,
                                      thrum_error *error);

/* Adds to the derivatives of `shapes` fields (thrum_derivatives), of which the last `count` are
 * those above, what the stiffness of each actuator does to a field: K^-1 H x / length, twice to its
 * own. */
thrum_status thrum_actuator_derivatives(const thrum_fem *fem, thrum_factor *factor, int64_t count,
                                        const thrum_actuator *actuators, const double *lengths,
                                        int64_t shapes, const double *fields, double *derivatives,
                                        thrum_error *error);

#endif
