/* The files of a curve; see response_files.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_files.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "driver/record/run_plot.h"
#include "io/file.h"
#include "io/folder.h"
#include "io/npy_file.h"
#include "io/paths.h"
#include "platform/allocate.h"

#define PATH_MAX_HERE 1200

/* --- response.csv ----------------------------------------------------------------------------- */

typedef struct csv {
  thrum_file_writer writer;
  thrum_status status;
  thrum_error *error;
} csv;

__attribute__((format(printf, 2, 3))) static void put(csv *file, const char *format, ...) {
  char text[128];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  THRUM_THEN(file->status, thrum_file_writer_put(&file->writer, text, strlen(text), file->error));
}

static void put_head(csv *file, const response_curve *c) {
  put(file, "point,kind,frequency_hz,unstable,multiplier_re,multiplier_im,energy_j,work_j,"
            "dissipated_j,tail,residual,arc");
  for (int64_t n = 1; n <= c->target_count; n++) {
    put(file, ",peak%" PRId64 "_m", n);
    for (int axis = 0; axis < 3; axis++) {
      const char letter = "xyz"[axis];
      put(file, ",%c%" PRId64 "_mean_m", letter, n);
      for (int64_t k = 1; k <= c->harmonics; k++)
        put(file, ",%c%" PRId64 "_h%" PRId64 "_m,%c%" PRId64 "_h%" PRId64 "_deg", letter, n, k,
            letter, n, k);
    }
  }
  put(file, "\n");
}

static void put_row(csv *file, const response_curve *c, int64_t row) {
  const thrum_response_point *point = &c->rows[row].point;
  const double *multiplier = c->rows[row].multiplier;
  put(file, "%" PRId64 ",%s,%.17g,%d", row + 1, thrum_response_kind_name(point->kind),
      point->omega / THRUM_TWO_PI, (int)point->unstable);
  if (isnan(multiplier[0]))
    put(file, ",nan,nan");
  else
    put(file, ",%.10g,%.10g", multiplier[0], multiplier[1]);
  put(file, ",%.17g,%.17g,%.17g", point->energy, point->work, point->dissipated);
  put(file, ",%.3g,%.3g,%.9g", point->tail, point->residual, point->arc);
  for (int64_t n = 0; n < c->target_count; n++) {
    put(file, ",%.10g", c->peak[row * c->target_count + n]);
    for (int axis = 0; axis < 3; axis++) {
      const int64_t count = 2 * c->harmonics + 1;
      put(file, ",%.10g", c->harmonic[((row * c->target_count + n) * 3 + axis) * count]);
      for (int64_t k = 1; k <= c->harmonics; k++) {
        double phase = 0;
        const double amplitude = response_curve_amplitude(c, row, n, axis, k, &phase);
        put(file, ",%.10g,%.6g", amplitude, phase * 180 / THRUM_PI);
      }
    }
  }
  put(file, "\n");
}

static thrum_status write_csv(const response_curve *c, const char *path, thrum_error *error) {
  csv file = {.error = error};
  THRUM_TRY(thrum_file_writer_open(path, &file.writer, error));
  put_head(&file, c);
  for (int64_t row = 0; row < c->count; row++)
    put_row(&file, c, row);
  return thrum_file_writer_end(&file.writer, file.status, error);
}

/* --- the others ------------------------------------------------------------------------------- */

static thrum_status write_starts(const response_curve *c, const char *folder, thrum_error *error) {
  const int64_t rank = c->shape->rank;
  double *state = NULL;
  THRUM_TRY(thrum_reserve(&state, 2 * rank, sizeof *state, "a start", error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < c->request->start_count && status >= 0; n++) {
    char path[PATH_MAX_HERE];
    const int64_t point = c->request->starts[n];
    response_curve_state(c, point - 1, state, state + rank);
    snprintf(path, sizeof path, "%s/point_%" PRId64 ".npy", folder, point);
    status = thrum_npy_write_f8(path, state, 2, rank, error);
  }
  free(state);
  return status;
}

/* Where some coordinates follow, the series of all of them, from which the body can be shown. */
static thrum_status write_motions(const response_curve *c, const char *folder, thrum_error *error) {
  const int64_t width = (4 * c->harmonics + 1) * c->shape->rank;
  char path[PATH_MAX_HERE];
  double *rows = NULL;
  if (c->shape == c->stepped)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&rows, c->count * width, sizeof *rows, "the motions", error));
  for (int64_t row = 0; row < c->count; row++)
    response_curve_shape(c, row, rows + row * width);
  snprintf(path, sizeof path, "%s/" RESPONSE_MOTIONS, folder);
  const thrum_status status = thrum_npy_write_f8(path, rows, c->count, width, error);
  free(rows);
  return status;
}

static void draw(const response_curve *c, const char *folder) {
  char title[300], curves[900];
  if (c->target_count == 0)
    return;
  const char *what = c->request->mode > 0 ? "backbone" : "response";
  snprintf(title, sizeof title, "%s of %s: %s", what, path_basename(c->request->model_path),
           c->at[0]);

  // stable motions in full, unstable ones dashed, special points marked; a gap is a change of kind
  snprintf(
      curves, sizeof curves,
      "'response.csv' every ::1 using 3:($4==0||$4==-1?$13:NaN) with lines lw 2 lc rgb '#1f5fa8' "
      "title 'stable', "
      "'' every ::1 using 3:($4>0?$13:NaN) with lines lw 2 dt 2 lc rgb '#c0392b' title 'unstable', "
      "'' every ::1 using 3:(strcol(2) eq 'fold'?$13:NaN) with points pt 7 lc rgb '#222222' title "
      "'fold', "
      "'' every ::1 using 3:(strcol(2) eq 'Neimark-Sacker'?$13:NaN) with points pt 5 lc rgb "
      "'#8e44ad' title 'Neimark-Sacker', "
      "'' every ::1 using 3:(strcol(2) eq 'period doubling'?$13:NaN) with points pt 9 lc rgb "
      "'#27ae60' title 'period doubling'");
  const run_plot plot = {.script = "response.gnuplot",
                         .png = "response.png",
                         .svg = "response.svg",
                         .title = title,
                         .vertical = "largest displacement [m]",
                         .settings = "set xlabel 'frequency [Hz]'\n",
                         .curves = curves};
  run_plot_draw(folder, &plot);
}

thrum_status response_files_write(const response_curve *curve, const char *text,
                                  thrum_error *error) {
  const char *folder = curve->request->output;
  char path[PATH_MAX_HERE];
  if (folder == NULL)
    return THRUM_OK;

  // what cannot be written is refused before anything is
  for (int64_t n = 0; n < curve->request->start_count; n++)
    if (curve->request->starts[n] > curve->count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "--start %" PRId64 ": the curve has points 1 to %" PRId64,
                             curve->request->starts[n], curve->count);
  THRUM_TRY(folder_make(folder, error));
  snprintf(path, sizeof path, "%s/" RESPONSE_CSV, folder);
  THRUM_TRY(write_csv(curve, path, error));
  snprintf(path, sizeof path, "%s/" RESPONSE_COEFFICIENTS, folder);
  THRUM_TRY(thrum_npy_write_f8(path, curve->coefficients, curve->count,
                               (2 * curve->harmonics + 1) * curve->stepped->rank, error));
  THRUM_TRY(write_motions(curve, folder, error));
  snprintf(path, sizeof path, "%s/" RESPONSE_JSON, folder);
  THRUM_TRY(thrum_file_write_atomic(path, text, strlen(text), error));
  draw(curve, folder);
  return write_starts(curve, folder, error);
}
