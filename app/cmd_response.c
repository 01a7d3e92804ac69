/* `thrum response`: periodic motions of a body. The curve is the library's (thrum/response.h); here
 * it is asked for, shown and written. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/cmd.h"
#include "config/message.h"
#include "driver/make/named_model.h"
#include "driver/response/response_files.h"
#include "driver/response/response_report.h"
#include "driver/spec/actuate_spec.h"
#include "io/json.h"
#include "platform/allocate.h"
#include "platform/stop_request.h"
#include "thrum/thrum.h"

/* The files, and then the report, as one object on standard output or as a table. */
static thrum_status report(const response_curve *curve, const response_worth *worth,
                           thrum_error *error) {
  cJSON *object = response_report_object(curve, worth);
  char *text = json_text(object);
  thrum_status status =
      text != NULL ? response_files_write(curve, text, error)
                   : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the report");
  free(text);
  if (status >= 0 && curve->request->json) {
    json_print(object);
    object = NULL;
  } else if (status >= 0) {
    response_report_table(curve, worth);
  }
  cJSON_Delete(object);
  if (status >= 0)
    response_report_warn(curve, worth);
  return status;
}

static int run_request(const response_request *request) {
  thrum_error error = {0};
  const thrum_model *loaded = NULL;
  response_curve curve = {0};
  response_worth worth = {0};
  named_model_file file = {0};
  thrum_status status =
      named_model_load(request->model_path, request->quiet, &loaded, &file, &error);

  // a stopped curve keeps what was found
  thrum_stop_request_catch();
  THRUM_THEN(status, actuate_specs_no_gas(loaded, "a curve", &error));
  THRUM_THEN(status, response_curve_open(request, loaded, &curve, &error));
  THRUM_THEN(status, model_hash_make(file.path, loaded, &curve.hash, &error));
  THRUM_THEN(status, response_curve_find(&curve, &error));
  THRUM_THEN(status, response_worth_find(&curve, &worth, &error));
  THRUM_THEN(status, report(&curve, &worth, &error));
  const bool flagged = status >= 0 && response_flag(&curve, &worth);
  const int code = config_end(status, flagged, &error);
  response_curve_close(&curve);
  thrum_model_destroy(loaded);
  return code;
}

int cmd_response(int argc, char **argv) {
  response_request request = {0};
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);
  const int64_t room = argc + CONFIG_FILE_ITEMS_MAX;
  request.loads = thrum_scope_allocate(&scope, room, sizeof *request.loads);
  request.targets = thrum_scope_allocate(&scope, 2 * room, sizeof *request.targets);
  request.at = thrum_scope_allocate(&scope, 2 * room, sizeof *request.at);
  request.starts = thrum_scope_allocate(&scope, room, sizeof *request.starts);
  int code = scope.status < 0 ? config_refuse(&error) : response_options_read(argc, argv, &request);
  if (code == COMMAND_DONE)
    code = run_request(&request);
  thrum_scope_free(&scope);
  config_file_free(&request.file);
  return code;
}
