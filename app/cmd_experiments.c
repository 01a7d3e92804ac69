/* `thrum experiments`: all of an experiment in this process, or its independent jobs. The
 * experiments themselves are in validation/experiments/. SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "app/cmd.h"
#include "app/experiments.h"
#include "config/message.h"
#include "io/folder.h"
#include "platform/allocate.h"
#include "platform/interrupt.h"

/* Everything in one process. */
static thrum_status run_all(const experiments_request *request, bool *flagged, thrum_error *error) {
  experiments_bodies *bodies = NULL;
  THRUM_TRY(thrum_reserve(&bodies, 1, sizeof *bodies, "the models", error));

  // a folder that cannot be used is found before hours of computing
  thrum_status status = folder_make(request->output, error);
  for (int64_t n = 0; n < request->model_count && status >= 0; n++)
    status = experiments_body_load(request, n, bodies, error);
  bodies->count = request->model_count;
  THRUM_THEN(status, experiments_run(request, bodies, flagged, error));
  experiments_bodies_free(bodies);
  return status;
}

int cmd_experiments(int argc, char **argv) {
  experiments_request request = {0};
  thrum_error error = {0};
  bool flagged = false;
  int code = experiments_options_read(argc, argv, &request);
  if (code == COMMAND_DONE) {
    experiments_kind_fill(&request);
    thrum_interrupt_clean("\nthrum: stopped; the folder holds whole files only\n");
    const thrum_status status = job_request_given(&request.jobs)
                                    ? experiments_jobs(&request, argv, &flagged, &error)
                                    : run_all(&request, &flagged, &error);
    code = config_end(status, flagged, &error);
  }
  free(request.list);
  return code;
}
