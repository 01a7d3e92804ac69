/* What `thrum identify` says of a fit; see identify_report.h. SPDX-License-Identifier: Apache-2.0
 */
#include "driver/identify/identify_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/record/run_plot.h"
#include "io/file.h"
#include "io/folder.h"
#include "io/json.h"
#include "thrum/parameters.h"

#define PATH_MAX_HERE 1200
#define QUANTILE 1.96     /* of 95 % */
#define MOVED_WARNED 0.02 /* of a modulus: beyond, its basis may be felt, */
#define MOVED_SHARED 0.03 /* and one that was made for such changes */
#define UNSEEN_FROM 0.5   /* doubt from which a parameter does not show */

/* Does the recording say nothing of it? */
static bool unseen(const identify_parameter *p) {
  return !(p->doubt <= UNSEEN_FROM);
}

const char *identify_flag(const identify_fit *fit) {
  if (!fit->converged)
    return "unconverged";
  if (identify_fit_poor(fit))
    return "poor";
  if (identify_fit_misses(fit))
    return "misfit";
  for (int64_t n = 0; n < fit->count; n++)
    if (unseen(&fit->parameters[n]))
      return "unseen";
  return NULL;
}

static const char *word_of(const identify_fit *fit) {
  const char *flag = identify_flag(fit);
  return flag ? flag : "done";
}

cJSON *identify_report_object(const identify_fit *fit) {
  const identify_request *request = fit->request;
  cJSON *object = json_report("identify", word_of(fit));
  json_string(object, "model", request->model_path);
  json_string(object, "recording", request->recording_path);
  json_number(object, "rows", (double)fit->recording.rows);
  json_number(object, "columns", (double)fit->recording.column_count);
  json_number(object, "dt_s", fit->dt);
  json_number(object, "steps", (double)fit->steps);
  cJSON *list = cJSON_AddArrayToObject(object, "parameters");
  for (int64_t n = 0; n < fit->count; n++) {
    const identify_parameter *p = &fit->parameters[n];
    cJSON *item = json_add_row(list);
    json_string(item, "name", p->name);
    json_string(item, "unit", p->unit);
    json_number(item, "first", p->first);
    json_number(item, "value", p->value);
    json_number(item, "deviation", p->deviation);
    json_numbers(
        item, "interval",
        (const double[]){p->value - QUANTILE * p->deviation, p->value + QUANTILE * p->deviation},
        2);
    json_number(item, "off_by_model", QUANTILE * identify_fit_off(fit, p));
    cJSON_AddBoolToObject(item, "seen", !unseen(p));
  }
  json_number(object, "rms_m", fit->rms);
  json_number(object, "motion_m", fit->motion);
  json_number(object, "repeated_share", fit->repeated);
  json_number(object, "iterations", (double)fit->iterations);
  json_number(object, "runs", (double)fit->runs);
  json_string(object, "output", request->output);
  json_number(object, "seconds", fit->seconds);
  return object;
}

void identify_report_table(const identify_fit *fit) {
  printf("recording    %" PRId64 " rows, %" PRId64 " columns, %.4g m in the mean\n",
         fit->recording.rows, fit->recording.column_count, fit->motion);
  for (int64_t n = 0; n < fit->count; n++) {
    const identify_parameter *p = &fit->parameters[n];
    printf("%-32s %13.6g", p->name, p->value);
    if (isfinite(p->deviation))
      printf(" +- %.3g", QUANTILE * p->deviation);
    if (isfinite(identify_fit_off(fit, p)))
      printf(" (model %.2g)", QUANTILE * identify_fit_off(fit, p));
    printf("%s%s", p->unit[0] != 0 ? " " : "", p->unit);
    printf("%s\n", unseen(p) ? "   (the recording does not show it)" : "");
  }
  printf("left         %.4g m, %.3g %% of the motion", fit->rms, 100 * fit->rms / fit->motion);
  if (fit->repeated > 0)
    printf("; at least %.0f %% of its square is no noise", 100 * fit->repeated);
  printf("\n");
  printf("cost         %.3g s, %" PRId64 " iterations, %" PRId64 " runs of up to %" PRId64
         " steps\n",
         fit->seconds, fit->iterations, fit->runs, fit->steps);
  printf("status       %s\n", word_of(fit));
  if (fit->request->output != NULL)
    printf("files        %s\n", fit->request->output);
}

