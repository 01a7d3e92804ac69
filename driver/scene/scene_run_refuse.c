/* Refusals of a scene file by the line of what is refused. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_refuse.h"

thrum_status scene_run_no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the scene");
}

thrum_status scene_run_pass(const scene_run *run, const config_record *at, const char *key,
                            thrum_status status, const thrum_error *detail) {
  if (status >= 0)
    return THRUM_OK;
  return config_record_refuse(&run->spec.file, at, key, status, "%s",
                              detail->message[0] != 0 ? detail->message
                                                      : thrum_status_text(status));
}
