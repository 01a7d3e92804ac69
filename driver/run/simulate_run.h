/* A run of a single model, from its request to its folder. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_SIMULATE_RUN_H
#define THRUM_DRIVER_RUN_SIMULATE_RUN_H

#include "driver/run/simulate_options.h"

/* Loads the model, steps it and writes the run; an exit code, after a line on standard error where
 * it is not 0. */
int simulate_run_request(const simulate_request *request);

#endif
