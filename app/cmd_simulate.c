/* `thrum simulate`: steps a model file and writes what happened. The mathematics is the runtime's;
 * here it is asked for, timed, shown and written. SPDX-License-Identifier: Apache-2.0 */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/commands.h"
#include "config/message.h"
#include "config/progress.h"
#include "driver/model_truncate_to.h"
#include "driver/named_model.h"
#include "driver/scene_run.h"
#include "driver/simulate_full.h"
#include "driver/simulate_run.h"
#include "io/file_hash.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/clock.h"
#include "platform/interrupt.h"
#include "thrum/thrum.h"

static thrum_status allocate(simulation *run, thrum_error *error) {
  const size_t rank = (size_t)run->model->rank, loads = (size_t)run->request->load_count;
  run->memory = calloc((7 + loads) * rank, sizeof *run->memory);
  run->courses = calloc(loads + 1, sizeof *run->courses);
  if (run->memory == NULL || run->courses == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a run of this model");
  run->q = run->memory;
  run->p = run->q + rank;
  run->force = run->p + rank;
  run->extents = run->force + rank;
  run->inertia = run->extents + rank;
  run->before = run->inertia + rank;
  run->after = run->before + rank;
  run->directions = run->after + rank;
  return THRUM_OK;
}

static thrum_status reduce_loads(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  for (int64_t n = 0; n < request->load_count; n++) {
    const cli_load *load = &request->loads[n];
    const thrum_status status =
        cli_load_reduce(run->model, load, run->directions + n * run->model->rank, error);
    if (status < 0)
      return status;
    run->courses[n] = load->course;
  }
  return THRUM_OK;
}

/* A free body has no coordinates for what moves it as a whole. */
static void warn_free(const simulation *run) {
  const simulate_request *request = run->request;
  double sum[3] = {0, 0, 0}, largest = 0;
  for (int64_t n = 0; n < request->load_count; n++) {
    const cli_load *load = &request->loads[n];
    if (load->gravity)
      config_warn("--load '%s' moves nothing: nothing holds the body, so it falls without a strain",
                  load->text);
    for (int axis = 0; axis < 3 && !load->gravity && !load->traction; axis++) {
      sum[axis] += load->vector[axis];
      largest = fmax(largest, fabs(load->vector[axis]));
    }
  }
  // a pair that pulls the body apart has no resultant
  if (fabs(sum[0]) + fabs(sum[1]) + fabs(sum[2]) > 1e-9 * largest)
    config_warn(
        "nothing holds the body: the resultant of the loads (%g, %g, %g N at full strength), "
        "which would move it as a whole, has no effect; the rest deforms it",
        sum[0], sum[1], sum[2]);
}

/* What is allowed and yet hardly meant; said when nothing can be refused any more. */
static void warn_before(const simulation *run) {
  const simulate_request *request = run->request;
  const int64_t rank = run->model->rank;
  if (request->load_count == 0 && request->start_count == 0 && request->base_motion_count == 0)
    config_warn("no --load, no --base-motion and no --start: the body stays at rest");
  // what follows is said of the basis
  if (run->full != NULL)
    return;
  if (request->base_motion_count > 0 && run->model->rigid != NULL)
    config_warn(
        "--base-motion moves nothing: nothing holds the body, so its supports cannot move it");
  if (run->model->rigid != NULL)
    warn_free(run);
  for (int64_t n = 0; n < request->load_count; n++) {
    bool idle = true;
    for (int64_t i = 0; i < rank; i++)
      idle = idle && run->directions[n * rank + i] == 0;
    if (idle)
      config_warn("--load '%s' moves nothing: it is zero, or all of its vertices are held",
                  request->loads[n].text);
  }
  // an explicit mode beyond the bound of Stoermer-Verlet grows from the first step on (design 4)
  const int32_t count = thrum_state_report_get(run->state).explicit_modes;
  const double dt = request->def.dt;
  if (count > 0 && dt * sqrt(run->model->omega2[count - 1]) >= 2) {
    config_warn("explicit mode %d is beyond the stability bound: dt omega = %.3g, not below 2",
                (int)count, dt * sqrt(run->model->omega2[count - 1]));
  }
}

/* Reads the motions of the base, and says when they cannot act on this model. */
static thrum_status read_base_motions(simulation *run, thrum_error *error) {
  static const double still[3] = {0};
  const simulate_request *request = run->request;
  for (int64_t n = 0; n < request->base_motion_count; n++) {
    thrum_error detail = {0};
    thrum_status status = cli_base_motion_read(&request->base_motions[n], error);
    if (status < 0)
      return status;
    status = thrum_base_motion_load(run->model, still, run->inertia, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--base-motion '%.100s': %s",
                             request->base_motions[n].text, detail.message);
  }
  return THRUM_OK;
}

static thrum_status make_state(simulation *run, thrum_error *error) {
  const thrum_state_def *def = &run->request->def;
  thrum_error detail = {0};
  if (def->split_rule == THRUM_SPLIT_COUNT && def->explicit_count > run->model->rank) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--split %d: the model has only %lld modes", (int)def->explicit_count,
                           (long long)run->model->rank);
  }
  thrum_status status = thrum_state_create(run->model, def, &run->state, error);
  if (status < 0)
    return status;
  status = thrum_state_set(run->model, run->state, run->q, run->p, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "%s: %s",
                           run->request->start_count > 0 ? "--start" : "--dt", detail.message);
  return THRUM_OK;
}

