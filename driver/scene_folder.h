/* The folder of a scene's run: scene.json, probes.csv and a folder as of one run for each body;
 * complete or not there at all. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_FOLDER_H
#define THRUM_DRIVER_SCENE_FOLDER_H

#include "driver/run_folder.h"

#define SCENE_JSON "scene.json"
#define SCENE_PROBES "probes.csv"

/* As run_folder_open, for an earlier run of a scene. */
thrum_status scene_folder_open(const char *path, run_folder *folder, thrum_error *error);

/* Puts the files in place: a new folder by one rename, an earlier run of a scene body by body,
 * scene.json removed first and put last, files of the user's own left alone. */
thrum_status scene_folder_commit(run_folder *folder, thrum_error *error);

/* Removes the work folder with the bodies in it; fine after commit and on a zeroed folder. */
void scene_folder_abandon(run_folder *folder);

#endif
