/* Models, files and plots of `thrum bench step` and `thrum bench kernels`.
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/bench_speed.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "bench/measured_model.h"
#include "config/message.h"
#include "config/progress.h"
#include "driver/record/run_plot.h"
#include "io/file.h"
#include "io/folder.h"
#include "io/json.h"
#include "io/json_table.h"
#include "platform/interrupt.h"

#define MIB 1048576.0

void bench_row_print(const bench_request *request, const cJSON *rows, const char *head, int width,
                     const report_line *lines) {
  if (request->json)
    return;
  if (cJSON_GetArraySize(rows) == 1)
    printf("%s\n", head);
  report_print(cJSON_GetArrayItem(rows, cJSON_GetArraySize(rows) - 1), NULL, width, lines);
}

void bench_report_end(cJSON *report, bool json, const report_line *head, int width,
                      const report_line *lines) {
  if (!json)
    report_print(report, NULL, 0, head);
  report_show(report, NULL, json, width, lines);
}

void bench_row_time(cJSON *row, const char *key, const bench_time *time) {
  char median[80];
  snprintf(median, sizeof median, "%s_median", key);
  json_number(row, key, time->minimum);
  json_number(row, median, time->median);
}

void bench_row_bandwidth(const bench_request *request, cJSON *row, const char *key, double us,
                         double bytes, double operations) {
  char name[80];
  const char *level;
  const double bandwidth = bench_machine_bandwidth(&request->rates, bytes, &level);
  snprintf(name, sizeof name, "%s_gflops", key);
  json_number(row, name, 1e-3 * operations / us);
  snprintf(name, sizeof name, "%s_bound_us", key);
  json_number(row, name, request->machine ? 1e-3 * bytes / bandwidth : NAN);
  snprintf(name, sizeof name, "%s_share_of_fma_peak", key);
  json_number(row, name,
              request->machine ? 1e-3 * operations / us / request->rates.peak_gflops : NAN);
  snprintf(name, sizeof name, "%s_share_of_bandwidth", key);
  json_number(row, name, request->machine ? 1e-3 * bytes / us / bandwidth : NAN);
  snprintf(name, sizeof name, "%s_level", key);
  json_string(row, name, level);
}

/* The rows, behind lines that say where they were measured. */
static thrum_status write_csv(const bench_request *request, const char *path, const cJSON *rows,
                              thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  FILE *file = writer.stream;

  // where the numbers were measured, and how fast that machine is
  fprintf(file, "# %s; %s; thrum %s; kernel %s\n", bench_processor(), bench_build(),
          thrum_version(), thrum_kernel_name(thrum_kernel_chosen(request->kernel)));
  if (request->machine)
    fprintf(file,
            "# measured: FMA peak %.1f GFLOP/s; L2 of %.3g MiB %.1f, L3 of %.3g MiB %.1f, DRAM "
            "%.1f GB/s\n",
            request->rates.peak_gflops, request->rates.l2_bytes / MIB, request->rates.l2_gbs,
            request->rates.l3_bytes / MIB, request->rates.l3_gbs, request->rates.dram_gbs);

  return thrum_file_writer_end(&writer, json_table_csv(file, rows, error), error);
}

/* The name of a curve for people: "us_tangent_vector" is "tangent vector". */
static void name_curve(const char *column, char name[64]) {
  snprintf(name, 64, "%s", strncmp(column, "us_", 3) == 0 ? column + 3 : column);
  for (char *c = name; *c != 0; c++)
    *c = *c == '_' ? ' ' : *c;
}

static bool write_script(const bench_request *request, const char *path, const char *name,
                         const char *const *curves) {
  // dark enough for a white page, and each with a mark of its own
  static const char *const colours[] = {"#1769aa", "#b0430f", "#2e8b57", "#7b3fb3", "#111111"};
  FILE *file = fopen(path, "w");
  if (file == NULL)
    return false;
  fprintf(file,
          "set encoding utf8\n"
          "set terminal pngcairo size 1000,700 font 'sans,12'\nset output '%s.png'\n"
          "set datafile separator ','\nset logscale xy\nset grid lc rgb '#dddddd' lt 1\n"
          "set key above\nset xrange [*:*] noextend\nset offsets graph 0.03, graph 0.03, 0, 0\n"
          "set xlabel 'rank'\nset ylabel 'time [µs]'\nset xtics (5,10,15,20,30,40,50,60,80,100)\n"
          "set title '%s, %s' noenhanced\n",
          name, request->command, bench_processor());
  for (int n = 0; curves[n]; n++) {
    char label[64];
    name_curve(curves[n], label);
    fprintf(file,
            "%s '%s.csv' using 'rank':'%s' with linespoints lw 1.6 pt %d ps 1.2 lc rgb '%s' title "
            "'%s' noenhanced",
            n == 0 ? "plot" : ",", name, curves[n], 4 + n,
            colours[n % (int)(sizeof colours / sizeof colours[0])], label);
  }
  fputc('\n', file);
  return fclose(file) == 0;
}

