/* The step of linearly implicit Euler; private to the runtime, see semi_implicit_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_SEMI_IMPLICIT_EULER_H
#define THRUM_RUNTIME_COMPARISON_SEMI_IMPLICIT_EULER_H

#include "core/schemes/schemes.h"

/* Its row. */
extern const thrum_scheme_row thrum_semi_implicit_euler_scheme;

#endif
