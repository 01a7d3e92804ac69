/* The files and the JSON object that all kinds of experiments share.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>

#include "app/experiments.h"
#include "app/results.h"
#include "config/progress.h"
#include "io/json.h"

const char *experiments_kind_name(experiments_kind kind) {
  static const char *const names[] = {"matrix", "long",       "sweep",          "extremes",
                                      "linear", "step_sizes", "work_precision", "variable"};
  return names[kind];
}

thrum_status experiments_write_rows(const experiments_request *request, const char *name,
                                    const cJSON *rows, thrum_error *error) {
  char file[64];
  thrum_file_writer writer = {NULL, NULL, NULL};
  snprintf(file, sizeof file, "%s.csv", name);
  THRUM_TRY(results_open(request->output, file, &writer, error));
  return thrum_file_writer_end(&writer, json_table_csv(writer.stream, rows, error), error);
}

/* The object {"status", "command", ...} to which the rows are added. */
static cJSON *report(const experiments_request *request, bool flagged) {
  cJSON *object = json_report("experiments", flagged ? "flagged" : "done");
  cJSON_AddStringToObject(object, "kind", experiments_kind_name(request->kind));
  results_add_machine(object);
  json_string(object, "output", request->output);
  json_number(object, "threads", (double)request->threads);
  json_number(object, "dt", request->dt);
  json_number(object, "time", request->time);
  return object;
}

static thrum_status write_files(const experiments_request *request, const experiments_table *tables,
                                int count, thrum_error *error) {
  char about[64];
  for (int n = 0; n < count; n++)
    THRUM_TRY(experiments_write_rows(request, tables[n].name, tables[n].rows, error));
  snprintf(about, sizeof about, "%s.about.json", tables[0].name);
  THRUM_TRY(results_write_json(request->output, about, report(request, false), error));
  results_make_page(request->output, experiments_kind_name(request->kind), tables[0].name);
  return THRUM_OK;
}

thrum_status experiments_publish(const experiments_request *request,
                                 const experiments_table *tables, int count, bool flagged,
                                 thrum_error *error) {
  const thrum_status status = write_files(request, tables, count, error);
  for (int n = 0; n < count && status >= 0 && !request->json; n++)
    json_table_print(tables[n].rows, tables[n].columns);

  // the object takes the rows over, and they go with it
  cJSON *object = report(request, flagged);
  for (int n = 0; n < count; n++)
    cJSON_AddItemToObject(object, tables[n].key, tables[n].rows);
  if (status >= 0 && request->json)
    json_print(object);
  else
    cJSON_Delete(object);
  return status;
}

bool experiments_progress(void *context, double fraction) {
  config_progress_update(context, "experiments", fraction);
  return true;
}
