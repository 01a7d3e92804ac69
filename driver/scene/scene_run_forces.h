/* Forces that act on the mesh of a body of a scene at present, in the axes and the units of its
 * model as it is in its file: loads, obstacles, other bodies, links and wind.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_FORCES_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_FORCES_H

#include "driver/scene/scene_run_parts.h"

/* What acts on the mesh of a body now, after so many steps, in the axes and the
 * material of its model as it is in the file: forces (3 vertex_count) [N], and what acts on all of
 * its mass. */
thrum_status scene_run_forces(const scene_run *run, int32_t number, int64_t step, double *forces,
                              double acceleration[3], thrum_error *error);

#endif
