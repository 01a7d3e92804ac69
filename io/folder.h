/* Folders for results. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_IO_FOLDER_H
#define THRUM_IO_FOLDER_H

#include "thrum/status.h"

/* Makes a folder for results unless it exists; refuses a folder that cannot be written to. */
thrum_status folder_make(const char *path, thrum_error *error);

#endif
