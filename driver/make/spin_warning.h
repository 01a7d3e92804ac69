/* A spin whose stretch a basis cannot show, said before a run. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_DRIVER_MAKE_SPIN_WARNING_H
#define THRUM_DRIVER_MAKE_SPIN_WARNING_H

#include "thrum/model.h"

/* Warns where a coupled body that turns with `spin` [rad/s], in its axes, shows less than 95 % of
 * what the spin stretches its mesh by (linear, at rest), and says what to do; `by` is how the body
 * is scaled. Says nothing of meshes that pull_warning.h leaves out, of a stretch below a 100,000th
 * of the body, and where it cannot be known. */
void spin_warning_print(const char *name, const thrum_model *model, const thrum_model_scaling *by,
                        const double spin[3]);

#endif
