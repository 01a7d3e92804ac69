/* A run of a single model: all that can be refused first, then the loop of run.h, then the report.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/simulate_run.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "config/message.h"
#include "driver/make/named_model.h"
#include "driver/make/pull_warning.h"
#include "driver/model/locking.h"
#include "driver/model/model_cut.h"
#include "driver/run/against_mesh.h"
#include "driver/run/run.h"
#include "driver/run/simulate_report.h"
#include "driver/spec/actuate_spec.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "platform/clock.h"
#include "platform/interrupt.h"
#include "platform/stop_request.h"

/* A single model in the making. */
typedef struct single_run {
  const simulate_request *request;
  const thrum_model *model;   /* as it was read, which is shown */
  const thrum_model *stepped; /* the same, or what is left of it where the others follow */
  void *condensed_memory;     /* of the latter */
  named_model_file file;      /* of the model */
  driver_run run;
  double began;
} single_run;

static thrum_status load_model(single_run *single, model_hash *hash, thrum_error *error) {
  const simulate_request *request = single->request;
  const char *path = request->model_path;

  // the full order takes a mesh as well
  mesh_model_def def = request->mesh_def;
  def.reading.tets_for =
      mesh_model_tets_for(request->law, &request->def.plastic, request->quadrature);
  if (request->full)
    THRUM_TRY(mesh_model_load(path, &def, request->quiet, &single->model, &single->file, error));
  else
    THRUM_TRY(named_model_load(path, request->quiet, &single->model, &single->file, error));

  // a region may have a yield of its own
  const char *idle = plastic_option_without_yield(&request->def.plastic, single->model);
  if (idle != NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s wants a --yield beyond which the material flows: no region of "
                           "%.150s has one",
                           idle, path);

  // fewer coordinates are stepped while the others follow
  single->stepped = single->model;
  if (!request->full) {
    int64_t masters = 0;
    THRUM_TRY(
        model_masters_asked(single->model, request->rank, request->condense, &masters, error));
    if (masters > 0)
      THRUM_TRY(actuate_specs_no_gas(single->model, "a condensed run", error));
    if (masters > 0 && request->actuate_count > 0)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--actuate acts on coordinates that are stepped, and fewer of them "
                             "leave some that follow at rest: leave --rank and --condense out");
    if (masters > 0 && simulate_spins(request))
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--spin steps all coordinates; leave --rank out");
    THRUM_TRY(model_condense_to(single->model, masters, &single->condensed_memory, &single->stepped,
                                error));
  }
  return model_hash_make(single->file.path, single->model, hash, error);
}

/* Ends the program where a long call before the first step has not come back: no state is there to
 * be written. */
static void end_without_run(void *context) {
  single_run *single = context;
  static const char line[] = "\nthrum: stopped; nothing was written\n";
  run_folder_abandon(&single->run.bodies[0].output.folder);
  if (write(STDERR_FILENO, line, sizeof line - 1) >= 0)
    signal(SIGINT, SIG_DFL);
  kill(getpid(), SIGINT);
  _exit(COMMAND_REFUSED);
}

/* The stepper and the files; nothing is written before all of the request is accepted. */
static thrum_status prepare(single_run *single, thrum_error *error) {
  const simulate_request *request = single->request;
  driver_run *run = &single->run;
  THRUM_TRY(driver_run_open(run, 1, error));
  simulate_figures *figures = &run->bodies[0].figures;
  THRUM_TRY(load_model(single, &figures->model_hash, error));
  figures->model_file = thrum_mesh_is_named(request->model_path) ? single->file.path : NULL;
  run->name = request->model_path;
  figures->request = request;
  figures->model = single->model;
  THRUM_TRY((request->full ? driver_stepper_full : driver_stepper_reduced)(request, single->stepped,
                                                                           &run->stepper, error));

  // from here on there is something to clean up
  thrum_stop_request_catch();
  thrum_stop_request_end_by(end_without_run, single);
  return driver_run_open_body(run, 0, request->run_path, single->model, error);
}

/* Warns of options that are allowed and yet hardly meant, once nothing can be refused any more. */
static void warn_before(const single_run *single) {
  const simulate_request *request = single->request;
  if (request->load_count == 0 && request->start_count == 0 && request->base_motion_count == 0 &&
      request->actuate_count == 0 && !simulate_spins(request))
    config_warn("no --load, no --base-motion, no --start and no --spin: the body stays at rest");
  actuate_specs_warn(single->model, request->actuates, request->actuate_count, request->time,
                     request->full);
  locking_warn(path_basename(request->model_path), single->model);
  if (request->full)
    return;
  driver_stepper_reduced_warn(&single->run.stepper);
  pull_warning_print(path_basename(request->model_path), single->model, request->loads,
                     request->load_count);
}

