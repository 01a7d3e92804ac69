/* How a run starts: mode:K,AMPLITUDE (a basis vector, released at rest), static:LOAD (the
 * equilibrium under a load) or FILE.npy (q, or the two rows q and p, such as the end.npy of another
 * run). SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/start_spec.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "core/base/finite.h"
#include "driver/spec/static_solve.h"
#include "io/npy_file.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

static const char mode_prefix[] = "mode:";
static const char static_prefix[] = "static:";

/* static:LOAD, or static:FILE for the file that `thrum static` wrote */
static thrum_status parse_static(const char *text, start_spec *start, thrum_error *error) {
  const char *rest = text + sizeof static_prefix - 1;
  const size_t length = strlen(rest);
  if (length > 4 && strcmp(rest + length - 4, ".npy") == 0 && !load_spec_begins(rest)) {
    start->path = rest;
    return THRUM_OK;
  }

  // otherwise it is a load like those of --load
  thrum_error detail = {0};
  start->kind = START_STATIC;
  const thrum_status status = load_spec_parse(rest, &start->load, &detail);
  if (status < 0)
    return thrum_error_set(error, status, "--start static: takes a load or an .npy file; %s",
                           detail.message);
  return THRUM_OK;
}

thrum_status start_spec_parse(const char *text, start_spec *start, thrum_error *error) {
  start_spec parsed = {.text = text, .path = text};

  // the prefix decides; without one the text names a file
  if (strncmp(text, static_prefix, sizeof static_prefix - 1) == 0) {
    THRUM_TRY(parse_static(text, &parsed, error));
  } else if (strncmp(text, mode_prefix, sizeof mode_prefix - 1) == 0) {
    parsed.kind = START_MODE;
    const char *number = text + sizeof mode_prefix - 1;
    const char *comma = strchr(number, ',');
    char digits[24];
    const size_t length = comma != NULL ? (size_t)(comma - number) : sizeof digits;

    // the mode's number is copied: the parser wants a text that ends
    snprintf(digits, sizeof digits, "%.*s", length < sizeof digits ? (int)length : 0, number);
    if (!config_parse_integer(digits, &parsed.mode) || parsed.mode < 1 ||
        !config_parse_number(comma + 1, &parsed.amplitude))
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--start '%.200s': it is mode:NUMBER,METRES, such as mode:1,0.02",
                             text);
  } else if (text[0] == 0) {
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "--start needs mode:NUMBER,METRES, static:LOAD or the name of an .npy file");
  }

  *start = parsed;
  return THRUM_OK;
}

static thrum_status add_file(const thrum_model *model, const char *path, double *q, double *p,
                             thrum_error *error) {
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  const int64_t rank = model->rank;
  thrum_status status = THRUM_OK;
  THRUM_TRY(thrum_npy_read_f8(path, &values, &rows, &columns, error));

  // a plain vector has no columns: read it as one row
  if (columns == 0) {
    columns = rows;
    rows = 1;
  }

  // the file must be of this model, and hold numbers only
  if (columns != rank || rows < 1 || rows > 2) {
    status = thrum_error_set(
        error, THRUM_BAD_SHAPE,
        "%.200s: %lld x %lld numbers; a start of this model is %lld numbers q, "
        "or 2 x %lld: q, then p",
        path, (long long)rows, (long long)columns, (long long)rank, (long long)rank);
  } else if (!thrum_all_finite(values, rows * rank)) {
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

static thrum_status add_one(const thrum_model *model, const start_spec *start, double *q, double *p,
                            thrum_error *error) {
  if (start->kind == START_FILE)
    return add_file(model, start->path, q, p, error);
  const thrum_status status = thrum_mode_add(model, start->mode - 1, start->amplitude, q, error);
  return config_error_in(error, status, "--start '%.100s'", start->text);
}

/* q = the equilibrium under the loads of all static: starts. */
static thrum_status add_static(const thrum_model *model, const start_spec *starts, int64_t count,
                               double *q, thrum_error *error) {
  load_spec *loads = NULL;
  THRUM_TRY(thrum_reserve(&loads, count, sizeof *loads, "the starts", error));

  // equilibria of a nonlinear body do not add up, so their loads act together
  int64_t used = 0;
  for (int64_t n = 0; n < count; n++)
    if (starts[n].kind == START_STATIC)
      loads[used++] = starts[n].load;

  thrum_status status = THRUM_OK;
  if (used > 0) {
    // the search is silent but for an instability on the way
    const static_problem problem = {.model = model,
                                    .said = "--start static",
                                    .loads = loads,
                                    .count = used,
                                    .def = thrum_default_equilibrium_def()};
    thrum_equilibrium_report report;
    status = static_solve(&problem, q, NULL, &report, error);
    if (status >= 0 && report.instability != THRUM_INSTABILITY_NONE)
      config_warn("--start static: the body %s at %.6g of the load; the run starts from a stable "
                  "shape that it falls to",
                  report.instability == THRUM_INSTABILITY_LIMIT ? "snaps through" : "buckles",
                  report.critical);
  }

  free(loads);
  return status;
}

thrum_status start_specs_make(const thrum_model *model, const start_spec *starts, int64_t count,
                              double *q, double *p, thrum_error *error) {
  thrum_status status = add_static(model, starts, count, q, error);
  for (int64_t n = 0; n < count && status >= 0; n++)
    if (starts[n].kind != START_STATIC)
      status = add_one(model, &starts[n], q, p, error);
  return status;
}
