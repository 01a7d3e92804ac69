/* Reads the folder of a finished run of a scene back. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_read.h"

#include <stdio.h>
#include <stdlib.h>

#include "driver/run_entries.h"
#include "driver/run_folder.h"
#include "driver/scene_spec.h"
#include "io/json.h"
#include "platform/allocate.h"

void recorded_scene_free(recorded_scene *scene) {
  for (int64_t n = 0; n < scene->count; n++)
    recorded_run_free(&scene->runs[n]);
  free(scene->runs);
  free(scene->names);
  cJSON_Delete(scene->object);
  *scene = (recorded_scene){0};
}

bool is_scene_folder(const char *path) {
  return run_entries_finished(path, RUN_OF_SCENE);
}

/* Names and runs of the bodies that scene.json lists. */
static thrum_status read_bodies(const char *path, const char *file, recorded_scene *scene,
                                thrum_error *error) {
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(scene->object, "bodies");
  const int count = cJSON_GetArraySize(bodies);
  if (count < 1)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: it lists no bodies; is it the scene.json of a run?", file);
  THRUM_TRY(thrum_reserve(&scene->runs, count, sizeof *scene->runs, file, error));
  THRUM_TRY(thrum_reserve(&scene->names, count, sizeof *scene->names, file, error));

  for (int n = 0; n < count; n++) {
    const cJSON *body = cJSON_GetArrayItem(bodies, n);
    const char *name = json_text_of(body, "name");
    if (name == NULL)
      return thrum_error_set(error, THRUM_BAD_FORMAT, "%.300s: body %d has no name", file, n + 1);

    // a run from elsewhere must not have any other folder read
    if (!scene_spec_is_name(name))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.300s: the name of body %d is none of a folder in the run: it may "
                             "have letters, digits, '-', '_' and '.'",
                             file, n + 1);

    // each body has a folder of its own, as of a run of it alone
    char folder[RUN_PATH_MAX + 300];
    snprintf(folder, sizeof folder, "%s/%.250s", path, name);
    THRUM_TRY(recorded_run_read(folder, NULL, &scene->runs[n], error));
    scene->names[n] = name;
    scene->count = n + 1;
  }
  return THRUM_OK;
}

thrum_status recorded_scene_read(const char *path, recorded_scene *scene, thrum_error *error) {
  char file[RUN_PATH_MAX + 300];
  recorded_scene read = {0};
  snprintf(file, sizeof file, "%.*s/%s", RUN_PATH_MAX, path, SCENE_JSON);
  THRUM_TRY(json_file_read(file, &read.object, error));
  const thrum_status status = read_bodies(path, file, &read, error);
  if (status < 0)
    recorded_scene_free(&read);
  else
    *scene = read;
  return status;
}
