/* How far a run can be wrong by its basis: the mesh is asked at the end what it lacks at some rows
 * (precompute/model/basis_judge.h); where it is cheap enough, the run is then made again with the
 * directions that were lacking, and both are compared (basis_rerun.h).
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_BASIS_CHECK_H
#define THRUM_DRIVER_RUN_BASIS_CHECK_H

#include "driver/run/basis_record.h"

/* Judges the run of a model by itself, whose steps took so long, and leaves what is known in the
 * record's estimate. What cannot be judged is no failure. */
thrum_status basis_check_judge(basis_record *record, double seconds, thrum_error *error);

#endif
