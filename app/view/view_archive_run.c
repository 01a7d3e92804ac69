/* A finished run as an archive: its bodies where they were at the times that it recorded.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/view/view_archive.h"
#include "app/view/view_archive_list.h"
#include "config/message.h"
#include "driver/record/run_folder.h"
#include "driver/scene/scene_read.h"
#include "driver/scene/scene_run_world.h"
#include "io/json.h"
#include "platform/allocate.h"

/* Each model file once, in the order of the bodies; of_body: its place for each body. */
static void list_models(view_archive_motion motion, const char *const *names,
                        view_archive_list *list, int64_t *of_body) {
  for (int64_t n = 0; n < motion.count; n++) {
    int64_t before = 0;
    while (strcmp(motion.runs[before].model_path, motion.runs[n].model_path) != 0)
      before++;
    of_body[n] = before < n ? of_body[before] : list->count;
    if (before == n)
      view_archive_list_add(list, names[n], motion.runs[n].model);
  }
}

/* names: of the models of the bodies; called: of the bodies. */
static thrum_status pack_motion(view_archive_motion motion, const char *const *names,
                                const char *const *called, const char *surface,
                                const scene_run *obstacles, view_archive *archive,
                                thrum_error *error) {
  view_archive_list list = {0};
  int64_t *of_body = NULL;
  thrum_status status = thrum_reserve(&of_body, motion.count, sizeof *of_body, "bodies", error);
  THRUM_THEN(status, view_archive_list_make(motion.count, &list, error));
  if (status >= 0) {
    list_models(motion, names, &list, of_body);
    list.items[0].surface = surface;
    cJSON *scene = view_archive_scene_of_motion(motion, called, of_body, obstacles);
    status = view_archive_pack(list.items, list.count, scene, motion, archive, error);
  }
  free(of_body);
  view_archive_list_free(&list);
  return status;
}

/* Refuses to write over what the run in the folder was read from. */
static thrum_status spare(const char *output, const char *folder, const recorded_run *run,
                          thrum_error *error) {
  if (!recorded_run_holds(folder, run, output))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "%.200s belongs to the run or is its model: write to another file",
                         output);
}

static thrum_status pack_run(const view_run_request *request, view_archive *archive,
                             thrum_error *error) {
  recorded_run run = {0};
  THRUM_TRY(recorded_run_read(request->path, NULL, &run, error));
  recorded_run_thin(&run, request->fps);
  const view_archive_motion motion = {&run, 1, NULL, NULL};
  const char *const names[] = {run.model_path};
  thrum_status status = spare(request->output, request->path, &run, error);
  THRUM_THEN(status, pack_motion(motion, names, names, request->surface, NULL, archive, error));
  recorded_run_free(&run);
  return status;
}

/* The obstacles of the scene file that a run was made of, which the run's folder does not hold. A
 * file that is gone or has become another is named, and the run is shown without them. */
static bool read_obstacles(const char *folder, const recorded_scene *scene, scene_run *run,
                           bool quiet) {
  const cJSON *listed = cJSON_GetObjectItemCaseSensitive(scene->object, "obstacles");
  const char *path = json_text_of(scene->object, "scene");
  if (cJSON_GetArraySize(listed) == 0 || path == NULL)
    return false;

  // the scene without its bodies
  recorded_path found;
  path = recorded_run_find(folder, path, NULL, found);
  thrum_error error = {0};
  run->request = &(scene_request){.path = path, .output = "", .quiet = true};
  thrum_status status = scene_run_read(run, &error);
  run->request = NULL;
  if (status >= 0 && run->spec.obstacles.count != cJSON_GetArraySize(listed))
    status = thrum_error_set(&error, THRUM_BAD_VALUE, "%.200s: it has other obstacles now", path);
  THRUM_THEN(status, thrum_scene_create(run->spec.settings.def.dt, &run->scene, &error));
  THRUM_THEN(status, scene_run_obstacles(run, run->scene));
  if (status < 0 && !quiet)
    config_warn("the run is shown without its obstacles, which its folder does not hold: %.300s",
                error.message[0] != 0 ? error.message : path);
  return status >= 0;
}

static thrum_status pack_recorded(const char *folder, const recorded_scene *scene, bool quiet,
                                  view_archive *archive, thrum_error *error) {
  const view_archive_motion motion = {scene->runs, scene->count, scene, NULL};
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(scene->object, "bodies");
  const char **models = NULL;
  scene_run *obstacles = NULL;
  thrum_status status = thrum_reserve(&models, scene->count, sizeof *models, "bodies", error);
  THRUM_THEN(status, thrum_reserve(&obstacles, 1, sizeof *obstacles, "the scene", error));

  // models by their names in the scene file; their files may be in a cache
  for (int64_t n = 0; n < scene->count && status >= 0; n++) {
    const cJSON *body = cJSON_GetArrayItem(bodies, (int)n);
    const char *model = json_text_of(body, "model");
    models[n] = model != NULL ? model : scene->runs[n].model_path;
  }
  if (status >= 0) {
    const bool found = read_obstacles(folder, scene, obstacles, quiet);
    status =
        pack_motion(motion, models, scene->names, NULL, found ? obstacles : NULL, archive, error);
    scene_run_close(obstacles);
  }
  free(obstacles);
  free(models);
  return status;
}

thrum_status view_archive_of_run(const view_run_request *request, view_archive *archive,
                                 thrum_error *error) {
  if (is_run_folder(request->path))
    return pack_run(request, archive, error);
  recorded_scene scene = {0};
  THRUM_TRY(recorded_scene_read(request->path, &scene, error));

  // each body has a folder of its own
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < scene.count && status >= 0; n++) {
    char folder[RUN_PATH_MAX + 300];
    snprintf(folder, sizeof folder, "%.*s/%.250s", RUN_PATH_MAX, request->path, scene.names[n]);
    status = spare(request->output, folder, &scene.runs[n], error);
  }
  recorded_scene_thin(&scene, request->fps);
  THRUM_THEN(status, pack_recorded(request->path, &scene, request->quiet, archive, error));
  recorded_scene_free(&scene);
  return status;
}

thrum_status view_archive_of_curve(const view_run_request *request, view_archive *archive,
                                   thrum_error *error) {
  recorded_curve curve = {0};
  view_archive_list list = {0};
  THRUM_TRY(recorded_curve_read(request->path, &curve, error));
  thrum_status status = THRUM_OK;
  if (recorded_curve_holds(request->path, &curve, request->output))
    status = thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s belongs to the curve or is its model: write to another file",
                             request->output);
  THRUM_THEN(status, view_archive_list_make(1, &list, error));
  if (status >= 0) {
    view_archive_list_add(&list, curve.model_path, curve.model)->surface = request->surface;
    status = view_archive_pack(list.items, 1, view_archive_scene_of_models(list.items),
                               (view_archive_motion){.curve = &curve}, archive, error);
  }
  view_archive_list_free(&list);
  recorded_curve_free(&curve);
  return status;
}
