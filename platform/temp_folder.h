/* A temporary folder in which other programs work for a command, removed whatever happens: while it
 * is open, SIGINT, SIGTERM and SIGHUP wait, and one that comes ends the program that runs, removes
 * the folder and then ends this one. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_TEMP_FOLDER_H
#define THRUM_PLATFORM_TEMP_FOLDER_H

#include <signal.h>

#include "thrum/status.h"

#define TEMP_FOLDER_PATH_MAX 1024

typedef struct temp_folder {
  char folder[TEMP_FOLDER_PATH_MAX];
  sigset_t before, held;
  int stopped; /* the signal that came; 0: none */
} temp_folder;

/* Makes the folder, in TMPDIR or /tmp. */
thrum_status temp_folder_open(temp_folder *temp, thrum_error *error);

/* Composes the path of a file in the folder. */
void temp_folder_path(const temp_folder *temp, const char *name, char path[TEMP_FOLDER_PATH_MAX]);

/* The way a program ended. */
typedef struct temp_folder_end {
  int code;   /* exit code; -1 where a signal ended it */
  int signal; /* the signal that ended it; 0: none */
} temp_folder_end;

/* Runs argv[0], found in PATH, without a shell and without input, and waits; what it prints goes to
 * the file `log` of the folder. Fails when it cannot be started, or when a signal stops this
 * program. */
thrum_status temp_folder_run(temp_folder *temp, char *const *argv, const char *log,
                             temp_folder_end *end, thrum_error *error);

/* Removes the folder and all files in it. Does not come back when a signal came meanwhile. */
void temp_folder_close(temp_folder *temp);

#endif
