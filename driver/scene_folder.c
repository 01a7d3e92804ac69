/* The folder of a scene's run. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_folder.h"

#include <cjson/cJSON.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/file.h"

typedef char path_text[RUN_PATH_MAX + 300];

static void join(path_text path, const char *folder, const char *name) {
  snprintf(path, sizeof(path_text), "%.*s/%.255s", RUN_PATH_MAX, folder, name);
}

thrum_status scene_folder_open(const char *path, run_folder *folder, thrum_error *error) {
  return run_folder_open(path, SCENE_JSON, folder, error);
}

static bool unlink_in(const char *folder, const char *name) {
  path_text path;
  join(path, folder, name);
  return unlink(path) == 0 || errno == ENOENT;
}

/* One body's folder: removed, or moved to `to`, into a folder of that name where one is. */
static bool sweep_body(const char *from, const char *to) {
  if (to != NULL && rename(from, to) == 0)
    return true;
  if (to != NULL && errno != EEXIST && errno != ENOTEMPTY)
    return false;
  const bool done = run_folder_sweep(from, to);
  // it stays where it holds more than a run
  rmdir(from);
  return done;
}

/* The folders of bodies in a work folder: removed when `to` is NULL, else moved there. */
static bool sweep_bodies(const char *from, const char *to) {
  path_text old, new;
  DIR *entries = opendir(from);
  if (entries == NULL)
    return false;
  bool done = true;

  // folders that are no run are the user's
  for (const struct dirent *entry = readdir(entries); done && entry != NULL;
       entry = readdir(entries)) {
    if (entry->d_name[0] == '.')
      continue;

    join(old, from, entry->d_name);
    if (!run_folder_holds(old, RUN_JSON))
      continue;
    if (to != NULL)
      join(new, to, entry->d_name);
    done = sweep_body(old, to != NULL ? new : NULL);
  }

  closedir(entries);
  return done;
}

static bool move(const char *from, const char *to, const char *name) {
  path_text old, new;
  join(old, from, name);
  join(new, to, name);
  return rename(old, new) == 0 || errno == ENOENT;
}

/* Removes an earlier run: the bodies that its scene.json lists, which goes first. */
static bool clear(const char *path) {
  path_text file, body;
  void *text = NULL;
  size_t size = 0;
  join(file, path, SCENE_JSON);
  if (thrum_file_read(file, &text, &size, NULL) < 0)
    return true; // the folder was empty

  // scene.json goes first: without it, what is left is no complete run
  cJSON *object = cJSON_ParseWithLength(text, size);
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(object, "bodies"), *item;
  bool done = unlink_in(path, SCENE_JSON);

  // a name with a slash would lead out of the folder
  cJSON_ArrayForEach(item, bodies) {
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(item, "name"));
    if (name == NULL || strchr(name, '/') != NULL || name[0] == '.')
      continue;

    join(body, path, name);
    if (done && run_folder_holds(body, RUN_JSON))
      done = sweep_body(body, NULL);
  }

  cJSON_Delete(object);
  free(text);
  return done && unlink_in(path, SCENE_PROBES);
}

/* Files into a folder that is there. */
static bool replace(const run_folder *folder) {
  const char *path = folder->path, *work = folder->work;
  return clear(path) && sweep_bodies(work, path) && move(work, path, SCENE_PROBES) &&
         move(work, path, SCENE_JSON) && rmdir(work) == 0;
}

thrum_status scene_folder_commit(run_folder *folder, thrum_error *error) {
  const bool done = folder->existed ? replace(folder) : rename(folder->work, folder->path) == 0;
  if (!done)
    return thrum_error_set(error, THRUM_IO, "%.300s: the run could not be put there (%s)",
                           folder->path, strerror(errno));
  folder->work[0] = 0;
  return THRUM_OK;
}

void scene_folder_abandon(run_folder *folder) {
  if (folder->work[0] == 0)
    return;
  sweep_bodies(folder->work, NULL);
  unlink_in(folder->work, SCENE_PROBES);
  unlink_in(folder->work, SCENE_JSON);
  rmdir(folder->work);
  folder->work[0] = 0;
}
