/* The motion of a finished run of a scene, for other programs. SPDX-License-Identifier: Apache-2.0
 */
#ifndef THRUM_DRIVER_SCENE_SCENE_READ_H
#define THRUM_DRIVER_SCENE_SCENE_READ_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "driver/record/run_read.h"

/* The run that `thrum simulate` of a scene left in a folder: a run of each body. */
typedef struct recorded_scene {
  int64_t count;
  recorded_run *runs; /* count */
  const char **names; /* count, of the bodies; they live in `object` */
  int64_t link_count; /* 0 in runs without links.npy */
  double *links;      /* rows of the first body x link_count x SCENE_LINK_COLUMNS */
  cJSON *object;      /* of scene.json */
} recorded_scene;

/* Is there a scene.json in the folder? What is wrong with it is said where it is read. */
bool is_scene_folder(const char *path);

/* Reads SCENE/scene.json and the run of each body that it lists. recorded_scene_free frees. */
thrum_status recorded_scene_read(const char *path, recorded_scene *scene, thrum_error *error);

/* Keeps so many rows a second at most (recorded_run_thin), of all bodies and links. */
void recorded_scene_thin(recorded_scene *scene, double rate);
void recorded_scene_free(recorded_scene *scene);

#endif
