/* The energy plot of a run: the energy of the body itself, without what gravity and contact hold.
 * The energy of the high modes is left out: it is a linear measure that may be many times the total
 * and would flatten the rest. SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/energy_plot.h"

#include <inttypes.h>
#include <stdio.h>

#include "driver/record/run_plot.h"

const char *energy_plot_draw(const char *folder, const char *title, int64_t rows) {
  // long series are thinned; strokes and widths tell the curves apart where colours are not
  const int64_t every = run_plot_every(rows);
  char curves[600];
  snprintf(curves, sizeof curves,
           "'energy.csv' using 2:3 every %" PRId64 "::1 with lines lc rgb '#6baed6' "
           "title 'kinetic', \\\n"
           "  '' using 2:4 every %" PRId64
           "::1 with lines dt (8,4) lc rgb '#d2600a' title 'strain', \\\n"
           "  '' using 2:5 every %" PRId64
           "::1 with lines lw 2 lc rgb '#08306b' title 'both, of the body alone'",
           every, every, every);
  return run_plot_draw(folder, &(run_plot){.script = "energy.gp",
                                           .png = "energy.png",
                                           .svg = "energy.svg",
                                           .title = title,
                                           .vertical = "energy [J]",
                                           .settings = "set format y '%.3g'\n",
                                           .curves = curves});
}
