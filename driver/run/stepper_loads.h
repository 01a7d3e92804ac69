/* The loads that act on a single body over time, as vectors of its stepper: coordinates of a
 * reduced model, components of the full order. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_STEPPER_LOADS_H
#define THRUM_DRIVER_RUN_STEPPER_LOADS_H

#include "driver/run/simulate_options.h"

/* Arrays have `size` entries and lie in `memory`. */
typedef struct stepper_loads {
  const simulate_request *request;
  int64_t size;
  thrum_load *courses;         /* load_count */
  double *memory, *directions; /* load_count x size: each load at its full strength */
  double *force;               /* mean of all loads and the base over a step */
  double *inertia;             /* of the base alone, a part of force */
  double *before, *after;      /* configuration before and after a step */
  double work_load, work_base; /* [J] */
  double work_moved;           /* the magnitudes of the work of all steps, summed [J] */
} stepper_loads;

/* Allocates, zeroed, with the courses of the request's loads; stepper_loads_close frees, whatever
 * came back. Reads the files of the request's base motions too. */
thrum_status stepper_loads_open(const simulate_request *request, int64_t size, stepper_loads *loads,
                                thrum_error *error);
void stepper_loads_close(stepper_loads *loads);

/* Whether anything acts at all. */
bool stepper_loads_act(const stepper_loads *loads);

/* force = mean of the loads over a step. True where the base moves: its mean acceleration is then
 * in `mean`, and the caller makes inertia of it and calls stepper_loads_add_inertia. */
bool stepper_loads_sum(stepper_loads *loads, int64_t step, double mean[3]);
void stepper_loads_add_inertia(stepper_loads *loads);

/* Adds the work of the step from `before` to `after`. */
void stepper_loads_count_work(stepper_loads *loads);
/* The end of a step is the beginning of the next. */
void stepper_loads_next(stepper_loads *loads);

#endif
