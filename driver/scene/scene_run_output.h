/* The files of a scene's run: for each body those of a run of it alone, and the probes.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_RUN_OUTPUT_H
#define THRUM_DRIVER_SCENE_SCENE_RUN_OUTPUT_H

#include "driver/scene/scene_run_parts.h"

/* The folder, the files of the bodies and the probes; and the runs of the
 * bodies completed. */
thrum_status scene_run_open(scene_run *run, thrum_error *error);
thrum_status scene_run_record_probes(scene_run *run, int64_t step, double time, thrum_error *error);
thrum_status scene_run_end(scene_run *run, thrum_error *error);

/* The same without the judgement of bases, which has not come back. */
thrum_status scene_run_end_unjudged(scene_run *run, thrum_error *error);

#endif