static thrum_status finish_output(simulation *run, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const simulate_request *request = run->request;
  char title[256];
  snprintf(title, sizeof title, "%.120s: %s, dt = %g s", path_basename(request->model_path),
           thrum_integrator_name(request->def.integrator), request->def.dt);
  thrum_status status = THRUM_OK;
  if (run->full != NULL)
    simulate_full_get(run);
  else
    status = thrum_state_get(run->model, run->state, run->q, run->p, error);
  // a run that left the range of finite numbers may have no end to continue from
  const bool whole = status >= 0;
  if (whole || status == THRUM_NOT_FINITE)
    status = cli_run_output_end(&run->output, whole ? run->q : NULL, run->p, error);
  const double plotting = clock_seconds();
  figures->seconds_output = plotting - run->began - figures->seconds_step;
  if (status >= 0)
    cli_run_output_plot(&run->output, title);
  return status;
}

/* run.json holds the seconds up to its own writing. */
static thrum_status report(simulation *run, double began, thrum_error *error) {
  simulate_figures *figures = &run->figures;
  const double now = clock_seconds();
  figures->seconds_total = now - began;
  figures->seconds_plot = now - run->began - figures->seconds_step - figures->seconds_output;
  cJSON *object = simulate_report_json(figures, &run->output, &run->measures);
  const thrum_status status = cli_run_output_commit(&run->output, object, error);
  if (status < 0 || !run->request->json) {
    cJSON_Delete(object);
    if (status >= 0)
      simulate_report_table(figures, &run->output, &run->measures);
    return status;
  }
  json_print(object);
  return status;
}

static void warn_flags(const simulate_figures *figures) {
  if (figures->stop.message[0] != 0)
    config_warn("%s", figures->stop.message);
  if (figures->fallback_steps > 0)
    config_warn("%" PRId64 " steps needed a fallback beyond quasi-Newton", figures->fallback_steps);
  if (figures->energy_grew)
    config_warn("the energy grew by %.3g %% without a load", 100 * figures->drift);
}

/* All that can be refused, before anything is written. */
static thrum_status prepare(simulation *run, thrum_error *error) {
  const simulate_request *request = run->request;
  thrum_status status = allocate(run, error);
  if (status >= 0)
    status = reduce_loads(run, error);
  if (status >= 0)
    status = read_base_motions(run, error);
  if (status >= 0 && request->full) {
    status = simulate_full_open(run, error);
  } else if (status >= 0) {
    status =
        cli_starts_make(run->model, request->starts, request->start_count, run->q, run->p, error);
    if (status >= 0)
      status = make_state(run, error);
  }
  if (status >= 0 && run->model->basis != NULL)
    status = thrum_basis_extents(run->model, run->extents, error);
  if (status >= 0)
    status = simulate_measures_open(request, run->model, &run->measures, error);
  run->figures.peak = run->model->basis != NULL ? 0 : NAN;
  run->figures.peak_vertex = -1;
  const bool frames = request->frames_rate > 0 || request->frames_every > 0;
  // from here on there is something to clean up
  simulate_watch_signals();
  if (status >= 0)
    status = cli_run_output_open(request->run_path, run->model, frames, &run->output, error);
  return status;
}

