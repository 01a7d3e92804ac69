/* A base's motion: FILE.csv or sine:AX,AY,AZ,f=HZ[,from=S][,until=S].
 *
 * A file has four numbers a line: the time [s], then an acceleration [m/s^2] or, where a line of
 * names at its head says so (t,x,y,z), a position [m]. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/base_motion_spec.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "driver/spec/load_spec.h"
#include "io/text.h"
#include "mesh/mesh_grow.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

#define COLUMNS 4
#define BASE_MOTION_TEXT_MAX 512

static const char sine_prefix[] = "sine:";

static thrum_status refuse(const char *text, thrum_error *error) {
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "--base-motion '%.200s': it is a .csv file, or "
                         "sine:AX,AY,AZ,f=HZ[,from=S][,until=S] with AX,AY,AZ in m/s^2",
                         text);
}

static thrum_status parse_sine(const char *text, base_motion_spec *base_motion,
                               thrum_error *error) {
  char body[BASE_MOTION_TEXT_MAX];
  const char *rest = text + sizeof sine_prefix - 1;
  if (strlen(rest) >= sizeof body)
    return refuse(text, error);
  snprintf(body, sizeof body, "%s", rest);

  // the pairs are taken from the right; the amplitude is left
  base_motion->sine = true;
  if (load_course_take(text, body, text, &base_motion->course, NULL) < 0 ||
      !config_parse_vector3(body, base_motion->amplitude))
    return refuse(text, error);
  return THRUM_OK;
}

thrum_status base_motion_parse(const char *text, base_motion_spec *base_motion,
                               thrum_error *error) {
  base_motion_spec parsed = {.text = text};
  if (text[0] == 0)
    return refuse(text, error);
  if (strncmp(text, sine_prefix, sizeof sine_prefix - 1) == 0)
    THRUM_TRY(parse_sine(text, &parsed, error));
  *base_motion = parsed;
  return THRUM_OK;
}

/* --- files ------------------------------------------------------------------------------------ */

/* Whether the present line names columns, and whether those are of positions. */
static thrum_status read_head(thrum_text *text, bool *names, bool *positions) {
  static const char *const known[2][3] = {{"ax", "ay", "az"}, {"x", "y", "z"}};
  thrum_word word;
  double number = 0;
  *positions = false;
  if (!thrum_text_word(text, &word))
    return THRUM_OK;

  // a first word that is a number means that the line has no names
  *names = thrum_text_scan_number(word.text, word.text + word.length, &number) != word.length;
  if (!*names) {
    thrum_text_rewind(text);
    return THRUM_OK;
  }

  // the names tell accelerations from positions; a mix is refused
  bool fits[2] = {thrum_text_equals(word, "t") || thrum_text_equals(word, "time"), false};
  fits[1] = fits[0];
  for (int n = 0; n < 3; n++) {
    const bool more = thrum_text_word(text, &word);
    for (int kind = 0; kind < 2; kind++)
      fits[kind] = fits[kind] && more && thrum_text_equals(word, known[kind][n]);
  }
  if ((!fits[0] && !fits[1]) || thrum_text_more(text))
    return thrum_text_fail(text, THRUM_BAD_FORMAT,
                           "the columns are named t,ax,ay,az (accelerations in m/s^2) or t,x,y,z "
                           "(positions in m)");
  *positions = fits[1];
  return THRUM_OK;
}

static thrum_status read_row(thrum_text *text, const double *before, double row[COLUMNS]) {
  static const char *const what[COLUMNS] = {"the time", "the x column", "the y column",
                                            "the z column"};
  thrum_status status = THRUM_OK;
  for (int n = 0; n < COLUMNS && status >= 0; n++)
    status = thrum_text_number(text, what[n], &row[n]);
  THRUM_THEN(status, thrum_text_finish(text, "the z column"));

  // times ascend, and the first is not before the run begins
  if (status >= 0 && before == NULL && row[0] < 0)
    return thrum_text_fail(text, THRUM_BAD_VALUE, "the time %g s is before the run's start",
                           row[0]);
  if (status >= 0 && before != NULL && !(row[0] > before[0]))
    return thrum_text_fail(text, THRUM_BAD_VALUE,
                           "the time %g s is not later than the %g s before it", row[0], before[0]);
  return status;
}

typedef struct rows {
  double *values; /* count x 4 */
  int64_t count;
  bool positions;
} rows;

