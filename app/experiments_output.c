/* The files and the JSON object that all kinds of experiments share. SPDX-License-Identifier:
 * Apache-2.0 */
#include <stdio.h>

#include "app/experiments.h"
#include "app/results.h"
#include "config/progress.h"
#include "io/json.h"
#include "validation/experiments/run_outcome.h"

static const char *const kind_names[] = {"matrix", "long", "sweep", "extremes", "linear"};

thrum_status experiments_open(const experiments_request *request, const char *name,
                              thrum_file_writer *writer, thrum_error *error) {
  return results_open(request->output, name, writer, error);
}

thrum_status experiments_page(const experiments_request *request, const char *table,
                              thrum_error *error) {
  char name[64];
  cJSON *about = experiments_json(request, false);
  json_number(about, "dt", request->dt);
  snprintf(name, sizeof name, "%s.about.json", table);
  THRUM_TRY(results_write_json(request->output, name, about, error));
  results_make_page(request->output, kind_names[request->kind], table);
  return THRUM_OK;
}

bool experiments_progress(void *context, double fraction) {
  config_progress_update(context, "experiments", fraction);
  return true;
}

cJSON *experiments_json(const experiments_request *request, bool flagged) {
  cJSON *object = json_report("experiments", flagged ? "flagged" : "done");
  cJSON_AddStringToObject(object, "kind", kind_names[request->kind]);
  results_add_machine(object);
  json_string(object, "output", request->output);
  json_number(object, "threads", (double)request->threads);
  return object;
}

void experiments_json_levels(cJSON *object, const thrum_state_report *report) {
  cJSON *levels = cJSON_AddObjectToObject(object, "fallback_levels");
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    json_number(levels, experiment_level_names[n], (double)experiment_level(report, n));
}
