/* `thrum simulate SCENE.json`: from the file to the folder.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_run.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/progress.h"
#include "driver/simulate_run.h"
#include "io/file.h"
#include "io/json.h"
#include "platform/clock.h"
#include "platform/interrupt.h"

/* Steps up to `target`, or until a body fails or somebody asks to stop. */
static void advance(scene_run *run, int64_t target) {
  const double began = clock_seconds();
  while (thrum_scene_steps(run->scene) < target && !simulate_stop_requested()) {
    const thrum_status status = thrum_scene_step(run->scene, &run->stop);
    if (status < 0) {
      run->status = status;
      run->failed = true;
      break;
    }
  }
  run->seconds_step += clock_seconds() - began;
}

/* The step at which something is due next. */
static int64_t next_stop(const scene_run *run, int64_t step, int64_t frame_step) {
  const int64_t every = run->spec.outputs.record_every;
  int64_t target = (step / every + 1) * every;
  if (frame_step < target)
    target = frame_step;
  // between two looks at the clock
  if (step + SIMULATE_BATCH_STEPS < target)
    target = step + SIMULATE_BATCH_STEPS;
  return target < run->steps ? target : run->steps;
}

static thrum_status write_due(scene_run *run, int64_t step, int64_t *frame_step,
                              thrum_error *error) {
  const simulate_request *request = &run->bodies[0].request;
  thrum_status status = THRUM_OK;
  // the counts move on, so a step that could not be left is not written twice
  if (step == run->rows * request->record_every)
    status = scene_run_record(run, step, true, error);
  if (status < 0 || run->status < 0 || step != *frame_step)
    return status;
  status = scene_run_frame(run, step, error);
  *frame_step = simulate_frame_step(request, run->frames);
  return status;
}

/* A failed step is not counted by the bodies that failed, so nothing is written after it. */
static thrum_status step_all(scene_run *run, thrum_error *error) {
  const scene_outputs_spec *outputs = &run->spec.outputs;
  const bool frames = outputs->frames_rate > 0 || outputs->frames_every > 0;
  int64_t frame_step = frames ? 0 : INT64_MAX, step = 0;
  thrum_status status = write_due(run, 0, &frame_step, error);
  while (status >= 0 && step < run->steps && run->status >= 0 && !simulate_stop_requested()) {
    advance(run, next_stop(run, step, frame_step));
    step = thrum_scene_steps(run->scene);
    if (run->status >= 0)
      status = write_due(run, step, &frame_step, error);
    if (clock_seconds() - run->began > SIMULATE_PROGRESS_AFTER) {
      config_progress_update(&run->progress, "simulate", (double)step / (double)run->steps);
      run->progress.began = run->began;
    }
  }
  if (status >= 0 && run->status >= 0 && step % outputs->record_every != 0)
    status = scene_run_record(run, step, false, error);
  return status;
}

/* Says why a run ended before its time. */
static void note_end(scene_run *run) {
  const int64_t steps = scene_run_steps(run);
  const double time = (double)steps * run->dt;
  const char *path = run->request->path;
  if (run->status < 0) {
    const thrum_error detail = run->stop;
    thrum_error_set(&run->stop, run->status, "%.100s: stopped at %g s, step %" PRId64 ": %s", path,
                    time, steps, detail.message);
    return;
  }
  // the texts of fallbacks are no reason to have stopped
  run->stop.message[0] = 0;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    thrum_scene_body_info info;
    thrum_scene_body(run->scene, n, &info, NULL);
    if (info.fallback_steps > 0)
      run->status = THRUM_FELL_BACK;
  }
  if (steps < run->steps) {
    run->status = THRUM_INTERRUPTED;
    thrum_error_set(&run->stop, THRUM_INTERRUPTED, "%.100s: interrupted at %g s, step %" PRId64,
                    path, time, steps);
  }
}

/* scene.json, which says that the rest is whole, and the folder put in place. */
static thrum_status report(scene_run *run, double began, thrum_error *error) {
  char path[CLI_PATH_MAX + 80];
  run->seconds_total = clock_seconds() - began;
  run->seconds_output = clock_seconds() - run->began - run->seconds_step;
  cJSON *object = scene_run_json(run);
  char *text = json_text(object);
  snprintf(path, sizeof path, "%.*s/" CLI_SCENE_JSON, CLI_PATH_MAX, run->folder.work);
  thrum_status status =
      text != NULL ? thrum_file_write_atomic(path, text, strlen(text), error)
                   : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for " CLI_SCENE_JSON);
  free(text);
  if (status >= 0)
    status = cli_scene_folder_commit(&run->folder, error);
  if (status >= 0 && run->request->json) {
    json_print(object);
    return status;
  }
  cJSON_Delete(object);
  if (status >= 0)
    scene_run_table(run);
  return status;
}

