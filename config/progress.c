/* Progress of long stages on standard error.
 *
 * On a terminal a bar is redrawn in place, at most ten times a second; into a file or pipe go
 * two plain lines a stage. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "config/progress.h"

#include "platform/clock.h"

#define BAR_CELLS 30
#define REDRAW_SECONDS 0.1

config_progress config_progress_make(bool quiet) {
  config_progress progress = {.quiet = quiet};
  const char *terminal = getenv("TERM");
  progress.terminal = isatty(STDERR_FILENO) && terminal != NULL && strcmp(terminal, "dumb") != 0;
  return progress;
}

static void draw_bar(const config_progress *progress, double fraction) {
  char cells[BAR_CELLS + 1];
  const int filled = (int)(fraction * BAR_CELLS + 0.5);
  memset(cells, '.', BAR_CELLS);
  memset(cells, '#', (size_t)filled);
  cells[BAR_CELLS] = 0;
  fprintf(stderr, "\r%-27s [%s] %3d %% %8.1f s", progress->label, cells,
          (int)(100.0 * fraction + 0.5), clock_seconds() - progress->began);
  fflush(stderr);
}

void config_progress_update(config_progress *progress, const char *label, double fraction) {
  if (progress->quiet)
    return;

  // a fraction that is no number, or out of range, still draws a bar
  if (!(fraction >= 0))
    fraction = 0;
  if (fraction > 1)
    fraction = 1;

  // a new stage ends the line of the last one
  const bool fresh = !progress->open || strncmp(progress->label, label, 63) != 0;
  if (fresh) {
    config_progress_end(progress, true);
    snprintf(progress->label, sizeof progress->label, "%s", label);
    progress->open = true;
    progress->began = clock_seconds();
    if (!progress->terminal)
      fprintf(stderr, "%s ...\n", label);
  }

  // a bar is drawn again only so often that a person can follow it
  if (progress->terminal && (fresh || clock_seconds() - progress->drawn >= REDRAW_SECONDS)) {
    progress->drawn = clock_seconds();
    draw_bar(progress, fraction);
  }
}

bool config_progress_show(void *context, const char *stage, double fraction) {
  config_progress_update(context, stage, fraction);
  return true;
}

void config_progress_end(config_progress *progress, bool done) {
  if (progress->quiet || !progress->open)
    return;
  if (progress->terminal) {
    if (done)
      draw_bar(progress, 1);
    fputc('\n', stderr);
  } else if (done) {
    fprintf(stderr, "%s: %.2f s\n", progress->label, clock_seconds() - progress->began);
  }
  progress->open = false;
}
