/* `thrum identify`: moduli, damping and start from a recorded motion. The fit is the driver's; here
 * it is asked for and shown. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/cmd.h"
#include "config/message.h"
#include "driver/identify/identify_report.h"
#include "driver/make/named_model.h"
#include "io/json.h"
#include "platform/allocate.h"
#include "platform/interrupt.h"
#include "thrum/thrum.h"

/* The files, and then the report, as one object on standard output or as a table. */
static thrum_status report(const identify_fit *fit, thrum_error *error) {
  cJSON *object = identify_report_object(fit);
  char *text = json_text(object);
  const thrum_status status =
      text != NULL ? identify_files_write(fit, text, error)
                   : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the report");
  free(text);
  if (status >= 0 && fit->request->json) {
    json_print(object);
    object = NULL;
  } else if (status >= 0) {
    identify_report_table(fit);
  }
  cJSON_Delete(object);
  if (status >= 0)
    identify_report_warn(fit);
  return status;
}

static int run_request(const identify_request *request) {
  thrum_error error = {0};
  const thrum_model *loaded = NULL;
  identify_fit fit = {0};
  thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
  thrum_status status =
      named_model_load(request->model_path, request->quiet, &loaded, NULL, &error);
  THRUM_THEN(status, identify_fit_open(request, loaded, &fit, &error));
  THRUM_THEN(status, identify_fit_run(&fit, &error));
  THRUM_THEN(status, report(&fit, &error));
  const bool flagged = status >= 0 && identify_flag(&fit);
  const int code = config_end(status, flagged, &error);
  identify_fit_close(&fit);
  thrum_model_destroy(loaded);
  return code;
}

int cmd_identify(int argc, char **argv) {
  identify_request request = {0};
  thrum_error error = {0};
  thrum_scope scope = thrum_scope_begin("the options", &error);
  request.starts =
      thrum_scope_allocate(&scope, argc + CONFIG_FILE_ITEMS_MAX, sizeof *request.starts);
  int code = scope.status < 0 ? config_refuse(&error) : identify_options_read(argc, argv, &request);
  if (code == COMMAND_DONE)
    code = run_request(&request);
  thrum_scope_free(&scope);
  config_file_free(&request.file);
  return code;
}
