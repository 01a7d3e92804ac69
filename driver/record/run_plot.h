/* Plots of what a run writes, drawn by gnuplot where it is installed.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_RUN_PLOT_H
#define THRUM_DRIVER_RECORD_RUN_PLOT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Runs gnuplot, or what THRUM_GNUPLOT names, on `script`, a file's name in `folder`, silent and
 * there; true when it ended well, false also where the variable is empty. */
bool gnuplot_run(const char *folder, const char *script);

/* A text of at most `most` bytes as it stands in single quotes of a script: printable, quotes
 * doubled. */
#define RUN_PLOT_TEXT 200
#define RUN_PLOT_QUOTED (2 * RUN_PLOT_TEXT + 1)
void run_plot_quote(const char *text, size_t most, char quoted[RUN_PLOT_QUOTED]);

/* A curve of so many rows has every `run_plot_every`th of them: more only slow the drawing. */
#define RUN_PLOT_POINTS 20000
static inline int64_t run_plot_every(int64_t rows) {
  return rows / RUN_PLOT_POINTS + 1;
}

/* Curves over the time, from a file with commas in the folder. */
typedef struct run_plot {
  const char *script, *png, *svg; /* names of the files in the folder; the script is removed */
  const char *title;              /* any text */
  const char *vertical;           /* label of the vertical axis, without quotes */
  const char *settings;           /* lines for gnuplot beside those of every plot */
  const char *curves;             /* what its command `plot` draws */
} run_plot;

/* Draws it as PNG, or as SVG with a gnuplot that has no PNG. Returns the name of the file made,
 * NULL when there is no gnuplot or it failed; nothing is left behind then. */
const char *run_plot_draw(const char *folder, const run_plot *plot);

#endif