/* What a short load gives the mesh, which the run of the model is told beside. */
static void measure_blow(single_run *single) {
  const simulate_request *request = single->request;
  if (!request->full)
    single->run.bodies[0].figures.blow =
        pull_measure_blow(single->model, request->loads, request->load_count, request->def.dt);
}

/* run.json, which holds the seconds up to its own writing, and what is printed. */
static thrum_status report(driver_run *run, double began, thrum_error *error) {
  driver_body *body = &run->bodies[0];
  simulate_figures *figures = &body->figures;
  const simulate_request *request = figures->request;
  char title[320], stepped_by[128];
  simulate_figures_stepped_by(figures, stepped_by);
  snprintf(title, sizeof title, "%.120s, stepped by %s, dt = %g s",
           path_basename(request->model_path), stepped_by, request->def.dt);

  // the plot is timed apart from the rows and frames
  const double plotting = clock_seconds();
  run_output_plot(&body->output, title);
  run_probes_plot(&body->probes, &body->output.folder, title);
  against_mesh_plot(&body->output.folder, title, &figures->against);
  const double now = clock_seconds();
  figures->seconds_step = run->seconds_step;
  figures->seconds_output = plotting - run->began - run->seconds_step;
  figures->seconds_plot = now - plotting;
  figures->seconds_total = now - began;

  cJSON *object = simulate_report_json(body);
  const thrum_status status = run_output_commit(&body->output, object, error);
  if (status >= 0 && request->json) {
    json_print(object);
    return status;
  }
  if (status >= 0)
    simulate_report_table(body, object);
  cJSON_Delete(object);
  return status;
}

/* The mesh beside a run that came to its end. What it finds over the whole run is the error of the
 * basis, and no estimate. */
static thrum_status look_at_mesh(single_run *single, thrum_error *error) {
  driver_run *run = &single->run;
  simulate_figures *figures = &run->bodies[0].figures;
  against_mesh *against = &figures->against;
  if (run->status < 0)
    return THRUM_OK;
  THRUM_TRY(against_mesh_run(single->request, single->model, single->stepped,
                             &run->bodies[0].output.folder, against, error));
  run->bodies[0].measures.basis_found = against->whole;
  if (against->whole)
    figures->basis_wrong = against_mesh_is_large(against, &single->request->basis);
  return THRUM_OK;
}

/* Writes a run that is over and ends the program, where the judgement of its basis or its mesh has
 * not come back from a long call. */
static void end_unjudged(void *context) {
  single_run *single = context;
  driver_run *run = &single->run;
  driver_body *body = &run->bodies[0];
  if (body->figures.against.asked)
    body->figures.against.ended = "stopped";
  else if (body->measures.basis.memory != NULL)
    body->measures.basis.estimate = basis_estimate_none("it was stopped");
  thrum_error error = {0};
  const thrum_status status = report(run, single->began, &error);
  if (status >= 0)
    fputs("\nthrum: stopped; the run was written, and what its basis has wrong is not known\n",
          stderr);
  const int code = config_end(status, driver_run_outcome(run) != RUN_DONE, &error);
  fflush(stdout);
  _exit(code);
}

static thrum_status simulate(single_run *single, thrum_error *error) {
  const simulate_request *request = single->request;
  driver_run *run = &single->run;
  THRUM_TRY(run_folder_check(request->run_path, RUN_OF_BODY, error));
  THRUM_TRY(prepare(single, error));
  warn_before(single);
  measure_blow(single);
  run->bodies[0].figures.seconds_read = clock_seconds() - single->began;
  THRUM_TRY(driver_run_steps(run, request->quiet, error));

  // what is made of a run is waited for no longer than its steps
  if (run->status >= 0)
    thrum_stop_request_end_by(end_unjudged, single);
  THRUM_TRY(driver_run_end(run, error));
  THRUM_TRY(look_at_mesh(single, error));
  thrum_stop_request_end_by(NULL, NULL);
  THRUM_TRY(report(run, single->began, error));
  driver_run_warn(run);
  if (run->bodies[0].measures.basis_found && run->bodies[0].figures.basis_wrong)
    config_warn(
        "%.2g %% of the displacement is wrong, beside the whole mesh: make the model with "
        "more --modes and --rank of thrum precompute, with --handles where it is pulled, or "
        "with --train on its load; --accept-error takes it as it is",
        100 * run->bodies[0].figures.against.displacement);
  return THRUM_OK;
}

int simulate_run_request(const simulate_request *request) {
  thrum_error error = {0};
  single_run single = {.request = request, .began = clock_seconds()};

  // while a model is made first
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");
  const thrum_status status = simulate(&single, &error);
  const bool flagged = status >= 0 && driver_run_outcome(&single.run) != RUN_DONE;
  const int code = config_end(status, flagged, &error);
  driver_run_close(&single.run);
  free(single.condensed_memory);
  thrum_model_destroy(single.model);
  return code;
}