static void warn(const scene_run *run) {
  if (run->stop.message[0] != 0)
    config_warn("%s", run->stop.message);
  for (int64_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = &run->bodies[n];
    if (body->figures.fallback_steps > 0)
      config_warn("body '%s': %" PRId64 " steps needed a fallback beyond quasi-Newton",
                  body->spec->name, body->figures.fallback_steps);
    if (body->figures.energy_grew)
      config_warn("body '%s': the energy grew by %.3g %% without a load", body->spec->name,
                  100 * body->figures.drift);
    simulate_measures_warn(&body->measures);
  }
}

static thrum_status count_steps(scene_run *run) {
  if (run->request->time > 0)
    run->spec.time = run->request->time;
  run->dt = run->request->dt > 0 ? run->request->dt : run->spec.settings.def.dt;
  run->steps = simulate_step_count(run->spec.time, run->dt);
  if (run->steps > 0)
    return THRUM_OK;
  return config_record_refuse(&run->spec.file, &run->spec.settings.at, "time", THRUM_BAD_VALUE,
                              "%g s at a dt of %g s is more than %g steps", run->spec.time, run->dt,
                              SIMULATE_STEPS_MAX);
}

thrum_status scene_run_read(scene_run *run, thrum_error *error) {
  const thrum_status status = cli_scene_read(run->request->path, &run->spec, error);
  return status >= 0 ? count_steps(run) : status;
}

static thrum_status run_scene(scene_run *run, thrum_error *error) {
  const double began = clock_seconds();
  // while models are made first
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");
  thrum_status status = scene_run_read(run, error);
  if (status >= 0)
    status = cli_run_folder_check(run->request->output, CLI_SCENE_JSON, error);
  if (status >= 0)
    status = scene_run_build(run, error);
  // from here on there is something to clean up
  simulate_watch_signals();
  if (status >= 0)
    status = scene_run_open(run, error);
  if (status < 0)
    return status;
  run->began = clock_seconds();
  run->seconds_read = run->began - began;
  run->progress = config_progress_make(run->request->quiet);
  status = step_all(run, error);
  if (status >= 0 && thrum_scene_steps(run->scene) == run->steps && run->status >= 0)
    config_progress_done(&run->progress);
  else
    config_progress_abandon(&run->progress);
  if (status >= 0)
    note_end(run);
  if (status >= 0)
    status = scene_run_end(run, error);
  if (status >= 0)
    status = report(run, began, error);
  if (status >= 0)
    warn(run);
  return status;
}

void scene_run_close(scene_run *run) {
  if (run->probes != NULL)
    fclose(run->probes);
  for (int64_t n = 0; run->bodies != NULL && n < run->spec.bodies.count; n++) {
    scene_body_run *body = &run->bodies[n];
    cli_run_output_close(&body->output);
    simulate_measures_close(&body->measures);
    free(body->request.loads);
    free(body->request.starts);
    free(body->material);
    free(body->vertices);
    free(body->q);
  }
  cli_scene_folder_abandon(&run->folder);
  thrum_scene_free(run->scene);
  cli_scene_models_free(&run->models);
  for (int64_t n = 0; n < run->base_motion_count; n++)
    cli_base_motion_close(&run->base_motions[n]);
  free(run->base_motions);
  free(run->bodies);
  cli_scene_free(&run->spec);
}

int scene_run_request(const scene_request *request) {
  thrum_error error = {0};
  scene_run *run = calloc(1, sizeof *run);
  if (run == NULL) {
    error.status = THRUM_OUT_OF_MEMORY;
    return config_refuse(&error);
  }
  run->request = request;
  const thrum_status status = run_scene(run, &error);
  int code = status < 0 ? config_refuse(&error) : COMMAND_DONE;
  if (status >= 0 && strcmp(scene_run_status(run), "done") != 0)
    code = COMMAND_FLAGGED;
  scene_run_close(run);
  free(run);
  return code;
}
