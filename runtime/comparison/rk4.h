/* The step of the classical Runge-Kutta method; private to the runtime, see rk4.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_RK4_H
#define THRUM_RUNTIME_COMPARISON_RK4_H

#include "core/schemes/schemes.h"

/* Its row. */
extern const thrum_scheme_row thrum_rk4_scheme;

#endif
