/* The step of backward Euler; private to the runtime, see backward_euler.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_COMPARISON_BACKWARD_EULER_H
#define THRUM_RUNTIME_COMPARISON_BACKWARD_EULER_H

#include "core/schemes/schemes.h"

/* How it turns a linear mode with z = h omega, and answers a force: by what holds at the end of the
 * step. */
thrum_mode_factor thrum_backward_euler_frequency(const thrum_model *model, const thrum_state *state,
                                                 int32_t i, double z);
thrum_mode_answer thrum_backward_euler_answer(const thrum_model *model, const thrum_state *state,
                                              int32_t own, int32_t i);

/* Its row. */
extern const thrum_scheme_row thrum_backward_euler_scheme;

#endif
