/* Reads the tables of earlier long runs back, so that what is done need not be done again.
 *
 * The tables say all that a report needs; a row that is cut short, as by a full disk, is left out.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "validation/experiments/run_outcome.h"
#include "validation/experiments/tables.h"

#define FIELDS_MAX 40
#define LINE_MAX 1024
#define LEVELS_FROM 19 /* the first column of the fallback levels, after the counts of steps */

/* Cuts a line at its commas, in place; how many fields. */
static int cut(char *line, char *fields[FIELDS_MAX]) {
  int count = 0;
  for (char *at = line; at != NULL && count < FIELDS_MAX; count++) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma = 0;
    fields[count] = at;
    at = comma != NULL ? comma + 1 : NULL;
  }
  return count;
}

/* Copies the next line of a text into `line`, without its end; NULL after the last whole one. */
static const char *next_line(const char *text, char line[LINE_MAX]) {
  const char *end = strchr(text, '\n');
  if (end == NULL)
    return NULL;
  const size_t length = (size_t)(end - text) < LINE_MAX - 1 ? (size_t)(end - text) : LINE_MAX - 1;
  memcpy(line, text, length);
  line[length] = 0;
  return end + 1;
}

static double number(const char *field) {
  return field[0] != 0 ? strtod(field, NULL) : NAN;
}

/* Whether fields 0 to 2 of a row name this case. */
static bool names_case(char *const *fields, const experiment_long_case *run) {
  return strcmp(fields[0], run->body->name) == 0 &&
         strcmp(fields[1], experiment_scheme_names[run->scheme]) == 0 &&
         fabs(number(fields[2]) - run->amplitude) < 1e-9;
}

/* Takes a row with the columns of experiment_long_rows; false where it is of another run. */
static bool take_row(char *const *fields, experiment_long_case *run,
                     experiment_long_result *result) {
  const double steps = number(fields[LEVELS_FROM - 2]);
  if (!names_case(fields, run) || fabs(number(fields[5]) - run->dt) > 1e-12 ||
      !(steps >= 1 && steps <= (double)run->steps))
    return false;

  // a run that was not lost counts only when all of its steps are there; why one was lost is said
  // by the text of a status
  const bool lost = strcmp(fields[6], "lost") == 0;
  static const thrum_status ends[] = {THRUM_NOT_CONVERGED, THRUM_NOT_FINITE};
  if (!lost && (strcmp(fields[6], "done") != 0 || steps != (double)run->steps))
    return false;
  result->lost = lost && strcmp(fields[7], experiment_reason(THRUM_OK, true)) == 0;
  for (size_t n = 0; n < sizeof ends / sizeof ends[0] && lost && !result->lost; n++)
    if (strcmp(fields[7], experiment_reason(ends[n], false)) == 0)
      result->status = ends[n];
  if (lost && !result->lost && result->status == THRUM_OK)
    return false;

  run->reached = number(fields[3]);
  run->impulse = number(fields[4]);
  result->report.steps = (int64_t)steps;
  result->us_per_step = number(fields[8]);
  result->energy = number(fields[9]);
  result->window_count = (int64_t)number(fields[10]);
  result->total_change = number(fields[11]);
  result->total_worst = number(fields[12]);
  result->high_change = number(fields[13]);
  result->high_slope = number(fields[14]);
  result->high_slope_error = number(fields[15]);
  result->high_slope_error_correlated = number(fields[16]);
  for (int n = 0; n < EXPERIMENT_LEVEL_COUNT; n++)
    experiment_level_set(&result->report, n, (int64_t)number(fields[LEVELS_FROM + n]));
  return true;
}

/* The means of the windows of one case; false unless all are there. */
static bool take_windows(const char *windows, const experiment_long_case *run,
                         experiment_long_result *result) {
  char line[LINE_MAX], *fields[FIELDS_MAX];
  int64_t found = 0;
  for (const char *at = next_line(windows, line); at != NULL; at = next_line(at, line)) {
    if (cut(line, fields) != 7 || !names_case(fields, run))
      continue;
    if (found == result->window_count || number(fields[3]) != (double)found)
      return false;
    result->total[found] = number(fields[5]);
    result->high[found++] = number(fields[6]);
  }
  return found == result->window_count;
}

/* Takes one case from the tables, if they hold all of it. */
static bool read_case(const char *table, const char *windows, experiment_long_case *run,
                      experiment_long_result *result) {
  char line[LINE_MAX], *fields[FIELDS_MAX];
  experiment_long_case known = *run;
  experiment_long_result made = {0};
  bool found = false;
  for (const char *at = next_line(table, line); at != NULL && !found; at = next_line(at, line))
    found = cut(line, fields) >= LEVELS_FROM + EXPERIMENT_LEVEL_COUNT &&
            take_row(fields, &known, &made);
  if (!found || made.window_count < 0 || made.window_count > run->steps)
    return false;

  // the two rows of means share one allocation
  made.total = calloc((size_t)(2 * made.window_count + 1), sizeof *made.total);
  if (made.total == NULL)
    return false;
  made.high = made.total + made.window_count;
  if (!take_windows(windows, run, &made)) {
    experiment_long_result_free(&made);
    return false;
  }

  *run = known;
  *result = made;
  return true;
}

void experiment_tables_read_long(const char *table, const char *windows, experiment_long *runs) {
  for (int64_t n = 0; n < runs->count; n++)
    atomic_store(&runs->done[n], read_case(table, windows, &runs->cases[n], &runs->results[n]));
}
