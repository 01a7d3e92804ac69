/* The energy plot of a run, drawn by gnuplot where it is installed: the energy of the body itself,
 * without what gravity and contact hold. The energy of the high modes is left out: it is a linear
 * measure that may be many times the total and would flatten the rest.
 *
 * gnuplot runs inside the folder on fixed names, so that no path of the user's is ever quoted in
 * its script; only the title is, in single quotes, where a quote is written twice.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/energy_plot.h"

#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/program.h"

#define SCRIPT_NAME "energy.gp"
#define POINTS_MAX 20000 /* of one curve; more only slow the drawing */

void energy_plot_quote(const char *title, char quoted[ENERGY_PLOT_QUOTED]) {
  size_t used = 0;
  for (size_t n = 0; n < ENERGY_PLOT_TITLE && title[n] != 0; n++) {
    const unsigned char byte = (unsigned char)title[n];
    if (byte < ' ' || byte == 127)
      continue;
    if (byte == '\'')
      quoted[used++] = '\'';
    quoted[used++] = (char)byte;
  }
  quoted[used] = 0;
}

static bool write_script(const char *path, const char *terminal, const char *output,
                         const char *title, int64_t rows) {
  char quoted[ENERGY_PLOT_QUOTED];
  energy_plot_quote(title, quoted);
  FILE *file = fopen(path, "w");
  if (file == NULL)
    return false;

  // axes and colours, the same for every run; a key in the margin covers no curve
  fprintf(file,
          "set encoding utf8\n"
          "set terminal %s\n"
          "set output '%s'\n"
          "set datafile separator ','\n"
          "set title '%s' noenhanced offset 0,1.4\n"
          "set xlabel 'time [s]'\n"
          "set ylabel 'energy [J]'\n"
          "set format y '%%.3g'\n"
          "set autoscale xfix\n"
          "set grid lc rgb '#dddddd' lt 1\n"
          "set border lc rgb '#555555'\n"
          "set tmargin 5\n"
          "set rmargin 4\n"
          "set key at graph 0.5, graph 1.05 center horizontal samplen 3\n",
          terminal, output, quoted);

  // long series are thinned: more points only slow the drawing; strokes and widths tell the curves
  // apart where colours are not
  const int64_t every = rows / POINTS_MAX + 1;
  fprintf(file,
          "plot 'energy.csv' using 2:3 every %" PRId64 "::1 with lines lc rgb '#6baed6' "
          "title 'kinetic', \\\n"
          "  '' using 2:4 every %" PRId64
          "::1 with lines dt (8,4) lc rgb '#d2600a' title 'strain', \\\n"
          "  '' using 2:5 every %" PRId64
          "::1 with lines lw 2 lc rgb '#08306b' title 'both, of the body alone'\n",
          every, every, every);

  // a full disk shows when the file is closed
  const bool failed = ferror(file) != 0;
  return fclose(file) == 0 && !failed;
}

bool gnuplot_run(const char *folder, const char *script) {
  const char *named = getenv("THRUM_GNUPLOT");
  if (named != NULL && named[0] == 0)
    return false;
  char *const argv[] = {(char *)(uintptr_t)(named != NULL ? named : "gnuplot"), "-d",
                        (char *)(uintptr_t)script, NULL};
  return program_run(argv, &(program_place){.folder = folder});
}

static bool draw(const char *folder, const char *terminal, const char *output, const char *title,
                 int64_t rows) {
  char script[1200], image[1200];
  snprintf(script, sizeof script, "%s/" SCRIPT_NAME, folder);
  snprintf(image, sizeof image, "%s/%s", folder, output);
  struct stat made;
  const bool drawn = write_script(script, terminal, output, title, rows) &&
                     gnuplot_run(folder, SCRIPT_NAME) && stat(image, &made) == 0 &&
                     made.st_size > 0;
  unlink(script);
  if (!drawn)
    unlink(image);
  return drawn;
}

const char *energy_plot_draw(const char *folder, const char *title, int64_t rows) {
  if (draw(folder, "pngcairo size 1200,700 font 'sans,12'", "energy.png", title, rows))
    return "energy.png";
  if (draw(folder, "svg size 1200,700 font 'sans,14' background '#ffffff'", "energy.svg", title,
           rows))
    return "energy.svg";
  return NULL;
}
