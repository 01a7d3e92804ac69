/* The step of linearly implicit Euler; private to the runtime, see semi_implicit_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_SEMI_IMPLICIT_EULER_H
#define THRUM_RUNTIME_DYNAMICS_SEMI_IMPLICIT_EULER_H

#include "runtime/dynamics/schemes.h"

/* Its row. */
extern const thrum_scheme_row thrum_semi_implicit_euler_scheme;

#endif
