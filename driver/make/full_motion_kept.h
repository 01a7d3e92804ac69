/* Full-order runs that are kept in a folder, so that what was stopped goes on where it was, and a
 * run that two commands need is made once. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_FULL_MOTION_KEPT_H
#define THRUM_DRIVER_MAKE_FULL_MOTION_KEPT_H

#include "driver/make/full_motion.h"

/* Does the same as full_motion_run, but reads the run from the folder where it is there already: a
 * run of the same body, script, time step and number of samples, by the same build. Otherwise it
 * makes the run and keeps it in the folder, which it creates if needed. folder NULL: nothing is
 * kept. `mass`: of the body, a thrum_mass. */
thrum_status full_motion_kept(const char *folder, const thrum_model *model, int mass,
                              const full_motion_script *script, double dt,
                              const full_motion_observer *observer, double *us_per_step,
                              thrum_error *error);

/* The file in that folder: the name says all that the run depends on. */
#define FULL_MOTION_PATH_MAX 1200
thrum_status full_motion_kept_path(const char *folder, const thrum_model *model, int mass,
                                   const full_motion_script *script, double dt, int64_t samples,
                                   char path[FULL_MOTION_PATH_MAX], thrum_error *error);

#endif
