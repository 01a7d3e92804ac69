/* Loads that a basis cannot follow, said before a run. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PULL_WARNING_H
#define THRUM_DRIVER_MAKE_PULL_WARNING_H

#include "driver/spec/load_spec.h"
#include "precompute/model/blow.h"

/* Vertices beyond which the mesh is not factored just for a warning, as the user would wait long
 * for it. */
#define PULL_VERTICES_MOST 20000

/* Warns of every force at a vertex or a group that the model follows by less than 80 % of the
 * mesh's linear static answer, and says what to do. `name`: what the model was asked for by. Says
 * nothing of larger meshes, and where it cannot be known. */
void pull_warning_print(const char *name, const thrum_model *model, const load_spec *loads,
                        int64_t count);

/* What the only load of a run, where it lasts BLOW_STEPS steps of `dt` or less, gives the mesh and
 * the model's basis; zeros where there is another load, of larger meshes, and where it cannot be
 * known. */
#define BLOW_STEPS 10
thrum_blow pull_measure_blow(const thrum_model *model, const load_spec *loads, int64_t count,
                             double dt);

#endif
