/* What commands with a folder of results share. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_RESULTS_H
#define THRUM_APP_RESULTS_H

#include "thrum/status.h"
#include "validation/experiments/report.h"

/* Writes a text to `name` in the folder, and frees it. */
thrum_status cli_results_write(const char *folder, const char *name, experiment_text *text,
                               thrum_error *error);

/* Where figures are made; the texts last until the next call. */
experiment_place cli_results_place(const char *command);

#endif
