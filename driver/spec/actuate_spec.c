/* Levels of actuators over time, see actuate_spec.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/actuate_spec.h"

#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/spec/load_spec.h"

thrum_status actuate_spec_parse(const char *text, actuate_spec *spec, thrum_error *error) {
  const size_t name = strcspn(text, "=");
  char said[200];
  if (text[name] != '=' || name == 0 || name >= sizeof spec->name)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "'%.100s': wanted is NAME=KIND:LEVEL, such as air=ramp:2e4,until=1",
                           text);
  actuate_spec parsed = {.text = text};
  memcpy(parsed.name, text, name);
  snprintf(said, sizeof said, "'%.150s'", text);
  THRUM_TRY(load_course_parse(text + name + 1, said, &parsed.level, &parsed.course, error));
  *spec = parsed;
  return THRUM_OK;
}

thrum_status actuate_option_take(const config_given *given, actuate_spec *specs, int64_t *count) {
  thrum_error error = {0};
  if (actuate_spec_parse(given->text, &specs[*count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  ++*count;
  return THRUM_OK;
}

thrum_status actuate_specs_check(const thrum_model *model, const actuate_spec *specs, int64_t count,
                                 thrum_error *error) {
  int64_t index = 0;
  for (int64_t n = 0; n < count; n++)
    THRUM_TRY(config_error_in(error, thrum_model_actuator(model, specs[n].name, &index, error),
                              "--actuate '%.100s'", specs[n].text));
  return THRUM_OK;
}

/* The first gas of a model; -1: it has none. */
static int64_t gas_of(const thrum_model *model) {
  for (int64_t k = 0; k < thrum_model_actuators(model); k++)
    if (model->actuator_kind[k] == THRUM_ACTUATOR_GAS)
      return k;
  return -1;
}

bool actuate_specs_act(const thrum_model *model, int64_t count) {
  return count > 0 || gas_of(model) >= 0;
}

thrum_status actuate_specs_no_gas(const thrum_model *model, const char *what, thrum_error *error) {
  const int64_t gas = gas_of(model);
  if (gas < 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the model has a gas (%.150s), whose stiffness %s would leave out: make a "
                         "model without it",
                         thrum_model_actuator_text(model, gas), what);
}

/* Does one of these pull at a body from a place that stays? */
static bool pulls_from_outside(const thrum_model *model, const actuate_spec *specs, int64_t count) {
  int64_t index = 0;
  for (int64_t n = 0; n < count; n++)
    if (thrum_model_actuator(model, specs[n].name, &index, NULL) >= 0 &&
        (strstr(thrum_model_actuator_text(model, index), ":at:") != NULL ||
         strstr(thrum_model_actuator_text(model, index), ",at:") != NULL))
      return true;
  return false;
}

void actuate_specs_warn(const thrum_model *model, const actuate_spec *specs, int64_t count,
                        double time, bool full) {
  for (int64_t n = 0; n < count; n++)
    if (specs[n].course.from >= time)
      config_warn("the level '%s' begins at %g s and has no effect: the run ends at %g s",
                  specs[n].text, specs[n].course.from, time);

  // a rope to such a place is the one actuator that pulls at a body as a whole
  if (!full && model->rigid != NULL && pulls_from_outside(model, specs, count))
    config_warn("nothing holds the body: what a rope would move it by as a whole has no effect; "
                "the rest deforms it");
}

static void add_levels(const thrum_model *model, const actuate_spec *spec, double factor,
                       double *levels) {
  int64_t index = 0;
  if (thrum_model_actuator(model, spec->name, &index, NULL) >= 0)
    levels[index] += factor * spec->level;
}

void actuate_specs_levels(const thrum_model *model, const actuate_spec *specs, int64_t count,
                          int64_t step, double dt, double *levels) {
  memset(levels, 0, (size_t)thrum_model_actuators(model) * sizeof *levels);
  for (int64_t n = 0; n < count; n++)
    add_levels(model, &specs[n], thrum_load_mean(&specs[n].course, step, dt), levels);
}

void actuate_specs_strength(const thrum_model *model, const actuate_spec *specs, int64_t count,
                            double factor, double *levels) {
  memset(levels, 0, (size_t)thrum_model_actuators(model) * sizeof *levels);
  for (int64_t n = 0; n < count; n++)
    add_levels(model, &specs[n], factor, levels);
}
