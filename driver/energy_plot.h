/* The energy plot of a run, drawn by gnuplot where it is installed.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_ENERGY_PLOT_H
#define THRUM_DRIVER_ENERGY_PLOT_H

#include <stdbool.h>
#include <stdint.h>

/* Runs gnuplot, or what THRUM_GNUPLOT names, on `script`, a file's name in `folder`, silent and
 * there; true when it ended well, false also where the variable is empty. */
bool gnuplot_run(const char *folder, const char *script);

/* A title in single quotes of a script: printable, quotes doubled. */
#define ENERGY_PLOT_TITLE 200
#define ENERGY_PLOT_QUOTED (2 * ENERGY_PLOT_TITLE + 1)
void energy_plot_quote(const char *title, char quoted[ENERGY_PLOT_QUOTED]);

/* Draws `folder`/energy.csv (`rows` rows of data) into `folder`/energy.png, or energy.svg with a
 * gnuplot that has no PNG. Returns the name of the file made, NULL when there is no gnuplot or it
 * failed; nothing is left behind then. */
const char *energy_plot_draw(const char *folder, const char *title, int64_t rows);

#endif
