/* Plots of what a run writes.
 *
 * gnuplot runs inside the folder on fixed names, so that no path of the user's is ever quoted in
 * its script; only the title is, in single quotes, where a quote is written twice.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_plot.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "platform/program.h"

void run_plot_quote(const char *text, size_t most, char quoted[RUN_PLOT_QUOTED]) {
  size_t used = 0;
  for (size_t n = 0; n < most && n < RUN_PLOT_TEXT && text[n] != 0; n++) {
    const unsigned char byte = (unsigned char)text[n];
    if (byte < ' ' || byte == 127)
      continue;
    if (byte == '\'')
      quoted[used++] = '\'';
    quoted[used++] = (char)byte;
  }
  quoted[used] = 0;
}

static bool write_script(const char *path, const run_plot *plot, const char *terminal,
                         const char *output) {
  char quoted[RUN_PLOT_QUOTED];
  run_plot_quote(plot->title, RUN_PLOT_TEXT, quoted);
  FILE *file = fopen(path, "w");
  if (file == NULL)
    return false;

  // axes and colours, the same for every plot; a key in the margin covers no curve
  fprintf(file,
          "set encoding utf8\n"
          "set terminal %s\n"
          "set output '%s'\n"
          "set datafile separator ','\n"
          "set title '%s' noenhanced offset 0,1.4\n"
          "set xlabel 'time [s]'\n"
          "set ylabel '%s'\n"
          "set autoscale xfix\n"
          "set grid lc rgb '#dddddd' lt 1\n"
          "set border lc rgb '#555555'\n"
          "set tmargin 5\n"
          "set rmargin 4\n"
          "set key at graph 0.5, graph 1.05 center horizontal samplen 3\n"
          "%s"
          "plot %s\n",
          terminal, output, quoted, plot->vertical, plot->settings, plot->curves);

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

static bool draw(const char *folder, const run_plot *plot, const char *terminal,
                 const char *output) {
  char script[1200], image[1200];
  snprintf(script, sizeof script, "%s/%s", folder, plot->script);
  snprintf(image, sizeof image, "%s/%s", folder, output);
  struct stat made;
  const bool drawn = write_script(script, plot, terminal, output) &&
                     gnuplot_run(folder, plot->script) && stat(image, &made) == 0 &&
                     made.st_size > 0;
  unlink(script);
  if (!drawn)
    unlink(image);
  return drawn;
}

const char *run_plot_draw(const char *folder, const run_plot *plot) {
  if (draw(folder, plot, "pngcairo size 1200,700 font 'sans,12'", plot->png))
    return plot->png;
  if (draw(folder, plot, "svg size 1200,700 font 'sans,14' background '#ffffff'", plot->svg))
    return plot->svg;
  return NULL;
}