/* The curves, microseconds against rank, both logarithmic. */
static void plot(const bench_request *request, const char *name, const char *const *curves) {
  char script[64], path[1200];
  snprintf(script, sizeof script, "%s.gp", name);
  snprintf(path, sizeof path, "%s/%s", request->folder, script);
  const bool drawn =
      write_script(request, path, name, curves) && gnuplot_run(request->folder, script);
  unlink(path);
  if (!drawn)
    config_warn("no plot: gnuplot is missing or failed, or THRUM_GNUPLOT is empty");
}

static thrum_status write_files(const bench_request *request, const cJSON *rows,
                                const char *const *curves, thrum_error *error) {
  const char *name = request->command + strlen("bench ");
  char path[1200];
  snprintf(path, sizeof path, "%.1000s/%s.csv", request->folder, name);
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");
  THRUM_TRY(write_csv(request, path, rows, error));
  plot(request, name, curves);
  return THRUM_OK;
}

static thrum_status run_rank(const bench_request *request, int64_t n, bench_run *run, cJSON *rows,
                             thrum_error *error) {
  thrum_model *model = NULL;
  thrum_status status = bench_model_beam(request->ranks[n], &model, error);
  THRUM_THEN(status, run(request, model, rows, error));
  bench_model_free(model);
  return status;
}

static void print_machine(const bench_request *request) {
  printf("%s; %s\n", bench_processor(), bench_build());
  if (request->machine)
    printf("one core: FMA peak %.1f GFLOP/s; reads from L2 of %.3g MiB %.1f, from L3 of %.3g MiB "
           "%.1f, from DRAM %.1f GB/s\n",
           request->rates.peak_gflops, request->rates.l2_bytes / MIB, request->rates.l2_gbs,
           request->rates.l3_bytes / MIB, request->rates.l3_gbs, request->rates.dram_gbs);
}

/* The row itself when there is one, else an object of rows; the machine with either. */
static void print_json(const bench_request *request, cJSON *rows) {
  cJSON *object =
      cJSON_GetArraySize(rows) == 1 ? cJSON_DetachItemFromArray(rows, 0) : cJSON_CreateObject();
  if (cJSON_GetArraySize(rows) > 0)
    cJSON_AddItemToObject(object, "rows", rows);
  else
    cJSON_Delete(rows);

  // with the machine on which it was measured
  json_string(object, "processor", bench_processor());
  json_string(object, "build", bench_build());
  if (request->machine) {
    json_number(object, "peak_gflops", request->rates.peak_gflops);
    json_number(object, "l2_bytes", request->rates.l2_bytes);
    json_number(object, "l3_bytes", request->rates.l3_bytes);
    json_number(object, "l2_gbs", request->rates.l2_gbs);
    json_number(object, "l3_gbs", request->rates.l3_gbs);
    json_number(object, "dram_gbs", request->rates.dram_gbs);
  }
  json_print(object);
}

int bench_each_model(bench_request *request, bench_run *run, const char *const *curves) {
  thrum_error error = {.status = THRUM_OK};
  // before the measurement, which may be long
  thrum_status status = request->folder ? folder_make(request->folder, &error) : THRUM_OK;
  if (status < 0)
    return config_refuse(&error);

  const thrum_model *given = NULL;
  if (request->model_path)
    status = thrum_model_load(request->model_path, &given, &error);
  const int64_t count = given ? 1 : request->rank_count;
  for (int64_t n = 0; n < count && status >= 0; n++)
    status = bench_check_implicit(given ? given->rank : request->ranks[n],
                                  request->step.implicit_wanted, &error);
  if (status < 0) {
    thrum_model_destroy(given);
    return config_refuse(&error);
  }

  cJSON *rows = cJSON_CreateArray();
  config_progress progress = config_progress_make(request->quiet);
  bench_machine_caches(&request->rates);
  if (request->machine)
    bench_machine_measure(&request->rates);
  if (!request->json)
    print_machine(request);

  // each model gives one row
  for (int64_t n = 0; n < count && status >= 0; n++) {
    config_progress_update(&progress, "ranks", (double)n / (double)count);
    status = given ? run(request, given, rows, &error) : run_rank(request, n, run, rows, &error);
  }

  thrum_model_destroy(given);
  config_progress_end(&progress, status >= 0);

  if (status >= 0 && request->folder)
    status = write_files(request, rows, curves, &error);
  if (status >= 0 && request->json)
    print_json(request, rows);
  else
    cJSON_Delete(rows);
  return status >= 0 ? COMMAND_DONE : config_refuse(&error);
}
