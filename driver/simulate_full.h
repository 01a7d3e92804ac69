/* A run of `thrum simulate --full`: what of it is not that of a reduced model.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SIMULATE_FULL_H
#define THRUM_DRIVER_SIMULATE_FULL_H

#include "driver/simulate_run.h"

/* Checks that the full order can do what is asked for, and picks its integrator where none is
 * named. COMMAND_DONE, or the exit code after its line has been printed. */
int simulate_full_check(simulate_request *request);

/* Makes the body with its loads and start. On failure simulate_full_close frees what there is. */
thrum_status simulate_full_open(simulation *run, thrum_error *error);
void simulate_full_close(simulation *run);

/* One step under its loads; its work is counted. THRUM_FELL_BACK where shorter ones were needed. */
thrum_status simulate_full_step(simulation *run, int64_t step);

/* run->q (coordinates nearest to the body), energies (may be NULL), and the peak into the figures.
 */
thrum_status simulate_full_see(simulation *run, thrum_energies *energies, thrum_error *error);

/* A frame of the present step; base [m] is added. */
thrum_status simulate_full_frame(simulation *run, double time, const double base[3],
                                 thrum_error *error);

/* run->q and run->p of the present step. */
void simulate_full_get(simulation *run);

thrum_state_report simulate_full_report(const simulation *run);
thrum_full_report simulate_full_figures(const simulation *run);

/* Adds "full" to the object: null for a run of a reduced model. */
void simulate_full_json(const simulate_figures *figures, cJSON *object);

#endif