static thrum_status read_rows(thrum_text *text, rows *all, thrum_error *error) {
  bool first = true, names = false;
  while (thrum_text_next_line(text)) {
    if (first) {
      first = false;
      THRUM_TRY(read_head(text, &names, &all->positions));
      if (names)
        continue;
    }

    // each row must be later than the one before it
    double row[COLUMNS];
    const double *before = all->count > 0 ? all->values + COLUMNS * (all->count - 1) : NULL;
    THRUM_TRY(read_row(text, before, row));
    if (thrum_mesh_append(&all->values, &all->count, row, sizeof row, NULL) < 0)
      return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %.200s", text->name);
  }

  // a single row says nothing about motion
  if (all->count < 2)
    return thrum_text_fail(text, THRUM_BAD_FORMAT,
                           "a motion has two lines of four numbers or more: t,ax,ay,az");
  return THRUM_OK;
}

/* The motion from its rows. */
static thrum_status make_motion(const rows *all, base_motion_spec *base_motion,
                                thrum_error *error) {
  const int64_t n = all->count;

  // times, accelerations, velocities, positions, and scratch
  double *memory = NULL;
  THRUM_TRY(thrum_reserve(&memory, 11 * n, sizeof *memory, base_motion->text, error));
  double *times = memory, *a = times + n, *v = a + 3 * n, *x = v + 3 * n, *work = x + 3 * n;
  double *given = all->positions ? x : a;

  // the file gives one of accelerations and positions
  for (int64_t k = 0; k < n; k++) {
    times[k] = all->values[COLUMNS * k];
    memcpy(given + 3 * k, all->values + COLUMNS * k + 1, 3 * sizeof *given);
  }

  // the others follow by integration, or by a spline through the positions
  if (all->positions)
    thrum_base_motion_spline(n, times, x, a, v, work);
  else
    thrum_base_motion_integrate(n, times, a, v, x);

  // the check knows numbers alone, so the file's name is put before its text
  base_motion->memory = memory;
  base_motion->motion = (thrum_base_motion){n, times, a, v, x};
  return config_error_in(error, thrum_base_motion_check(&base_motion->motion, error), "%.200s",
                         base_motion->text);
}

thrum_status base_motion_read(base_motion_spec *base_motion, thrum_error *error) {
  thrum_text text;
  rows all = {0};
  if (base_motion->sine || base_motion->memory != NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_text_open(base_motion->text, '#', ',', &text, error));
  thrum_status status = read_rows(&text, &all, error);
  THRUM_THEN(status, make_motion(&all, base_motion, error));
  thrum_text_close(&text);
  free(all.values);
  return status;
}

void base_motion_close(base_motion_spec *base_motion) {
  free(base_motion->memory);
  base_motion->memory = NULL;
}

/* --- both kinds ------------------------------------------------------------------------------- */

void base_motions_mean(const base_motion_spec *base_motions, int64_t count, int64_t step, double dt,
                       double mean[3]) {
  mean[0] = mean[1] = mean[2] = 0;
  for (int64_t n = 0; n < count; n++) {
    // a record is averaged over the step, a sine has its mean in closed form
    double one[3];
    if (!base_motions[n].sine)
      thrum_base_motion_mean(&base_motions[n].motion, step, dt, one);
    const double share =
        base_motions[n].sine ? thrum_load_mean(&base_motions[n].course, step, dt) : 0;
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += base_motions[n].sine ? share * base_motions[n].amplitude[axis] : one[axis];
  }
}

void base_motions_position(const base_motion_spec *base_motions, int64_t count, double time,
                           double position[3]) {
  position[0] = position[1] = position[2] = 0;
  for (int64_t n = 0; n < count; n++) {
    // a record is read at the time, a sine is integrated twice
    double one[3];
    if (!base_motions[n].sine)
      thrum_base_motion_at(&base_motions[n].motion, time, one, NULL);
    const double share =
        base_motions[n].sine ? thrum_base_motion_sine(&base_motions[n].course, time) : 0;
    for (int axis = 0; axis < 3; axis++)
      position[axis] += base_motions[n].sine ? share * base_motions[n].amplitude[axis] : one[axis];
  }
}

double base_motion_end(const base_motion_spec *base_motion) {
  return base_motion->sine ? base_motion->course.until
                           : base_motion->motion.times[base_motion->motion.count - 1];
}
