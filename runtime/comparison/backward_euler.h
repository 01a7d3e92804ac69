/* The step of backward Euler; private to the runtime, see backward_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_BACKWARD_EULER_H
#define THRUM_RUNTIME_COMPARISON_BACKWARD_EULER_H

#include "core/schemes/schemes.h"

/* Its row. */
extern const thrum_scheme_row thrum_backward_euler_scheme;

#endif
