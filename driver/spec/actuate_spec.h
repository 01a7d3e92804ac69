/* Levels of actuators over time, as the command line has them: NAME=KIND:LEVEL[,key=value...].
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_ACTUATE_SPEC_H
#define THRUM_DRIVER_SPEC_ACTUATE_SPEC_H

#include "config/options.h"
#include "thrum/thrum.h"

enum { ACTUATE_NAME_MAX = 61 };

/* One course of one actuator; those of the same name add up. `text` is borrowed from argv. */
typedef struct actuate_spec {
  const char *text;
  char name[ACTUATE_NAME_MAX];
  double level;
  thrum_load course;
} actuate_spec;

#define OPTION_ACTUATE(take_, what_)                                                               \
  OPTION_TEXT("actuate", "NAME=KIND:LEVEL", "all at 0", what_, .repeats = true, .take = take_)

/* Reads NAME=KIND:LEVEL[,key=value...]. */
thrum_status actuate_spec_parse(const char *text, actuate_spec *spec, thrum_error *error);

/* For the `take` of an option: parses the text into specs[*count], of which there is room. */
thrum_status actuate_option_take(const config_given *given, actuate_spec *specs, int64_t *count);

/* Refuses names that are none of the model's actuators. */
thrum_status actuate_specs_check(const thrum_model *model, const actuate_spec *specs, int64_t count,
                                 thrum_error *error);

/* Does anything act: are there courses, or has the model a gas, which acts at level 0 as well? */
bool actuate_specs_act(const thrum_model *model, int64_t count);

/* Refuses a model with a gas, which `what` would leave out. */
thrum_status actuate_specs_no_gas(const thrum_model *model, const char *what, thrum_error *error);

/* Warns of courses without effect in a run of `time` s, whole or reduced: they begin too late, or
 * pull at a body that nothing holds. The names were checked. */
void actuate_specs_warn(const thrum_model *model, const actuate_spec *specs, int64_t count,
                        double time, bool full);

/* Their mean levels over a step into `levels` (of all actuators of the model), or their whole
 * strength times a factor. The names were checked. */
void actuate_specs_levels(const thrum_model *model, const actuate_spec *specs, int64_t count,
                          int64_t step, double dt, double *levels);
void actuate_specs_strength(const thrum_model *model, const actuate_spec *specs, int64_t count,
                            double factor, double *levels);

#endif
