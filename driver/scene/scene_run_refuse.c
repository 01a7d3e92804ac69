/* Refusals of a scene file by the line of what is refused. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_refuse.h"

#include <string.h>

thrum_status scene_run_no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the scene");
}

/* The key of a field, which most have as their name. */
static const char *key_of(const char *field) {
  static const char *const others[][2] = {
      {"plastic.yield", "yield"},
      {"plastic.creep", "creep"},
      {"plastic.largest", "largest_plastic_strain"},
      {"explicit_count", "split"},
      {"split_safety", "safety"},
      {"damping_alpha", "damping"},
      {"damping_beta", "damping"},
      {"newmark_beta", "newmark"},
      {"newmark_gamma", "newmark"},
      {"iterations_max", "iterations"},
      {"frequency_matched", "frequency_matching"},
      {"half", "size"},
  };
  for (size_t n = 0; n < sizeof others / sizeof others[0]; n++)
    if (strcmp(field, others[n][0]) == 0)
      return others[n][1];
  return field;
}

thrum_status scene_run_pass(const scene_run *run, const config_record *at, const char *key,
                            thrum_status status, const thrum_error *detail) {
  if (status >= 0)
    return THRUM_OK;
  if (key == NULL && detail->field != NULL)
    return config_record_refuse(&run->spec.file, at, key_of(detail->field), status, "%s",
                                thrum_error_reason(detail));
  return config_record_refuse(&run->spec.file, at, key, status, "%s",
                              detail->message[0] != 0 ? detail->message
                                                      : thrum_status_text(status));
}
