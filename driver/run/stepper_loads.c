/* Loads and base motions of a single body, and their work. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/stepper_loads.h"

#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"

thrum_status stepper_loads_open(const simulate_request *request, int64_t size, stepper_loads *loads,
                                thrum_error *error) {
  const size_t entries = (size_t)size, count = (size_t)request->load_count;
  *loads = (stepper_loads){.request = request, .size = size};
  THRUM_TRY(thrum_reserve(&loads->memory, (int64_t)((4 + count) * entries), sizeof *loads->memory,
                          "a run of this model", error));
  THRUM_TRY(thrum_reserve(&loads->courses, request->load_count, sizeof *loads->courses,
                          "a run of this model", error));

  // one allocation holds all vectors
  loads->force = loads->memory;
  loads->inertia = loads->force + entries;
  loads->before = loads->inertia + entries;
  loads->after = loads->before + entries;
  loads->directions = loads->after + entries;

  // the time courses, and the files of the base motions
  for (int64_t n = 0; n < request->load_count; n++)
    loads->courses[n] = request->loads[n].course;
  for (int64_t n = 0; n < request->base_motion_count; n++)
    THRUM_TRY(base_motion_read(&request->base_motions[n], error));
  return THRUM_OK;
}

void stepper_loads_close(stepper_loads *loads) {
  free(loads->memory);
  free(loads->courses);
  *loads = (stepper_loads){0};
}

bool stepper_loads_act(const stepper_loads *loads) {
  return loads->request->load_count > 0 || loads->request->base_motion_count > 0;
}

bool stepper_loads_sum(stepper_loads *loads, int64_t step, double mean[3]) {
  const simulate_request *request = loads->request;
  thrum_load_sum(loads->courses, loads->directions, request->load_count, loads->size, step,
                 request->def.dt, loads->force);
  if (request->base_motion_count == 0)
    return false;
  base_motions_mean(request->base_motions, request->base_motion_count, step, request->def.dt, mean);
  return true;
}

void stepper_loads_add_inertia(stepper_loads *loads) {
  for (int64_t n = 0; n < loads->size; n++)
    loads->force[n] += loads->inertia[n];
}

void stepper_loads_count_work(stepper_loads *loads) {
  const double all = thrum_load_work(loads->force, loads->before, loads->after, loads->size);
  const double base = thrum_load_work(loads->inertia, loads->before, loads->after, loads->size);
  loads->work_load += all - base;
  loads->work_base += base;
  loads->work_moved += fabs(all);
}

void stepper_loads_next(stepper_loads *loads) {
  double *kept = loads->before;
  loads->before = loads->after;
  loads->after = kept;
}
