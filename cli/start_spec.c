/* How a run starts: mode:K,AMPLITUDE (a basis vector, released at rest) or FILE.npy (q, or the two
 * rows q and p, such as the end.npy of another run). SPDX-License-Identifier: Apache-2.0 */
#include "cli/start_spec.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/cli.h"
#include "precompute/npz.h"

static const char mode_prefix[] = "mode:";

thrum_status cli_start_parse(const char *text, cli_start *start, thrum_error *error) {
  cli_start parsed = {.text = text};
  if (strncmp(text, mode_prefix, sizeof mode_prefix - 1) == 0) {
    const char *number = text + sizeof mode_prefix - 1;
    const char *comma = strchr(number, ',');
    char digits[24];
    const size_t length = comma != NULL ? (size_t)(comma - number) : sizeof digits;
    if (length >= sizeof digits) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--start '%.200s': it is mode:NUMBER,METRES, such as mode:1,0.02",
                             text);
    }
    memcpy(digits, number, length);
    digits[length] = 0;
    if (!cli_parse_integer(digits, &parsed.mode) || parsed.mode < 1 ||
        !cli_parse_number(comma + 1, &parsed.amplitude)) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--start '%.200s': it is mode:NUMBER,METRES, such as mode:1,0.02",
                             text);
    }
  } else if (text[0] == 0) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--start needs mode:NUMBER,METRES or the name of an .npy file");
  }
  *start = parsed;
  return THRUM_OK;
}

static bool all_finite(const double *values, int64_t count) {
  for (int64_t i = 0; i < count; i++) {
    if (!isfinite(values[i]))
      return false;
  }
  return true;
}

static thrum_status add_file(const thrum_model *model, const char *path, double *q, double *p,
                             thrum_error *error) {
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  const int64_t rank = model->rank;
  thrum_status status = thrum_npy_read_f8(path, &values, &rows, &columns, error);
  if (status < 0)
    return status;
  // a plain vector has no columns: read it as one row
  if (columns == 0) {
    columns = rows;
    rows = 1;
  }
  if (columns != rank || rows < 1 || rows > 2) {
    status = thrum_error_set(
        error, THRUM_BAD_SHAPE,
        "%.200s: %lld x %lld numbers; a start of this model is %lld numbers q, "
        "or 2 x %lld: q, then p",
        path, (long long)rows, (long long)columns, (long long)rank, (long long)rank);
  } else if (!all_finite(values, rows * rank)) {
    status = thrum_error_set(error, THRUM_BAD_VALUE, "%.200s: a number in it is not finite", path);
  } else {
    for (int64_t i = 0; i < rank; i++) {
      q[i] += values[i];
      p[i] += rows == 2 ? values[rank + i] : 0;
    }
  }
  free(values);
  return status;
}

thrum_status cli_start_add(const thrum_model *model, const cli_start *start, double *q, double *p,
                           thrum_error *error) {
  if (start->mode == 0)
    return add_file(model, start->text, q, p, error);
  thrum_error detail = {0};
  const thrum_status status = thrum_mode_add(model, start->mode - 1, start->amplitude, q, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "--start '%.100s': %s", start->text, detail.message);
  return THRUM_OK;
}
