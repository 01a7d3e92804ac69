/* Progress of long work on standard error. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_PROGRESS_H
#define THRUM_CONFIG_PROGRESS_H

#include <stdbool.h>

/* Progress of a long stage: a bar redrawn in place when standard error is a terminal, otherwise
 * one plain line when a stage starts and one when it is done; nothing when quiet. */
typedef struct cli_progress {
  bool terminal;
  bool quiet;
  bool open;
  char label[64];
  double drawn; /* clock_seconds() of the last drawing */
  double began; /* clock_seconds() */
} cli_progress;
cli_progress cli_progress_make(bool quiet);
void cli_progress_update(cli_progress *progress, const char *label, double fraction);
void cli_progress_done(cli_progress *progress);
/* Ends an unfinished stage without claiming that it was done. */
void cli_progress_abandon(cli_progress *progress);

#endif
