/* A recorded motion from a CSV file; see recording.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/identify/recording.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "platform/allocate.h"

#define COLUMNS_MAX 4096
#define PASSED_OVER (-2)
#define TIME (-1)

/* Which column of the recording each of the file is. */
typedef struct head {
  int place[COLUMNS_MAX];
  int count;
  bool timed;
} head;

/* "tip.z_m" as a column; false where the name is none. */
static bool read_name(const char *name, size_t length, recording_column *column) {
  static const char *const axes[] = {".x_m", ".y_m", ".z_m"};
  thrum_error error = {0};
  if (length < 5 || length >= LOAD_TEXT_MAX)
    return false;
  for (int axis = 0; axis < 3; axis++) {
    if (strncmp(name + length - 4, axes[axis], 4) != 0)
      continue;
    char text[LOAD_TEXT_MAX];
    snprintf(text, sizeof text, "%.*s", (int)(length - 4), name);

    // the file has blanks where commas would end a column: near:X Y Z
    for (char *c = text; *c != 0; c++)
      *c = *c == ' ' ? ',' : *c;
    column->axis = axis;
    snprintf(column->name, sizeof column->name, "%.*s", (int)length, name);
    return load_target_parse(text, "the column", &column->target, &error) >= 0;
  }
  return false;
}

static thrum_status read_head(thrum_text *text, recording *found, head *h) {
  THRUM_TRY(thrum_text_need_line(text, "the names of the columns"));
  for (const char *at = text->start;; at++) {
    const char *end = at;
    while (end < text->end && *end != ',')
      end++;
    const size_t length = (size_t)(end - at);
    if (h->count == COLUMNS_MAX)
      return thrum_text_fail(text, THRUM_BAD_FORMAT, "it has more than %d columns", COLUMNS_MAX);
    int *place = &h->place[h->count++];
    *place = PASSED_OVER;
    if ((length == 6 && strncmp(at, "time_s", 6) == 0) ||
        (length == 4 && strncmp(at, "time", 4) == 0)) {
      *place = TIME;
      h->timed = true;
    } else if (found->column_count < RECORDING_COLUMNS_MAX &&
               read_name(at, length, &found->columns[found->column_count])) {
      *place = (int)found->column_count++;
    }
    at = end;
    if (end >= text->end)
      break;
  }
  if (!h->timed || found->column_count == 0)
    return thrum_text_fail(text, THRUM_BAD_FORMAT,
                           "its names are to have time_s, and TARGET.x_m, TARGET.y_m or TARGET.z_m "
                           "of one target at least");
  return THRUM_OK;
}

/* A number that has its cell, up to `end`, to itself. */
static thrum_status read_cell(thrum_text *text, const char *end, const char *what, double *value) {
  const char *const line_end = text->end;
  text->end = end;
  THRUM_TRY(thrum_text_number(text, what, value));
  THRUM_TRY(thrum_text_finish(text, what));
  text->end = line_end;
  return THRUM_OK;
}

/* Commas alone end a cell: one that is passed over may be empty, or have blanks. */
static thrum_status read_row(thrum_text *text, const head *h, recording *found) {
  double *values = found->values + found->rows * found->column_count;
  const char *end = text->start;
  for (int c = 0; c < h->count; c++, end++) {
    if (end > text->end)
      return thrum_text_fail(text, THRUM_BAD_FORMAT, "it has fewer columns than names");
    text->at = end;
    while (end < text->end && *end != ',')
      end++;
    if (h->place[c] == TIME)
      THRUM_TRY(read_cell(text, end, "the time", &found->times[found->rows]));
    else if (h->place[c] != PASSED_OVER)
      THRUM_TRY(read_cell(text, end, "a displacement", &values[h->place[c]]));
  }
  if (end <= text->end)
    return thrum_text_fail(text, THRUM_BAD_FORMAT, "it has more columns than names");

  // time goes on
  const double time = found->times[found->rows];
  if (time < 0 || (found->rows > 0 && !(time > found->times[found->rows - 1])))
    return thrum_text_fail(text, THRUM_BAD_VALUE,
                           "its time is %g s: times begin at 0 or later, and ascend", time);
  found->rows++;
  return THRUM_OK;
}

thrum_status recording_read(const char *path, recording *found, thrum_error *error) {
  thrum_text text;
  memset(found, 0, sizeof *found);
  THRUM_TRY(thrum_text_open(path, '#', ',', &text, error));
  head *h = NULL;
  int64_t lines = 1;
  for (const char *at = text.next; at < text.stop; at++)
    lines += *at == '\n' ? 1 : 0;
  thrum_status status = thrum_reserve(&h, 1, sizeof *h, "the recording", error);
  THRUM_THEN(status, read_head(&text, found, h));
  THRUM_THEN(status,
             thrum_reserve(&found->times, lines, sizeof *found->times, "the recording", error));
  THRUM_THEN(status, thrum_reserve(&found->values, lines * found->column_count,
                                   sizeof *found->values, "the recording", error));
  while (status >= 0 && thrum_text_next_line(&text))
    status = read_row(&text, h, found);
  if (status >= 0 && found->rows < 3)
    status = thrum_error_set(error, THRUM_BAD_FORMAT, "%.300s has %lld rows: 3 or more are needed",
                             path, (long long)found->rows);
  free(h);
  thrum_text_close(&text);
  return status;
}

void recording_free(recording *found) {
  free(found->times);
  free(found->values);
  found->times = found->values = NULL;
}
