/* Tells what in a folder belongs to a run, and what is the user's own.
 *
 * A run is known by its mark, run.json or for a scene scene.json, which says that it is one. To it
 * belong the files that a run writes, by name, the frames, and the folders of the bodies that
 * scene.json lists. Everything else is the user's: nothing here removes it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_ENTRIES_H
#define THRUM_DRIVER_RECORD_RUN_ENTRIES_H

#include <stdbool.h>

#include "thrum/status.h"

/* The names a run may hold, besides frames/frame_NNNNNN.vtu. */
#define RUN_FRAMES "frames"
#define RUN_JSON "run.json"
// rows x 7: the place of a free body of a scene, see driver/record/run_placement.h
#define RUN_PLACEMENTS "places.npy"

/* The run of a scene holds these besides a folder for each body, which is as of one run. */
#define SCENE_JSON "scene.json"
#define SCENE_PROBES "probes.csv"
#define SCENE_ACCOUNT "account.csv"
#define SCENE_CONTACT "contact.csv"
// rows x links x SCENE_LINK_COLUMNS: 1 while it holds or 0, how far it is open, and its two places
#define SCENE_LINKS "links.npy"
#define SCENE_LINK_COLUMNS 8

typedef enum run_kind {
  RUN_OF_BODY, /* of one model; its mark is RUN_JSON */
  RUN_OF_SCENE /* its mark is SCENE_JSON */
} run_kind;

/* Whether the run of a scene has a file of this name, so that no body may have it. */
bool run_entries_of_scene(const char *name);

/* Whether the folder has the mark of a run of this kind, even if another program wrote it. */
bool run_entries_finished(const char *path, run_kind kind);

/* Whether the mark in the folder says that a run of this kind is there. */
bool run_entries_marked(const char *path, run_kind kind);

/* Is the folder empty? False where it cannot be read. */
bool run_entries_none(const char *path);

/* The folder is empty or holds a run of this kind, so that it may be replaced; otherwise THRUM_IO
 * with the reason. */
thrum_status run_entries_replaceable(const char *path, run_kind kind, thrum_error *error);

/* Could the run in the folder `from` be removed, and the user's entries be moved into the folder
 * `to`? THRUM_IO with the entry and the reason: an entry of the user's has the name of one in `to`,
 * or of a file of any run where `to` is NULL, or a folder cannot be written to. */
thrum_status run_entries_check(const char *from, const char *to, run_kind kind, thrum_error *error);

/* Moves the user's entries of the folder `from` into `to`, all of them or none. */
thrum_status run_entries_keep(const char *from, const char *to, run_kind kind, thrum_error *error);

/* Removes the run from the folder, its mark last, and the folder where nothing else is in it. */
thrum_status run_entries_remove(const char *path, run_kind kind, thrum_error *error);

#endif
