/* The RUN folder: complete or not there at all, and never in place of the user's other files.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RUN_FOLDER_H
#define THRUM_DRIVER_RUN_FOLDER_H

#include <stdbool.h>

#include "thrum/status.h"

#define RUN_PATH_MAX 1024

/* The names a run may hold, besides frames/frame_NNNNNN.vtu. */
#define RUN_FRAMES "frames"
#define RUN_JSON "run.json"
// rows x 7: the place of a free body of a scene, see driver/run_placement.h
#define RUN_PLACEMENTS "places.npy"

typedef struct run_folder {
  char path[RUN_PATH_MAX - 64]; /* RUN */
  char work[RUN_PATH_MAX];      /* where the files are until commit; empty: nothing open */
  bool existed;                 /* RUN is an empty folder or an earlier run */
} run_folder;

/* Does the file `mark` in the folder say that a run of ours is there? */
bool run_folder_holds(const char *path, const char *mark);

/* The files of a run in the folder `from`: removed when `to` is NULL, run.json first; else moved
 * there, run.json last. Files of the user's own are left alone. */
bool run_folder_sweep(const char *from, const char *to);

/* Makes the work folder: beside RUN when RUN is new, inside it when it is an empty folder or an
 * earlier run, which is known by the file `mark`. Anything else at RUN is refused. */
thrum_status run_folder_open(const char *path, const char *mark, run_folder *folder,
                             thrum_error *error);

/* The same for nothing but its refusals, before work that would be lost: RUN stays as it is. */
thrum_status run_folder_check(const char *path, const char *mark, thrum_error *error);

/* Puts the files in place: a new RUN by one rename, an earlier run file by file, run.json removed
 * first and put last, files of the user's own left alone. */
thrum_status run_folder_commit(run_folder *folder, thrum_error *error);

/* Removes the work folder; RUN is as it was. Fine after commit and on a zeroed folder. */
void run_folder_abandon(run_folder *folder);

#endif
