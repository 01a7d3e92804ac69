/* A run of a scene file: what it says as a scene, its files, and the loop over the steps.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_RUN_H
#define THRUM_DRIVER_SCENE_RUN_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

#include "driver/condensed_check.h"
#include "driver/display_surface.h"
#include "driver/run.h"
#include "driver/scene_file_models.h"
#include "thrum/scene.h"
#include "thrum/thrum.h"

/* The options of `thrum simulate SCENE.json` beside the file. */
typedef struct scene_request {
  const char *path, *output;
  double time, dt; /* 0: as the file says */
  bool json, quiet;
} scene_request;

/* One body of the file, beside its figures and files in the driver_body of the same number. */
typedef struct scene_body_run {
  const scene_body_spec *spec;
  const thrum_model *model;    /* at its rank, as it is in its file */
  condensed_check check;       /* of a condensed body */
  double error_found;          /* of the number of coordinates that "error" has found; 0: none */
  simulate_request request;    /* of a run of it alone: loads in its axes, gravity first if any */
  thrum_model shown;           /* the model scaled in stiffness and put in place, for measures */
  double *material, *vertices; /* of that, and for frames */
  char folder[RUN_PATH_MAX + 80];
  char gravity[100]; /* as a load's text */
} scene_body_run;

typedef struct scene_run {
  const scene_request *request;
  scene_spec spec;
  scene_models models;
  thrum_scene *scene;
  base_motion_spec *base_motions; /* of the spec, read */
  int64_t base_motion_count;
  scene_body_run *bodies; /* of the spec's count */
  driver_run run;         /* its bodies are of the same count */
  int64_t steps;
  double dt;
  bool failed; /* the last step was made by some bodies only */
  run_folder folder;
  FILE *probes;
  double seconds_read, seconds_output, seconds_total;
} scene_run;

/* scene_run_build.c: loads the models and makes the scene. */
thrum_status scene_run_build(scene_run *run, thrum_error *error);

/* scene_run.c: reads the file of the request, and frees what a run holds, whatever came of it. */
thrum_status scene_run_read(scene_run *run, thrum_error *error);
void scene_run_close(scene_run *run);

/* scene_run_refuse.c: a message of the engine about one key of a record, or about the record (key
 * NULL). */
thrum_status scene_run_refuse(const scene_run *run, const config_record *at, const char *key,
                              thrum_status status, const thrum_error *detail);
thrum_status scene_run_no_memory(thrum_error *error);

/* scene_run_world.c: what acts on all bodies, before they are added (base motions) and after. */
thrum_status scene_run_base_motions(scene_run *run, thrum_error *error);
thrum_status scene_run_wind(scene_run *run);
thrum_status scene_run_obstacles(scene_run *run);
thrum_status scene_run_probes(scene_run *run);

/* scene_run_detail.c: condenses the bodies that ask for an error; the scene is at its start again.
 */
thrum_status scene_run_find_detail(scene_run *run, thrum_error *error);

/* scene_run_stepper.c: the scene as a stepper, whose bodies are those of the file. */
driver_stepper scene_run_stepper(scene_run *run);

/* scene_run_output.c: the folder, the files of the bodies and the probes; and the runs of the
 * bodies completed. */
thrum_status scene_run_open(scene_run *run, thrum_error *error);
thrum_status scene_run_record_probes(scene_run *run, int64_t step, double time, thrum_error *error);
thrum_status scene_run_end(scene_run *run, thrum_error *error);

/* scene_run_report.c */
cJSON *scene_run_json(const scene_run *run);
void scene_run_table(const scene_run *run);

/* scene_run.c: a scene from its file to its folder; an exit code. */
int scene_run_request(const scene_request *request);

#endif
