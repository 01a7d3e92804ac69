/* Progress of long work on standard error. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CONFIG_PROGRESS_H
#define THRUM_CONFIG_PROGRESS_H

#include <stdbool.h>

/* Progress of a long stage: a bar redrawn in place when standard error is a terminal, otherwise
 * one plain line when a stage starts and one when it is done; nothing when quiet. */
typedef struct config_progress {
  bool terminal;
  bool quiet;
  bool open;
  char label[64];
  double drawn; /* clock_seconds() of the last drawing */
  double began; /* clock_seconds() */
} config_progress;
config_progress config_progress_make(bool quiet);
void config_progress_update(config_progress *progress, const char *label, double fraction);
/* The same as a call of long work, whose context is the config_progress; true: go on. */
bool config_progress_show(void *context, const char *stage, double fraction);
/* Ends the stage, which says that it was done only if it was. */
void config_progress_end(config_progress *progress, bool done);

#endif
