/* The step of the quadratic split; private to the runtime, see quadratic_split.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_QUADRATIC_SPLIT_H
#define THRUM_RUNTIME_COMPARISON_QUADRATIC_SPLIT_H

#include "core/schemes/schemes.h"

/* Its row. */
extern const thrum_scheme_row thrum_quadratic_scheme;

#endif
