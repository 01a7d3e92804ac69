/* Reads the folder of a curve back; see response_read.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_read.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "driver/record/run_read.h"
#include "driver/response/response_files.h"
#include "io/json.h"
#include "io/npy_file.h"
#include "io/paths.h"
#include "io/text.h"
#include "platform/allocate.h"

/* Columns of response.csv that are read; the last one is there where there is a target. */
enum { COLUMN_KIND = 1, COLUMN_FREQUENCY = 2, COLUMN_UNSTABLE = 3, COLUMN_PEAK = 12 };

bool is_curve_folder(const char *path) {
  recorded_path file;
  struct stat info;
  recorded_path_join(file, path, RESPONSE_JSON);
  return stat(file, &info) == 0 && S_ISREG(info.st_mode);
}

void recorded_curve_free(recorded_curve *curve) {
  thrum_model_destroy(curve->model);
  free(curve->model_path);
  free(curve->frequency);
  free(curve->peak);
  free(curve->unstable);
  free(curve->kind);
  free(curve->motion);
  *curve = (recorded_curve){0};
}

bool recorded_curve_holds(const char *folder, const recorded_curve *curve, const char *path) {
  static const char *const names[] = {RESPONSE_JSON, RESPONSE_CSV, RESPONSE_COEFFICIENTS,
                                      RESPONSE_MOTIONS};
  return recorded_folder_holds(folder, names, sizeof names / sizeof *names, path) ||
         path_same_file(path, curve->model_path);
}

/* Column n of a line, between commas; empty where the line ends before it. */
static thrum_word column(thrum_word line, int n) {
  const char *at = line.text, *const end = line.text + line.length;
  const char *comma = NULL;
  for (; n >= 0 && at <= end; n--) {
    comma = memchr(at, ',', (size_t)(end - at));
    comma = comma != NULL ? comma : end;
    if (n == 0)
      return (thrum_word){at, (size_t)(comma - at)};
    at = comma + 1;
  }
  return (thrum_word){end, 0};
}

/* A number of the present line; NaN, which no row has where it is read, if there is none. */
static double number(thrum_word line, int n) {
  const thrum_word word = column(line, n);
  double value = NAN;
  if (word.length == 0 || thrum_text_scan_number(word.text, word.text + word.length, &value) == 0)
    return NAN;
  return value;
}

static int32_t kind_of(thrum_word word) {
  for (int32_t kind = 0; thrum_response_kind_name(kind) != NULL; kind++)
    if (thrum_text_equals(word, thrum_response_kind_name(kind)))
      return kind;
  return -1;
}

/* The columns of response.csv, a line for each row of the motions. */
static thrum_status read_rows(const char *folder, recorded_curve *curve, thrum_error *error) {
  recorded_path path;
  thrum_text text = {0};
  const size_t rows = (size_t)curve->rows;
  THRUM_TRY(
      thrum_reserve(&curve->frequency, curve->rows, sizeof *curve->frequency, "the curve", error));
  THRUM_TRY(thrum_reserve(&curve->peak, curve->rows, sizeof *curve->peak, "the curve", error));
  THRUM_TRY(
      thrum_reserve(&curve->unstable, curve->rows, sizeof *curve->unstable, "the curve", error));
  THRUM_TRY(thrum_reserve(&curve->kind, curve->rows, sizeof *curve->kind, "the curve", error));
  recorded_path_join(path, folder, RESPONSE_CSV);
  THRUM_TRY(thrum_text_open(path, 0, 0, &text, error));
  thrum_text_next_line(&text); // names

  thrum_status status = THRUM_OK;
  size_t row = 0;
  for (; status >= 0 && thrum_text_next_line(&text); row++) {
    const thrum_word line = thrum_text_line(&text);
    const double frequency = number(line, COLUMN_FREQUENCY);
    const double unstable = number(line, COLUMN_UNSTABLE);
    const int32_t kind = kind_of(column(line, COLUMN_KIND));
    if (row == rows || !(frequency > 0) || isnan(unstable) || kind < 0) {
      status =
          thrum_text_fail(&text, THRUM_BAD_VALUE,
                          "this is no row of the %" PRId64 " motions of the curve", curve->rows);
      break;
    }
    curve->frequency[row] = frequency;
    curve->unstable[row] = (int32_t)unstable;
    curve->kind[row] = kind;
    curve->peak[row] = curve->target[0] != 0 ? number(line, COLUMN_PEAK) : NAN;
  }
  if (status >= 0 && row != rows)
    status = thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: %zu rows, but there are %" PRId64 " motions", path, row,
                             curve->rows);
  thrum_text_close(&text);
  return status;
}

/* The motions of all coordinates; those of a model of which none follow are its coefficients. */
static thrum_status read_motions(const char *folder, const cJSON *object, recorded_curve *curve,
                                 thrum_error *error) {
  const double rank = (double)curve->model->rank, moving = json_number_of(object, "coordinates");
  recorded_path path;
  int64_t columns = 0;
  recorded_path_join(path, folder, moving < rank ? RESPONSE_MOTIONS : RESPONSE_COEFFICIENTS);
  THRUM_TRY(thrum_npy_read_f8(path, &curve->motion, &curve->rows, &columns, error));

  // an odd number of terms for each coordinate: the mean, cosines and sines
  const int64_t terms = columns / curve->model->rank;
  if (curve->rows < 1 || terms % 2 != 1 || terms * curve->model->rank != columns)
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.200s: %" PRId64 " x %" PRId64 " numbers are no motions of a model of "
                           "rank %" PRId64,
                           path, curve->rows, columns, curve->model->rank);
  curve->harmonics = terms / 2;
  for (int64_t n = 0; n < curve->rows * columns; n++)
    if (!isfinite(curve->motion[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE, "%.200s: row %" PRId64 " is not finite", path,
                             n / columns + 1);
  return THRUM_OK;
}

thrum_status recorded_curve_read(const char *path, recorded_curve *curve, thrum_error *error) {
  recorded_curve read = {0};
  recorded_path file;
  cJSON *object = NULL;
  model_hash hash = {0};
  recorded_path_join(file, path, RESPONSE_JSON);
  THRUM_TRY(json_file_read(file, &object, error));
  const char *name = json_text_of(object, "model");
  const double periods = json_number_of(object, "periods");
  const cJSON *at = cJSON_GetObjectItemCaseSensitive(object, "at");
  const char *target = cJSON_GetStringValue(cJSON_GetArrayItem(at, 0));
  thrum_status status = THRUM_OK;
  if (name == NULL || !model_hash_read(object, &hash) || !(periods >= 1 && periods < 1e9))
    status = thrum_error_set(error, THRUM_BAD_FORMAT,
                             "%.300s: not the response.json of this version of `thrum response`; "
                             "find the curve again",
                             file);
  snprintf(read.target, sizeof read.target, "%s", target != NULL ? target : "");
  THRUM_THEN(status,
             recorded_model_load(path, name, &hash, false, &read.model, &read.model_path, error));
  if (status >= 0 && read.model->basis == NULL)
    status =
        thrum_error_set(error, THRUM_MISSING,
                        "%.200s: the model has no basis, so nothing can be shown", read.model_path);
  read.periods = status >= 0 ? (int64_t)periods : 0;
  THRUM_THEN(status, read_motions(path, object, &read, error));
  THRUM_THEN(status, read_rows(path, &read, error));
  cJSON_Delete(object);
  if (status < 0)
    recorded_curve_free(&read);
  else
    *curve = read;
  return status;
}
