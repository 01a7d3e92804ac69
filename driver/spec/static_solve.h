/* An equilibrium under the loads of a command line. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_STATIC_SOLVE_H
#define THRUM_DRIVER_SPEC_STATIC_SOLVE_H

#include "driver/spec/actuate_spec.h"
#include "driver/spec/load_spec.h"

/* The receiver of each point of the load path; `report` may be NULL. */
typedef struct static_progress {
  void (*report)(void *context, const thrum_equilibrium_point *point);
  void *context;
} static_progress;

/* What is to be in equilibrium, under `count` loads at their full strength together. */
typedef struct static_problem {
  const thrum_model *model;
  const char *said; /* a failure and warnings begin with it */
  const load_spec *loads;
  int64_t count;
  const actuate_spec *actuates; /* and levels of actuators at their full strength */
  int64_t actuate_count;
  bool from; /* q is an equilibrium under some load, from which the path goes to these */
  static_progress progress;
  thrum_equilibrium_def def;
} static_problem;

/* The equilibrium. q (rank): where to begin, and the answer; mode (rank) may be NULL. A failure
 * changes nothing. */
thrum_status static_solve(const static_problem *problem, double *q, double *mode,
                          thrum_equilibrium_report *report, thrum_error *error);

/* Frequency [Hz] of a squared angular one; that of its magnitude, negative, where it is negative.
 */
double static_hertz(double omega2);

#endif
