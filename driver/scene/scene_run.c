/* `thrum simulate SCENE.json`: from the file to the folder.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run.h"

#include "driver/scene/scene_run_account.h"
#include "driver/scene/scene_run_build.h"
#include "driver/scene/scene_run_couple.h"
#include "driver/scene/scene_run_crossed.h"
#include "driver/scene/scene_run_idle.h"
#include "driver/scene/scene_run_judge.h"
#include "driver/scene/scene_run_link.h"
#include "driver/scene/scene_run_output.h"
#include "driver/scene/scene_run_report.h"
#include "driver/scene/scene_run_stepper.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "config/message.h"
#include "driver/scene/scene_words.h"
#include "io/file.h"
#include "io/json.h"
#include "platform/clock.h"
#include "platform/interrupt.h"
#include "platform/stop_request.h"

/* scene.json, which says that the rest is whole, and the folder put in place. */
static thrum_status report(scene_run *run, thrum_error *error) {
  char path[RUN_PATH_MAX + 80];
  run->seconds_total = clock_seconds() - run->began;
  run->seconds_output = clock_seconds() - run->run.began - run->run.seconds_step;

  // scene.json is the last file: it says that the rest is whole
  cJSON *object = scene_run_json(run);
  char *text = json_text(object);
  snprintf(path, sizeof path, "%.*s/" SCENE_JSON, RUN_PATH_MAX, run->folder.work);
  thrum_status status =
      text != NULL ? thrum_file_write_atomic(path, text, strlen(text), error)
                   : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for " SCENE_JSON);
  free(text);

  THRUM_THEN(status, run_folder_commit(&run->folder, error));

  // the object is shown where JSON was asked for, the table otherwise
  if (status >= 0 && run->request->json) {
    json_print(object);
    return status;
  }

  if (status >= 0)
    scene_run_table(run, object);
  cJSON_Delete(object);
  return status;
}

static thrum_status count_steps(scene_run *run) {
  // the command line goes before the scene file
  if (run->request->time > 0)
    run->spec.time = run->request->time;
  run->dt = run->request->dt > 0 ? run->request->dt : run->spec.settings.def.dt;
  if (simulate_step_is_longer(run->spec.time, run->dt))
    return config_record_refuse(&run->spec.file, &run->spec.settings.at, "dt", THRUM_BAD_VALUE,
                                "%g s is longer than the whole run of %g s: take a shorter step",
                                run->dt, run->spec.time);
  run->steps = simulate_step_count(run->spec.time, run->dt);

  if (run->steps > 0)
    return THRUM_OK;
  return config_record_refuse(&run->spec.file, &run->spec.settings.at, "time", THRUM_BAD_VALUE,
                              "%g s at a dt of %g s is more than %g steps", run->spec.time, run->dt,
                              SIMULATE_STEPS_MAX);
}

thrum_status scene_run_read(scene_run *run, thrum_error *error) {
  config_warn_under(NULL, scene_words);
  const thrum_status status = scene_spec_read(run->request->path, &run->spec, error);
  return status >= 0 ? count_steps(run) : status;
}

/* Writes a scene that is over and ends the program, where the judgement of its bases has not come
 * back from a long call. */
static void end_unjudged(void *context) {
  scene_run *scene = context;
  thrum_error error = {0};
  thrum_status status = scene_run_end_unjudged(scene, &error);
  THRUM_THEN(status, report(scene, &error));
  if (status >= 0)
    fputs("\nthrum: stopped; the run was written, and what its bases have wrong is not known\n",
          stderr);
  const int code = config_end(status, status >= 0 && scene_run_outcome(scene) != RUN_DONE, &error);
  fflush(stdout);
  _exit(code);
}

static thrum_status run_scene(scene_run *scene, thrum_error *error) {
  driver_run *run = &scene->run;
  const scene_request *request = scene->request;
  scene->began = clock_seconds();

  // models may be made first, and a signal ends that at once
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");
  THRUM_TRY(scene_run_read(scene, error));
  THRUM_TRY(run_folder_check(request->output, RUN_OF_SCENE, error));
  THRUM_TRY(scene_run_build(scene, error));
  run->stepper = scene_run_stepper(scene);
  scene_run_warn_of_idle(scene);

  // from here on there is something to clean up
  thrum_stop_request_catch();
  THRUM_TRY(scene_run_open(scene, error));
  scene->seconds_read = clock_seconds() - scene->began;
  scene_models_warn(&scene->spec, &scene->models);
  THRUM_TRY(driver_run_steps(run, request->quiet, error));

  // the judgement of bases is waited for no longer than steps
  if (run->status >= 0)
    thrum_stop_request_end_by(end_unjudged, scene);
  THRUM_TRY(scene_run_end(scene, error));
  THRUM_TRY(report(scene, error));
  driver_run_warn(run);
  scene_run_warn_of_depth(scene);
  scene_run_warn_of_turns(scene);
  scene_run_warn_of_joints(scene);
  return THRUM_OK;
}

void scene_run_close(scene_run *run) {
  if (run->probes != NULL)
    fclose(run->probes);
  if (run->account != NULL)
    fclose(run->account);
  if (run->contact != NULL)
    fclose(run->contact);
  if (run->links != NULL)
    fclose(run->links);

  // work folders of bodies first, then the scene's around them
  scene_run_judge_close(run);
  scene_run_unmake(run);
  run_folder_abandon(&run->folder);
  scene_models_free(&run->models);
  scene_spec_free(&run->spec);
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
  const bool flagged = status >= 0 && scene_run_outcome(run) != RUN_DONE;
  const int code = config_end(status, flagged, &error);
  scene_run_close(run);
  free(run);
  return code;
}