static thrum_status simulate(simulation *run, double began, thrum_error *error) {
  thrum_status status = prepare(run, error);
  if (status < 0)
    return status;
  warn_before(run);
  run->began = clock_seconds();
  run->figures.seconds_read = run->began - began;
  run->progress = config_progress_make(run->request->quiet);
  simulate_figures_begin(&run->figures);
  status = simulate_run_steps(run, error);
  if (status < 0) {
    config_progress_abandon(&run->progress);
    return status;
  }
  simulate_note_end(run);
  if (run->figures.report.steps == run->request->steps) {
    config_progress_done(&run->progress);
  } else {
    config_progress_abandon(&run->progress);
  }
  status = finish_output(run, error);
  if (status >= 0)
    status = report(run, began, error);
  if (status >= 0)
    warn_flags(&run->figures);
  if (status >= 0)
    simulate_measures_warn(&run->measures);
  return status;
}

static int run_request(const simulate_request *request) {
  const double began = clock_seconds();
  thrum_error error = {0};
  simulation *run = calloc(1, sizeof *run);
  if (run == NULL) {
    error.status = THRUM_OUT_OF_MEMORY;
    return config_refuse(&error);
  }
  run->request = request;
  cli_model_file file;
  // while a model is made first
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");
  thrum_status status = cli_run_folder_check(request->run_path, CLI_RUN_JSON, &error);
  if (status >= 0)
    status = request->full
                 ? cli_mesh_model_load(request->model_path, &request->mesh_def, request->quiet,
                                       &run->loaded, &file, &error)
                 : cli_model_load(request->model_path, request->quiet, &run->loaded, &file, &error);
  if (status >= 0)
    status = model_truncate_to(run->loaded, request->rank, &run->lower_memory, &run->model, &error);
  if (status >= 0)
    status = file_hash(file.path, &run->figures.model_hash, &error);
  run->figures.request = request;
  run->figures.model = run->model;
  if (status >= 0)
    status = simulate(run, began, &error);
  int code = status < 0 ? config_refuse(&error) : COMMAND_DONE;
  if (status >= 0 && (run->figures.status != THRUM_OK || run->figures.energy_grew))
    code = COMMAND_FLAGGED;
  cli_run_output_close(&run->output);
  simulate_measures_close(&run->measures);
  simulate_full_close(run);
  free(run->memory);
  free(run->courses);
  thrum_state_destroy(run->state);
  free(run->lower_memory);
  thrum_model_free(run->loaded);
  free(run);
  return code;
}

int cmd_simulate(int argc, char **argv) {
  simulate_request request = {0};
  // no more loads and starts than arguments, and items of an options file
  request.loads = calloc((size_t)argc + CONFIG_FILE_ITEMS_MAX, sizeof *request.loads);
  request.starts = calloc((size_t)argc + CONFIG_FILE_ITEMS_MAX, sizeof *request.starts);
  request.base_motions = calloc((size_t)argc + CONFIG_FILE_ITEMS_MAX, sizeof *request.base_motions);
  int code = COMMAND_DONE;
  if (request.loads == NULL || request.starts == NULL || request.base_motions == NULL) {
    const thrum_error error = {THRUM_OUT_OF_MEMORY, ""};
    code = config_refuse(&error);
  } else {
    code = simulate_options_read(argc, argv, &request);
    if (code == COMMAND_DONE)
      code = cli_scene_is_named(request.model_path) ? scene_run_command(argc, argv)
                                                    : run_request(&request);
  }
  free(request.loads);
  free(request.starts);
  for (int64_t n = 0; n < request.base_motion_count; n++)
    cli_base_motion_close(&request.base_motions[n]);
  free(request.base_motions);
  config_options_file_free(&request.file);
  return code;
}
