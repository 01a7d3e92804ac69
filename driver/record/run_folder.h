/* The folder of a run, RUN: complete or not there at all, and never in place of the user's other
 * files.
 *
 * A run is written into a work folder beside RUN. At the end the two exchange their places in one
 * step, so RUN is the earlier run or the new one, and whole, at any moment at which it is looked at
 * or the process is killed. What is the user's own in the earlier run's folder then moves over, and
 * the rest of the earlier run is removed. The work folder is locked, so of two processes that write
 * into one RUN the later one is refused; what a killed process left is cleared by the next run into
 * the same RUN. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_FOLDER_H
#define THRUM_DRIVER_RECORD_RUN_FOLDER_H

#include <stdbool.h>
#include <stdio.h>

#include "driver/record/run_entries.h"

#define RUN_PATH_MAX 1024

typedef struct run_folder {
  char path[RUN_PATH_MAX - 64]; /* RUN, without links where it is there */
  char work[RUN_PATH_MAX];      /* where the files are until commit; empty: nothing open */
  run_kind kind;
  bool existed; /* RUN is an empty folder or an earlier run */
  bool inside;  /* a part of the run of a scene, which is put in place as a whole */
  int lock;     /* of the work folder, unless `inside` */
} run_folder;

/* Makes the work folder. RUN may be new, an empty folder or an earlier run; anything else there is
 * refused, as is one that another process works on, or that could not be replaced in the end. */
thrum_status run_folder_open(const char *path, run_kind kind, run_folder *folder,
                             thrum_error *error);

/* Makes the folder of a body in the work folder of its scene. */
thrum_status run_folder_open_inside(const char *path, run_folder *folder, thrum_error *error);

/* The same as run_folder_open for nothing but its refusals, before work that would be lost: RUN
 * stays as it is. */
thrum_status run_folder_check(const char *path, run_kind kind, thrum_error *error);

/* Opens a new file in the work folder; NULL, and errno, when that fails. */
FILE *run_folder_create(const run_folder *folder, const char *name);

/* Flushes a file to the disk, closes it, and makes *file NULL; one that is NULL is closed already.
 * False, and errno, when anything of it was lost on the way. */
bool run_folder_close_file(FILE **file);

/* Says that a file of the run could not be written, and why: errno. */
thrum_status run_folder_write_failed(const run_folder *folder, const char *name,
                                     thrum_error *error);

/* Puts the run in place. On failure RUN is as it was, and the new run is kept beside it under the
 * name that the message gives. */
thrum_status run_folder_commit(run_folder *folder, thrum_error *error);

/* Removes the work folder; RUN is as it was. Fine after commit and on a zeroed folder. */
void run_folder_abandon(run_folder *folder);

#endif