void identify_report_warn(const identify_fit *fit) {
  double most = 0;
  for (int64_t n = 0; n < fit->count; n++)
    if (fit->parameters[n].kind <= IDENTIFY_POISSON && fit->shares.count > 1)
      most = fmax(most, fabs(fit->parameters[n].value / fit->parameters[n].first - 1));
  const bool shared = thrum_model_parameter_count(fit->model) > 0;
  if (most > (shared ? MOVED_SHARED : MOVED_WARNED))
    config_warn(
        "a modulus moved by %.0f %%: the basis is that of the old one%s, and what is seen "
        "little may be off by half as much; precompute the model %swith the moduli found, and "
        "identify again until they stay",
        100 * most, shared ? " and its first changes" : "", shared ? "" : "with --parameters, or ");
  if (!fit->converged)
    config_warn("the fit has not converged: begin nearer, or allow more --iterations");
  else if (identify_fit_poor(fit))
    config_warn("%.0f %% of the motion is left: the fit explains nothing; look at the start, the "
                "units and the columns",
                100 * fit->rms / fit->motion);
  else if (identify_fit_misses(fit))
    config_warn(
        "%.2g %% of the motion is left, and it is no noise: the model or the start is wrong, "
        "and a value may be off by what stands after `model` and more, not by its interval alone",
        100 * fit->rms / fit->motion);
}

/* --- files ------------------------------------------------------------------------------------ */

typedef struct csv {
  thrum_file_writer writer;
  thrum_status status;
  thrum_error *error;
} csv;

__attribute__((format(printf, 2, 3))) static void put(csv *file, const char *format, ...) {
  char text[LOAD_TEXT_MAX + 64];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  THRUM_THEN(file->status, thrum_file_writer_put(&file->writer, text, strlen(text), file->error));
}

static thrum_status write_fit(const identify_fit *fit, const char *path, thrum_error *error) {
  const recording *rec = &fit->recording;
  csv file = {.error = error};
  THRUM_TRY(thrum_file_writer_open(path, &file.writer, error));
  put(&file, "time_s");
  for (int64_t c = 0; c < rec->column_count; c++)
    put(&file, ",%s", rec->columns[c].name);
  for (int64_t c = 0; c < rec->column_count; c++)
    put(&file, ",fitted %s", rec->columns[c].name);
  put(&file, "\n");
  for (int64_t row = 0; row < rec->rows; row++) {
    put(&file, "%.17g", rec->times[row]);
    for (int64_t c = 0; c < rec->column_count; c++)
      put(&file, ",%.17g", rec->values[row * rec->column_count + c]);
    for (int64_t c = 0; c < rec->column_count; c++)
      put(&file, ",%.17g", fit->fitted[row * rec->column_count + c]);
    put(&file, "\n");
  }
  return thrum_file_writer_end(&file.writer, file.status, error);
}

/* The column that moves most, measured and fitted, and what is left of it. */
static void draw(const identify_fit *fit) {
  const recording *rec = &fit->recording;
  int64_t best = 0;
  double most = -1;
  for (int64_t c = 0; c < rec->column_count; c++) {
    double sum = 0;
    for (int64_t row = 0; row < rec->rows; row++)
      sum += pow(rec->values[row * rec->column_count + c], 2);
    best = sum > most ? c : best;
    most = fmax(sum, most);
  }
  char curves[900], title[600];
  const int measured = (int)best + 2, fitted = measured + (int)rec->column_count;
  snprintf(title, sizeof title, "%.300s: measured and fitted", rec->columns[best].name);
  snprintf(curves, sizeof curves,
           "'fit.csv' every ::1 using 1:%d with points pt 7 ps 0.3 lc rgb '#888888' title "
           "'measured', '' every ::1 using 1:%d with lines lw 1 lc rgb '#1f5fa8' title 'fitted', "
           "'' every ::1 using 1:($%d-$%d) with lines lw 1 lc rgb '#c0392b' title 'left'",
           measured, fitted, measured, fitted);
  const run_plot plot = {.script = "fit.gnuplot",
                         .png = "fit.png",
                         .svg = "fit.svg",
                         .title = title,
                         .vertical = "displacement [m]",
                         .settings = "",
                         .curves = curves};
  run_plot_draw(fit->request->output, &plot);
}

thrum_status identify_files_write(const identify_fit *fit, const char *text, thrum_error *error) {
  const char *folder = fit->request->output;
  char path[PATH_MAX_HERE];
  if (folder == NULL)
    return THRUM_OK;
  THRUM_TRY(folder_make(folder, error));
  snprintf(path, sizeof path, "%s/fit.csv", folder);
  THRUM_TRY(write_fit(fit, path, error));
  snprintf(path, sizeof path, "%s/identify.json", folder);
  THRUM_TRY(thrum_file_write_atomic(path, text, strlen(text), error));
  draw(fit);
  return THRUM_OK;
}
