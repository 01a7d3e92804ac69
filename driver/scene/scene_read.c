/* Reads the folder of a finished run of a scene back. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driver/record/run_entries.h"
#include "driver/record/run_folder.h"
#include "driver/scene/scene_spec.h"
#include "io/json.h"
#include "io/npy_file.h"
#include "platform/allocate.h"

void recorded_scene_free(recorded_scene *scene) {
  for (int64_t n = 0; n < scene->count; n++)
    recorded_run_free(&scene->runs[n]);
  free(scene->runs);
  free(scene->names);
  free(scene->links);
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

/* Reads the links that scene.json lists, row by row; runs before 0.2.0 have none. */
static thrum_status read_links(const char *path, recorded_scene *scene, thrum_error *error) {
  const cJSON *listed = cJSON_GetObjectItemCaseSensitive(scene->object, "links");
  const int64_t count = cJSON_GetArraySize(listed);
  char file[RUN_PATH_MAX + 300];
  snprintf(file, sizeof file, "%.*s/%s", RUN_PATH_MAX, path, SCENE_LINKS);
  if (count == 0 || access(file, F_OK) != 0)
    return THRUM_OK;
  int64_t rows = 0, columns = 0;
  THRUM_TRY(thrum_npy_read_f8(file, &scene->links, &rows, &columns, error));

  // one row for each of the bodies', and numbers only
  bool good = rows == scene->runs[0].rows && columns == SCENE_LINK_COLUMNS * count;
  for (int64_t n = 0; good && n < rows * columns; n++)
    good = isfinite(scene->links[n]);
  if (!good)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.300s: not %d numbers for each link and row of the bodies", file,
                           SCENE_LINK_COLUMNS);
  scene->link_count = count;
  return THRUM_OK;
}

void recorded_scene_thin(recorded_scene *scene, double rate) {
  const int64_t width = SCENE_LINK_COLUMNS * scene->link_count;
  if (!(rate > 0))
    return;

  // rows of links are kept where those of the first body are
  for (int64_t n = 0, kept = 0; n < scene->runs[0].rows && width > 0; n++)
    if (recorded_run_keeps(&scene->runs[0], n, kept, rate))
      memmove(scene->links + width * kept++, scene->links + width * n,
              (size_t)width * sizeof *scene->links);
  for (int64_t n = 0; n < scene->count; n++)
    recorded_run_thin(&scene->runs[n], rate);
}

thrum_status recorded_scene_read(const char *path, recorded_scene *scene, thrum_error *error) {
  char file[RUN_PATH_MAX + 300];
  recorded_scene read = {0};
  snprintf(file, sizeof file, "%.*s/%s", RUN_PATH_MAX, path, SCENE_JSON);
  THRUM_TRY(json_file_read(file, &read.object, error));
  thrum_status status = read_bodies(path, file, &read, error);
  THRUM_THEN(status, read_links(path, &read, error));
  if (status < 0)
    recorded_scene_free(&read);
  else
    *scene = read;
  return status;
}
