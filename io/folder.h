/* Folders for results. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_FOLDER_H
#define THRUM_IO_FOLDER_H

#include "thrum/status.h"

/* Makes a folder for results unless it exists; refuses a folder that cannot be written to. */
thrum_status folder_make(const char *path, thrum_error *error);

/* The same for the folder that a command fills; `path` must stay. A new one goes again while it is
 * empty: when a signal ends the program, and by folder_give_up, for a command that failed. */
thrum_status folder_make_output(const char *path, thrum_error *error);
void folder_give_up(const char *path);

#endif
