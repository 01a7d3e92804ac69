/* The energy plot of a run, drawn by gnuplot where it is installed.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RECORD_ENERGY_PLOT_H
#define THRUM_DRIVER_RECORD_ENERGY_PLOT_H

#include <stdint.h>

/* Draws `folder`/energy.csv (`rows` rows of data) into `folder`/energy.png, or energy.svg with a
 * gnuplot that has no PNG. Returns the name of the file made, NULL when there is no gnuplot or it
 * failed; nothing is left behind then. */
const char *energy_plot_draw(const char *folder, const char *title, int64_t rows);

#endif
