/* The plot of probes: what gnuplot is given has all curves whole, whatever probes are named, and
 * few points of long runs. A script stands for gnuplot and keeps what it is given.
 * SPDX-License-Identifier: Apache-2.0 */
#define _DEFAULT_SOURCE // setenv

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "driver/record/run_plot.h"
#include "driver/run/run_probes.h"
#include "tests/support/test_folder.h"

enum { PROBES = 7, CURVES = 6 };

static int make_gnuplot(void **state) {
  if (make_folder(state) != 0)
    return -1;
  const char *path = in_folder("gnuplot.sh");
  const bool made = text_file_write(path, "#!/bin/sh\ncp \"$2\" kept.gp && echo a > probes.png\n");
  return made && chmod(path, 0700) == 0 && setenv("THRUM_GNUPLOT", path, 1) == 0 ? 0 : -1;
}

/* The script that is drawn for probes of this name after so many rows; the caller frees it. */
static char *script_of(const char *name, int64_t rows) {
  run_probe list[PROBES] = {{.text = ""}};
  run_folder at = {.work = ""};
  run_probes probes = {.list = list, .count = PROBES, .row_count = rows};
  for (int n = 0; n < PROBES; n++)
    snprintf(list[n].text, sizeof list[n].text, "%s", name);
  snprintf(at.work, sizeof at.work, "%s", folder);
  run_probes_plot(&probes, &at, "a run");
  assert_non_null(probes.plot);
  assert_string_equal(probes.plot, "probes.png");
  char *script = text_file_read(in_folder("kept.gp"));
  assert_non_null(script);
  return script;
}

static int count_of(const char *text, const char *word) {
  int count = 0;
  for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word))
    count++;
  return count;
}

static void names_of_quotes_leave_all_curves_whole(void **state) {
  (void)state;
  char quotes[60];
  memset(quotes, '\'', sizeof quotes - 1);
  quotes[sizeof quotes - 1] = 0;
  char *script = script_of(quotes, 10);
  assert_int_equal(count_of(script, "' noenhanced, \\\n"), CURVES - 1);
  assert_int_equal(count_of(script, "' noenhanced\n"), 1);
  assert_int_equal(count_of(script, " every 1::1 "), CURVES);
  free(script);
}

static void long_series_are_thinned(void **state) {
  (void)state;
  char *script = script_of("tip", 10 * RUN_PLOT_POINTS);
  assert_int_equal(count_of(script, " every 11::1 "), CURVES);
  free(script);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(names_of_quotes_leave_all_curves_whole),
      cmocka_unit_test(long_series_are_thinned),
  };
  return cmocka_run_group_tests(tests, make_gnuplot, remove_folder);
}
